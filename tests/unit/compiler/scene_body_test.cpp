// `body` and `gravity_m_s2` of a scene file: what reaches the image, moments of inertia, and every error with
// its position.
#include "host-tools/compiler/scene_body.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

std::string scene_with(const std::string& shape, const std::string& body, const std::string& more = "") {
  return R"({"thimble_scene": 1, "name": "x", "objects": [
{"name": "it", "material": {"stiffness_N_m": 1000}, "pose": {"position_m": [0.1, 0, 0]},
"shape": {)" +
         shape + R"(}, "body": )" + body + "}]" + more + "}";
}

constexpr const char* kBox = R"("box": {"size_m": [0.02, 0.04, 0.06]})";

TEST(SceneBody, ReadsEveryKeyIntoTheImage) {
  const host::CompiledScene compiled = host::compile_scene_text(
      scene_with(
          kBox,
          R"({"motion": "free", "mass_kg": 0.12, "inertia_kg_m2": [1e-4, 2e-4, 3e-4], "restitution": 0.5,
        "velocity_m_s": [1, 2, 3], "spin_rad_s": [4, 5, 6], "spring_N_m": 7, "damping_N_s_m": 8, "angular_damping_N_m_s": 9})",
          R"(, "gravity_m_s2": [0, 0, -9.81], "tip_radius_m": 0.002)"),
      "x", ".");
  control::SceneView view;
  ASSERT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
  EXPECT_EQ(view.scene()->gravity_m_per_s2()->z(), -9.81F);
  EXPECT_EQ(view.scene()->tip_radius_m(), 0.002F);
  const scene::Body& body = *view.scene()->objects()->Get(0)->body();
  EXPECT_EQ(body.motion(), scene::Motion::Free);
  EXPECT_EQ(body.mass_kg(), .12F);
  EXPECT_EQ(body.inertia_kg_m2()->y(), 2e-4F);
  EXPECT_EQ(body.restitution(), .5F);
  EXPECT_EQ(body.velocity_m_per_s()->x(), 1.0F);
  EXPECT_EQ(body.spin_rad_per_s()->z(), 6.0F);
  EXPECT_EQ(body.spring_n_per_m(), 7.0F);
  EXPECT_EQ(body.damping_n_s_per_m(), 8.0F);
  EXPECT_EQ(body.angular_damping_n_m_s(), 9.0F);
}

TEST(SceneBody, AxisAndPivotHaveTheirDefaults) {
  const auto body = [](const std::string& text) {
    const host::CompiledScene compiled = host::compile_scene_text(scene_with(kBox, text), "x", ".");
    control::SceneView view;
    EXPECT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
    return *view.scene()->objects()->Get(0)->body()->axis();
  };
  EXPECT_EQ(body(R"({"motion": "plane", "mass_kg": 1})").z(), 1.0F);
  EXPECT_EQ(body(R"({"motion": "turn", "mass_kg": 1, "axis": [0, -3, 0]})").y(), -1.0F);
}

// The solid that a profile of (distance from the axis, z) encloses when it turns about the z axis, from its top to its bottom.
host::TriangleSoup revolved(const std::vector<Eigen::Vector2d>& profile_m) {
  constexpr std::uint32_t kSides = 200;
  host::TriangleSoup soup;
  soup.vertices_m = {Vector3d(0, 0, profile_m.front().y()), Vector3d(0, 0, profile_m.back().y())};
  std::uint32_t rings = 0;
  for (const Eigen::Vector2d& ring : profile_m) {
    if (ring.x() == 0.0) continue;  // an end on the axis
    ++rings;
    for (std::uint32_t i = 0; i < kSides; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / kSides;
      soup.vertices_m.emplace_back(ring.x() * std::cos(angle), ring.x() * std::sin(angle), ring.y());
    }
  }
  for (std::uint32_t i = 0; i < kSides; ++i) {
    const std::uint32_t next = (i + 1) % kSides;
    soup.triangles.push_back({0, 2 + i, 2 + next});
    for (std::uint32_t upper = 2; upper < 2 + (rings - 1) * kSides; upper += kSides) {
      const std::uint32_t lower = upper + kSides;
      soup.triangles.push_back({upper + i, lower + i, lower + next});
      soup.triangles.push_back({upper + i, lower + next, upper + next});
    }
    const std::uint32_t last = 2 + (rings - 1) * kSides;
    soup.triangles.push_back({1, last + next, last + i});
  }
  return soup;
}

