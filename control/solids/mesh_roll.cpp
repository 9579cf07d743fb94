// The short way of a ball over one triangle.
#include <algorithm>
#include <cmath>

#include "control/solids/mesh.h"
#include "control/solids/mesh_near.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/near_triangles.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

// Of a triangle that the ball touches, with one corner at the origin.
struct Touched {
  Vec3 ab, ac, normal;
};

// The centre of the ball that touches the triangle and is nearest to the target. False where the target does not tell.
bool place_on(const Touched& face, const Vec3& target, const BallRoll& ball, Vec3& centre, Vec3& normal) {
  const float height_m = face.normal.dot(target);
  if (!ball.hold && height_m >= ball.radius_m) return false;
  const Vec3 over = target - nearest_on_triangle(face.ab, face.ac, target);
  const float over2 = over.squaredNorm();
  // Beside the face by no more than rounding, or by a direction that makes no difference: for a target that is deeper than the radius, a
  // direction does.
  constexpr float kRounding_m = 1.0e-7F;
  constexpr float kSame2 = 1.0e-5F;
  const float above_m = std::max(height_m, 0.0F);
  if ((over - height_m * face.normal).squaredNorm() <=
      kRounding_m * kRounding_m + kSame2 * above_m * above_m) {
    normal = face.normal;
    centre = target + (ball.radius_m - height_m) * normal;
    return true;
  }
  if (!(height_m > 0.0F) || (!ball.hold && over2 >= ball.radius_m * ball.radius_m)) return false;
  const float over_m = std::sqrt(over2);
  normal = over / over_m;
  centre = target + (ball.radius_m - over_m) * normal;
  return true;
}

// A ball on its way, straight.
struct Way {
  Vec3 from, to;  // centres
  float radius_m;
  float reach_m;

  // Whether it stays in front of the triangle, or behind a face that is solid from one side only, or away from it.
  [[nodiscard]] bool passes(const MeshView& mesh, const NearTriangle& one) const {
    const float here_m = one.normal.dot(from - one.middle_m);
    const float there_m = one.normal.dot(to - one.middle_m);
    if (here_m >= radius_m && there_m >= radius_m) return true;
    if (one.two_sided ? here_m <= -radius_m && there_m <= -radius_m : here_m < 0.0F) return true;
    const Vec3 a = vertex(mesh, one.triangle, 0);
    const Vec3 ab = vertex(mesh, one.triangle, 1) - a;
    const Vec3 ac = vertex(mesh, one.triangle, 2) - a;
    const float apart_m = radius_m + reach_m;
    return (from - a - nearest_on_triangle(ab, ac, from - a)).squaredNorm() > apart_m * apart_m;
  }
};

// Whether all triangles near the ball pass, but for those that lie behind the face that it rolls on.
template <typename Passes>
bool all_near(const ShapeData& shape, const BallRoll& ball, float reach_m, bool on_face, const Vec3& normal,
              const Passes& passes) {
  const MeshView& mesh = shape.mesh;
  NearTriangles* const near =
      ball.triangles == nullptr
          ? nullptr
          : ball.triangles->near(shape, ball.work, ball.centre_m, ball.radius_m, reach_m);
  if (near == nullptr) {
    GridBall grid;
    return !grid.about(mesh, ball.centre_m, ball.radius_m + reach_m) ||
           for_each_near(
               mesh, ball.work,
               [&](const GridPoint& lo, const GridPoint& hi) {
                 return grid.meets(lo, hi) && grid.is_near(lo, hi);
               },
               [&](std::uint32_t one) { return passes(in_disc(mesh, one)); });
  }
  if (!on_face) {
    for (const NearTriangle& one : near->list())
      if (!passes(one)) return false;
    return true;
  }
  const auto before = near->before(mesh, ball.feature.index, ball.feature.side, normal);
  for (const std::uint8_t i : before)
    if (!passes(near->list()[i])) return false;
  return true;
}

}  // namespace

bool roll_on_mesh(const ShapeData& shape, BallRoll& ball) {
  const MeshView& mesh = shape.mesh;
  if (roll_within_rims(mesh, ball)) return true;
  const std::uint32_t triangle = ball.feature.index;
  const Vec3 a = vertex(mesh, triangle, 0);
  Touched face{vertex(mesh, triangle, 1) - a, vertex(mesh, triangle, 2) - a, {}};
  const Vec3 area = face.ab.cross(face.ac);
  const float length = area.norm();
  if (!(length > 0.0F)) return false;
  face.normal = (ball.feature.side > 0 ? area : Vec3(-area)) / length;

  Vec3 centre;
  Vec3 normal;
  if (!place_on(face, ball.target_m - a, ball, centre, normal)) return false;
  // A chord of the way round an edge passes the edge this much nearer than the radius.
  const Vec3 from = ball.centre_m - a;
  const Vec3 foot = centre - ball.radius_m * normal;
  if (normal.dot(from - foot) < ball.radius_m - kBehind_m) return false;

  const float reach_m = (centre - from).norm() + kTouchGap_m;
  const Way way{ball.centre_m, a + centre, ball.radius_m, reach_m};
  const bool on_face = normal == face.normal;
  const float offset_m = normal.dot(on_face ? a : Vec3(a + foot));
  // What lies behind the plane under the ball is never touched.
  const auto passes = [&](const NearTriangle& one) {
    return one.triangle == triangle ||
           !one.within(way.from, way.radius_m + reach_m + kDiscRounding_m, kDiscRounding_m) ||
           way.passes(mesh, one) || lies_behind(mesh, one.triangle, normal, offset_m);
  };
  if (!all_near(shape, ball, reach_m + kDiscRounding_m, on_face, normal, passes)) return false;
  ball.centre_m = way.to;
  ball.normal = normal;
  return true;
}

}  // namespace thimble::control
