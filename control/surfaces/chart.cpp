#include "control/surfaces/chart.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace thimble::control {
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

float curvature_gain(float radius_m, float depth_m) noexcept {
  constexpr float kMostGain = 4.0F;  // near the axis a small motion of the tip moves the point half a turn
  const float left = radius_m - depth_m;
  return left * kMostGain > radius_m ? radius_m / left : kMostGain;
}

Vec3 faster_round_axis(const Vec3& normal, float gain, const Vec3& along) noexcept {
  const Vec3 around(-normal.y(), normal.x(), 0.0F);
  return along + (gain - 1.0F) * around.dot(along) * around;
}

Chart plane_chart(const Vec3& n, const Vec3& at_m) noexcept {
  // u is the x axis projected onto the face; on faces towards x, the y axis. Few faces have the angle of this
  // bound, so rounding does not give different axes to faces in one plane.
  constexpr float kTowardsX = 0.9F;
  const Vec3 along = std::abs(n.x()) < kTowardsX ? Vec3(Vec3::UnitX()) : Vec3(Vec3::UnitY());
  const Vec3 u = (along - n * n.dot(along)).normalized();
  const Vec3 v = n.cross(u);
  return {at_m.dot(u), at_m.dot(v), u, v};
}

Chart chart(const PlacedObject& object, const SurfacePoint& place) noexcept {
  return object.ops->chart != nullptr ? object.ops->chart(object.shape, place)
                                      : plane_chart(place.normal, place.at_m);
}

Vec3 gradient_at_tip(const PlacedObject& object, const SurfacePoint& place, const Vec3& gradient) noexcept {
  const Vec3 along = gradient - place.normal * place.normal.dot(gradient);
  return object.ops->gradient_at_tip != nullptr ? object.ops->gradient_at_tip(object.shape, place, along)
                                                : along;
}

}  // namespace thimble::control
