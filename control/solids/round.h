// Convex curved surfaces: the entry of a sweep, the length of one piece of a slide, and a path around them
// that stays outside.
#pragma once

#include <algorithm>
#include <cmath>

#include "kinematics/vector.h"

namespace thimble::control {

// The first root of a t^2 + 2 b t + c, where |from + t d|^2 falls to radius^2: 0 from inside, 2 when there is
// none ahead.
inline float entry(float a, float b, float c) noexcept {
  if (c <= 0.0F) return 0.0F;
  const float discriminant = b * b - a * c;
  if (b >= 0.0F || discriminant < 0.0F || a <= 0.0F) return 2.0F;
  return (-b - std::sqrt(discriminant)) / a;
}

// Limits the turn of one piece of a slide to 90 degrees. Returns the normal to go to, and whether it was
// limited.
struct Turn {
  Vec3 normal;
  bool limited;
};

inline Turn limit_turn(const Vec3& normal_from, const Vec3& normal_to) noexcept {
  if (normal_from.dot(normal_to) >= 0.0F) return {normal_to, false};
  const Vec3 middle = normal_from + normal_to;
  // Opposite normals: every way around is equally short; always take the same one.
  constexpr float kOpposite = 1.0e-4F;
  const Vec3 way = middle.squaredNorm() > kOpposite * kOpposite ? middle : Vec3(normal_from.unitOrthogonal());
  return {way.normalized(), true};
}

// A point outside a convex surface from which both ends of a piece are visible: on the intersection of the
// tangent planes.
inline Vec3 outer_corner(const Vec3& from, const Vec3& normal_from, const Vec3& to,
                         const Vec3& normal_to) noexcept {
  const Vec3 half = 0.5F * (to - from);
  const float lift = std::max({0.0F, -normal_from.dot(half), normal_to.dot(half)});
  return from + half + (lift / (1.0F + normal_from.dot(normal_to))) * (normal_from + normal_to);
}

}  // namespace thimble::control
