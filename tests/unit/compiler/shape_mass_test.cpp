// Centre of mass and inertia of meshes at uniform density, against closed forms; and what of it reaches the image.
#include "host-tools/compiler/shape_mass.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using host::ShapeMass;
using host::TriangleSoup;

// A box in an oracle: its mass, its size, its centre. A negative mass is a cavity.
struct Block {
  double mass_kg;
  Vector3d size_m;
  Vector3d centre_m;
};

Matrix3d of_point(const Vector3d& p) { return p.squaredNorm() * Matrix3d::Identity() - p * p.transpose(); }

// The closed form of blocks together, for 1 kg.
ShapeMass mass_of_blocks(const std::vector<Block>& blocks) {
  ShapeMass sum;
  double mass = 0;
  for (const Block& b : blocks) {
    mass += b.mass_kg;
    sum.centre_m += b.mass_kg * b.centre_m;
  }
  sum.centre_m /= mass;
  for (const Block& b : blocks) {
    const Vector3d s = b.size_m.cwiseAbs2();
    const Vector3d own = Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()) / 12;
    sum.inertia_m2 += b.mass_kg / mass * (Matrix3d(own.asDiagonal()) + of_point(b.centre_m - sum.centre_m));
  }
  return sum;
}

ShapeMass turned_mass(const ShapeMass& mass, const Matrix3d& by, const Vector3d& offset_m) {
  return {by * mass.centre_m + offset_m, by * mass.inertia_m2 * by.transpose()};
}