std::vector<Eigen::Vector2d> capsule_profile(double radius_m, double height_m) {
  constexpr int kSteps = 100;
  std::vector<Eigen::Vector2d> profile;
  for (const double cap : {1.0, -1.0}) {
    for (int i = 0; i <= kSteps; ++i) {
      const int step = cap > 0.0 ? i : kSteps - i;
      if (step == 0) continue;  // the axis
      const double angle = 0.5 * std::numbers::pi * step / kSteps;
      profile.emplace_back(radius_m * std::sin(angle), cap * (0.5 * height_m + radius_m * std::cos(angle)));
    }
  }
  return profile;
}

TEST(SceneBody, MomentsOfInertiaAreThoseOfTheShape) {
  // The oracle: the closed meshes of the shapes, whose centre of mass and moments come from their triangles.
  struct Case {
    std::string shape;
    host::TriangleSoup soup;
    double tolerance;
  };
  const std::vector<Case> cases = {
      {R"("box": {"size_m": [0.02, 0.04, 0.06]})", box_mesh({.02, .04, .06}, 2), 1e-6},
      {R"("sphere": {"radius_m": 0.03})", icosphere(4, .03), 5e-3},
      {R"("cylinder": {"radius_m": 0.02, "height_m": 0.05})", revolved({{.02, .025}, {.02, -.025}}), 5e-4},
      {R"("capsule": {"radius_m": 0.02, "height_m": 0.05})", revolved(capsule_profile(.02, .05)), 5e-4},
      {R"("capsule": {"radius_m": 0.02, "height_m": 0.00001})", revolved(capsule_profile(.02, 1e-5)), 5e-4},
      {R"("cone": {"radius_m": 0.03, "height_m": 0.08})", revolved({{0, .06}, {.03, -.02}}), 5e-4},
  };
  for (const Case& each : cases) {
    const host::CompiledScene compiled =
        host::compile_scene_text(scene_with(each.shape, R"({"motion": "free", "mass_kg": 2})"), "x", ".");
    control::SceneView view;
    ASSERT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
    const scene::Vec3& given = *view.scene()->objects()->Get(0)->body()->inertia_kg_m2();
    const Vector3d moments = Eigen::Vector3f(given.x(), given.y(), given.z()).cast<double>();
    const auto mesh = host::volume_mass(host::compile_mesh(each.soup, {}, "mesh"));
    ASSERT_TRUE(mesh.has_value()) << each.shape;
    const Eigen::Matrix3d given_tensor = moments.asDiagonal();
    const double apart = (given_tensor - 2.0 * mesh->inertia_m2).norm() / moments.norm();
    figure(each.shape + ": moments against those of its mesh", apart, std::to_string(each.tolerance));
    EXPECT_LT(apart, each.tolerance) << each.shape;
    EXPECT_LT(mesh->centre_m.norm(), 1e-6) << each.shape;  // the origin is the centre of mass
  }
}

