#include "control/surfaces/chart.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thimble::control {
namespace {

// Within 1e-7 of the angle of (x, y), from -pi to pi; 0 at the origin. Our own, as libm's differs from one target to the next.
// Abramowitz and Stegun 4.4.49.
float angle(float y, float x) noexcept {
  const float ax = std::abs(x);
  const float ay = std::abs(y);
  const float most = std::max(ax, ay);
  if (!(most > 0.0F)) return 0.0F;
  const float t = std::min(ax, ay) / most;
  const float z = t * t;
  float a = t + t * z *
                    (-0.3333314528F +
                     z * (0.1999355085F +
                          z * (-0.1420889944F +
                               z * (0.1065626393F +
                                    z * (-0.0752896400F +
                                         z * (0.0429096138F + z * (-0.0161657367F + z * 0.0028662257F)))))));
  if (ay > ax) a = 0.5F * std::numbers::pi_v<float> - a;
  if (x < 0.0F) a = std::numbers::pi_v<float> - a;
  return y < 0.0F ? -a : a;
}

// How much farther the point on a convex round surface goes than the tip behind it.
float gain(float radius_m, float depth_m) noexcept {
  constexpr float kMostGain = 4.0F;  // near the axis a hair of the tip is half a turn of the point
  const float left = radius_m - depth_m;
  return left * kMostGain > radius_m ? radius_m / left : kMostGain;
}

bool on_side(const Vec3& normal) noexcept {
  constexpr float kCap = 0.5F;  // a cap's normal is +-z, a side's is square to it
  return std::abs(normal.z()) < kCap;
}

}  // namespace

Chart chart(const PlacedObject& object, const Place& place) noexcept {
  const Vec3& n = place.normal;
  if (object.source->shape_type() == scene::Shape::Cylinder && on_side(n)) {
    const float radius_m = object.shape.radius_m;
    const Vec3 around(-n.y(), n.x(), 0.0F);
    return {radius_m * angle(place.at_m.y(), place.at_m.x()), place.at_m.z(),
            gain(radius_m, place.depth_m) * around, Vec3::UnitZ()};
  }
  // u points along x as seen on the face; on faces towards x, along y. The bound is at an angle that few faces have, so that
  // rounding does not turn the axes of faces in one plane.
  constexpr float kTowardsX = 0.9F;
  const Vec3 along = std::abs(n.x()) < kTowardsX ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
  const Vec3 u = (along - n * n.dot(along)).normalized();
  const Vec3 v = n.cross(u);
  return {place.at_m.dot(u), place.at_m.dot(v), u, v};
}

Vec3 carried(const PlacedObject& object, const Place& place, const Vec3& gradient) noexcept {
  const Vec3& n = place.normal;
  Vec3 along = gradient - n * n.dot(gradient);
  const bool round_everywhere = object.source->shape_type() == scene::Shape::Sphere ||
                                (object.source->shape_type() == scene::Shape::Capsule &&
                                 std::abs(place.at_m.z()) > object.shape.half_height_m);
  if (round_everywhere) return gain(object.shape.radius_m, place.depth_m) * along;
  const bool round_about_z = object.source->shape_type() == scene::Shape::Capsule ||
                             (object.source->shape_type() == scene::Shape::Cylinder && on_side(n));
  if (!round_about_z) return along;
  const Vec3 around(-n.y(), n.x(), 0.0F);
  return along + (gain(object.shape.radius_m, place.depth_m) - 1.0F) * around.dot(along) * around;
}

}  // namespace thimble::control