TriangleSoup with_part(TriangleSoup a, const TriangleSoup& b, bool inside_out = false) {
  const auto first = static_cast<std::uint32_t>(a.vertices_m.size());
  a.vertices_m.insert(a.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  for (auto t : b.triangles) {
    if (inside_out) std::swap(t[0], t[1]);
    a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  return a;
}

TriangleSoup shifted(const TriangleSoup& soup, const Vector3d& by_m) {
  return transformed(soup, Matrix3d::Identity(), by_m);
}

const std::vector<Eigen::Vector2d> kAngle = {{0, 0}, {.04, 0}, {.04, .01}, {.01, .01}, {.01, .06}, {0, .06}};
const std::vector<Block> kAngleBlocks = {{.04 * .01, {.04, .02, .01}, {.02, 0, .005}},
                                         {.01 * .05, {.01, .02, .05}, {.005, 0, .035}}};

struct Weighed {
  std::string what;
  TriangleSoup soup;
  ShapeMass expected;
};

std::vector<Weighed> weighed_solids() {
  const double a = .03, b = .05, c = .08;
  const TriangleSoup corner{
      {{0, 0, 0}, {a, 0, 0}, {0, b, 0}, {0, 0, c}}, {{{0, 2, 1}}, {{0, 1, 3}}, {{0, 3, 2}}, {{1, 2, 3}}}, {}};
  // Of x in the tetrahedron: the mean of x^2 is a^2 / 10, of x y it is a b / 20.
  const Vector3d sides(a, b, c);
  const Matrix3d second = sides * sides.transpose() / 20 + Matrix3d(sides.cwiseAbs2().asDiagonal()) / 20 -
                          sides * sides.transpose() / 16;
  const ShapeMass tetrahedron{sides / 4, second.trace() * Matrix3d::Identity() - second};
  const Vector3d size(.02, .04, .06);
  const Vector3d off(.1, -.2, .3);
  return {
      {"tetrahedron", corner, tetrahedron},
      {"box off its origin", shifted(box_mesh(size, 2), off), mass_of_blocks({{1, size, off}})},
      {"angle of two boxes", prism(kAngle, .02, 2), mass_of_blocks(kAngleBlocks)},
      {"dumbbell of two parts",
       with_part(shifted(box_mesh({.02, .02, .02}, 1), {.05, 0, 0}),
                 shifted(box_mesh({.04, .02, .01}, 1), {-.05, .01, 0})),
       mass_of_blocks({{8, {.02, .02, .02}, {.05, 0, 0}}, {8, {.04, .02, .01}, {-.05, .01, 0}}})},
      {"box with a cavity",
       with_part(box_mesh({.06, .06, .06}, 1), shifted(box_mesh({.02, .02, .02}, 1), {.015, .01, 0}), true),
       mass_of_blocks({{216, {.06, .06, .06}, Vector3d::Zero()}, {-8, {.02, .02, .02}, {.015, .01, 0}}})},
  };
}

TEST(ShapeMass, OfClosedMeshesIsTheClosedForm) {
  const Matrix3d turn = Eigen::AngleAxisd(1.1, Vector3d(1, -2, .7).normalized()).toRotationMatrix();
  for (const Weighed& each : weighed_solids()) {
    for (const auto& [by, offset] :
         {std::pair(Matrix3d(Matrix3d::Identity()), Vector3d(0, 0, 0)),
          std::pair(turn, Vector3d(.3, .2, -.1)), std::pair(turn, Vector3d(9, -9, 9))}) {
      const host::CompiledMesh mesh = host::compile_mesh(transformed(each.soup, by, offset), {}, each.what);
      const auto mass = host::volume_mass(mesh);
      ASSERT_TRUE(mass.has_value()) << each.what;
      const ShapeMass expected = turned_mass(each.expected, by, offset);
      const double centre = (mass->centre_m - expected.centre_m).norm();
      const double inertia = (mass->inertia_m2 - expected.inertia_m2).norm() / expected.inertia_m2.norm();
      const double float_m = 6e-8 * expected.centre_m.norm();  // of the vertices in the image
      figure(each.what + " at " + std::to_string(offset.norm()) + " m: centre off by, nm", 1e9 * centre,
             "< " + std::to_string(1e9 * (float_m + 1e-8)));
      figure(each.what + ": inertia off by", inertia, "< 2e-6, 2e-4 at 16 m");
      EXPECT_LT(centre, float_m + 1e-8) << each.what;
      EXPECT_LT(inertia, offset.norm() > 1 ? 2e-4 : 2e-6) << each.what;

      const host::PrincipalInertia principal = host::principal_inertia(mass->inertia_m2);
      const Matrix3d axes = principal.axes.toRotationMatrix();
      const Matrix3d again = axes * principal.moments.asDiagonal() * axes.transpose();
      EXPECT_LT((again - mass->inertia_m2).norm(), 3e-6 * again.norm()) << each.what;
    }
  }
}

TEST(ShapeMass, OfAnOpenMeshIsThatOfItsSurface) {
  TriangleSoup plate = transformed(sheet(.06, 3), Matrix3d::Identity(), {.1, 0, .2});
  const host::CompiledMesh open = host::compile_mesh(plate, {}, "plate");
  EXPECT_FALSE(host::volume_mass(open).has_value());
  const ShapeMass of_plate = host::surface_mass(open);
  const ShapeMass expected = mass_of_blocks({{1, {.06, .06, 0}, {.1, 0, .2}}});
  EXPECT_LT((of_plate.centre_m - expected.centre_m).norm(), 1e-8);
  EXPECT_LT((of_plate.inertia_m2 - expected.inertia_m2).norm(), 1e-6 * expected.inertia_m2.norm());

  // An open box: a bottom and four sides.
  TriangleSoup box = box_mesh({.06, .04, .02}, 2);
  std::erase_if(box.triangles, [&](const auto& t) {
    return box.vertices_m[t[0]].z() + box.vertices_m[t[1]].z() + box.vertices_m[t[2]].z() > .029;
  });
  const ShapeMass of_box = host::surface_mass(host::compile_mesh(box, {}, "open box"));
  const ShapeMass sides = mass_of_blocks({{.06 * .04, {.06, .04, 0}, {0, 0, -.01}},
                                          {.06 * .02, {.06, 0, .02}, {0, .02, 0}},
                                          {.06 * .02, {.06, 0, .02}, {0, -.02, 0}},
                                          {.04 * .02, {0, .04, .02}, {.03, 0, 0}},
                                          {.04 * .02, {0, .04, .02}, {-.03, 0, 0}}});
  figure("open box: centre off by, nm", 1e9 * (of_box.centre_m - sides.centre_m).norm(), "< 10");
  EXPECT_LT((of_box.centre_m - sides.centre_m).norm(), 1e-8);
  EXPECT_LT((of_box.inertia_m2 - sides.inertia_m2).norm(), 1e-6 * sides.inertia_m2.norm());
}

class MassInTheImage : public ::testing::Test {
 protected:
  host::CompiledScene compiled(const TriangleSoup& soup, const std::string& body) {
    write_obj(soup, 1.0, folder_.path() / "mesh.obj");
    return host::compile_scene_text(
        R"({"thimble_scene": 1, "name": "x", "objects": [{"name": "it", "material": {"stiffness_N_m": 100},
            "shape": {"mesh": {"file": "mesh.obj"}}, "body": {"mass_kg": 2, )" +
            body + "}}]}",
        "x", folder_.path());
  }
  static const scene::Body& body_of(const host::CompiledScene& scene) {
    control::SceneView view;
    EXPECT_EQ(control::SceneView::check(scene.image, view), control::ImageStatus::kOk);
    return *view.scene()->objects()->Get(0)->body();
  }
  static Vector3d to_vector(const scene::Vec3& v) {
    return Eigen::Vector3f(v.x(), v.y(), v.z()).cast<double>();
  }

  TemporaryFolder folder_;
};

TEST_F(MassInTheImage, IsThatOfTheMesh) {
  const ShapeMass expected = mass_of_blocks(kAngleBlocks);
  const host::CompiledScene scene = compiled(prism(kAngle, .02, 1), R"("motion": "free")");
  EXPECT_TRUE(scene.report.warnings.empty());
  const scene::Body& body = body_of(scene);
  ASSERT_NE(body.centre_m(), nullptr);
  ASSERT_NE(body.principal_axes(), nullptr);
  EXPECT_LT((to_vector(*body.centre_m()) - expected.centre_m).norm(), 1e-8);
  const scene::Quat& q = *body.principal_axes();
  const Matrix3d axes = Eigen::Quaternionf(q.w(), q.x(), q.y(), q.z()).cast<double>().toRotationMatrix();
  const Matrix3d tensor = axes * to_vector(*body.inertia_kg_m2()).asDiagonal() * axes.transpose();
  EXPECT_LT((tensor - 2 * expected.inertia_m2).norm(), 1e-6 * tensor.norm());
}

TEST_F(MassInTheImage, FollowsTheKeysOfTheBody) {
  const ShapeMass shape = mass_of_blocks(kAngleBlocks);
  // The frame's origin, as of a scene before the key: the moments are about it.
  const host::CompiledScene origin =
      compiled(prism(kAngle, .02, 1), R"("motion": "free", "centre_m": [0, 0, 0])");
  EXPECT_EQ(body_of(origin).centre_m(), nullptr);
  EXPECT_NEAR(static_cast<double>(to_vector(*body_of(origin).inertia_kg_m2()).sum()),
              2 * (shape.inertia_m2 + of_point(shape.centre_m)).trace(), 1e-8);
  // Moments are about the axes of the object.
  const host::CompiledScene given = compiled(
      prism(kAngle, .02, 1), R"("motion": "free", "centre_m": [0.01, 0, 0.02], "inertia_kg_m2": [1, 2, 3])");
  EXPECT_EQ(body_of(given).principal_axes(), nullptr);
  EXPECT_EQ(to_vector(*body_of(given).inertia_kg_m2()), Vector3d(1, 2, 3));
  EXPECT_EQ(body_of(given).centre_m()->z(), .02F);
  // No rotation: neither is needed, whatever the mesh is like.
  const host::CompiledScene translates = compiled(sheet(.06, 2), R"("motion": "translate")");
  EXPECT_EQ(body_of(translates).centre_m(), nullptr);
  EXPECT_TRUE(translates.report.warnings.empty() ||
              translates.report.warnings[0].find("spread") == std::string::npos);
  // A mesh on its own axes, as a box: the same image as of the box, exactly.
  const host::CompiledScene block = compiled(box_mesh({.02, .04, .06}, 1), R"("motion": "free")");
  const scene::Vec3& box = *body_of(block).inertia_kg_m2();
  EXPECT_FLOAT_EQ(box.x(), 2.0F * (.04F * .04F + .06F * .06F) / 12.0F);
}

TEST_F(MassInTheImage, OfAnOpenMeshIsThatOfItsSurfaceWithAWarning) {
  const host::CompiledScene scene =
      compiled(transformed(sheet(.06, 3), Matrix3d::Identity(), {.1, 0, .2}), R"("motion": "free")");
  EXPECT_THAT(scene.report.warnings,
              testing::Contains(testing::HasSubstr("encloses no volume, so its mass is spread evenly")));
  EXPECT_LT((to_vector(*body_of(scene).centre_m()) - Vector3d(.1, 0, .2)).norm(), 1e-7);
}

TEST_F(MassInTheImage, IsCheckedByTheController) {
  const host::CompiledScene scene = compiled(prism(kAngle, .02, 1), R"("motion": "free")");
  const scene::Body& body = body_of(scene);
  const auto refused = [&](const void* place, float value) {
    std::vector<std::byte> bytes = scene.image;
    std::memcpy(bytes.data() + (static_cast<const std::byte*>(place) - scene.image.data()), &value,
                sizeof value);
    control::SceneView view;
    return control::SceneView::check(bytes, view) != control::ImageStatus::kOk;
  };
  EXPECT_FALSE(refused(body.centre_m(), .5F));
  EXPECT_TRUE(refused(body.centre_m(), 11.0F));
  EXPECT_TRUE(refused(body.centre_m(), std::numeric_limits<float>::quiet_NaN()));
  EXPECT_TRUE(refused(body.principal_axes(), 2.0F));
  EXPECT_TRUE(refused(body.principal_axes(), std::numeric_limits<float>::quiet_NaN()));
}

}  // namespace
}  // namespace thimble::test