TEST(SceneBody, EachMistakeIsNamedWithItsPlace) {
  struct Case {
    std::string text;
    std::string name;
    std::string cause;
  };
  const auto with = [](const std::string& key, const std::string& motion = "free") {
    return scene_with(kBox, R"({"motion": ")" + motion + R"(", "mass_kg": 0.1, )" + key + "}");
  };
  std::string many = R"({"thimble_scene": 1, "name": "x", "objects": [)";
  for (int i = 0; i < 17; ++i) {
    many +=
        std::string(i == 0 ? "" : ",") + R"({"name": ")" + std::to_string(i) +
        R"(", "material": {"stiffness_N_m": 1000}, "shape": {"sphere": {"radius_m": 0.01}}, "body": {"motion": "free", "mass_kg": 1}})";
  }
  const std::vector<Case> cases = {
      {scene_with(R"("plane": {"normal": [0, 0, 1]})", R"({"motion": "free", "mass_kg": 1})"), "no-mass",
       "/objects/0/body belongs to a plane"},
      {many + "]}", "too-many-bodies", "/objects/16/body is the scene's body number 17, at most 16"},
      {scene_with(kBox, "3"), "bad-value", "/objects/0/body is 3"},
      {scene_with(kBox, "{}"), "missing-key", "has no \"motion\""},
      {scene_with(kBox, R"({"motion": "free"})"), "missing-key", "has no \"mass_kg\""},
      {scene_with(kBox, R"({"motion": "fly", "mass_kg": 1})"), "bad-value", "/motion is \"fly\""},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 0})"), "bad-value", "/mass_kg is 0"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": null})"), "bad-value", "/mass_kg is null"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 0.002})")
           .replace(scene_with(kBox, "").find("1000"), 4, "5000"),
       "body-too-light", "a mass of 0.002 kg, at least 0.005 kg are needed; its surface is up to 5000.0 N/m"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 0.04})")
           .replace(scene_with(kBox, "").find("1000"), 4,
                    R"(100, "stiffness_map": {"stiffness_N_m": [[100, 100], [100, 50000]], "cell_m": 0.01})"),
       "body-too-light",
       "/objects/0/body has a mass of 0.04 kg, at least 0.05 kg are needed; its surface is up to 50000.0 "
       "N/m"},
      {with(R"("inertia_kg_m2": [1, 1e-9, 1])"), "body-too-light",
       "/objects/0/body/inertia_kg_m2/1 is 1e-09"},
      {with(R"("mass": 1)"), "unknown-key", "/body/mass is not a key"},
      {with(R"("inertia_kg_m2": [1, 1, 0])"), "bad-value", "/inertia_kg_m2/2 is 0"},
      {with(R"("inertia_kg_m2": 1)"), "bad-value", "/inertia_kg_m2 is 1"},
      {with(R"("restitution": 1.1)"), "bad-value", "/restitution is 1.1"},
      {with(R"("velocity_m_s": [0, 0, 11])"), "bad-value", "/velocity_m_s/2 is 11"},
      {with(R"("spin_rad_s": [-101, 0, 0])"), "bad-value", "/spin_rad_s/0 is -101"},
      {with(R"("spring_N_m": 100001)"), "bad-value", "/spring_N_m is 100001"},
      {with(R"("damping_N_s_m": -1)"), "bad-value", "/damping_N_s_m is -1"},
      {with(R"("angular_damping_N_m_s": 1001)"), "bad-value", "/angular_damping_N_m_s is 1001"},
      {with(R"("axis": [0, 0, 0])", "slide"), "bad-value", "/axis is [0,0,0]"},
      {scene_with(kBox, R"({"motion": "turn", "mass_kg": 1})"), "missing-key", "has no \"axis\""},
      {with(R"("centre_m": [0, 0, 11])"), "bad-value", "/centre_m/2 is 11"},
      {with(R"("centre_m": [0, 0, 0.001])", "translate"), "senseless-key", "/centre_m has no meaning"},
      {with(R"("axis": [0, 0, 1])"), "senseless-key", "/axis has no meaning, for motion is \"free\""},
      {with(R"("axis": [0, 0, 1], "pivot_m": [0, 0, 0])", "slide"), "senseless-key", "/pivot_m"},
      {with(R"("axis": [0, 0, 1], "pivot_m": [0, 0, 11])", "turn"), "bad-value", "/pivot_m/2 is 11"},
      {with(R"("axis": [0, 0, 1], "velocity_m_s": [0, 0, 1])", "turn"), "senseless-key", "/velocity_m_s"},
      {with(R"("spin_rad_s": [0, 0, 1])", "translate"), "senseless-key", "/spin_rad_s"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 1})", R"(, "gravity_m_s2": [0, 0, -11])"),
       "bad-value", "/gravity_m_s2/2 is -11"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 1})", R"(, "tip_radius_m": 0.011)"), "bad-value",
       "/tip_radius_m is 0.011"},
      {scene_with(kBox, R"({"motion": "free", "mass_kg": 1})", R"(, "tip_radius_m": 0.00009)"), "bad-value",
       "/tip_radius_m is 9e-05, allowed is 0, or from 0.0001"},
  };
  for (const Case& each : cases) {
    try {
      static_cast<void>(host::compile_scene_text(each.text, "test.scene.json", "."));
      ADD_FAILURE() << "not refused: " << each.cause;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, each.name) << error.cause;
      EXPECT_THAT(error.cause, testing::HasSubstr(each.cause));
    }
  }
  figure("kinds of mistakes in bodies tried", static_cast<double>(cases.size()),
         "each refused with its place");
}

}  // namespace
}  // namespace thimble::test
