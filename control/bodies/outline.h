// A flat polygon, and what of it is left of a plane: the contact points of two faces.
#pragma once

#include <array>
#include <cstddef>

#include "kinematics/vector.h"

namespace thimble::control {

// The corners of a face, an edge or a single point, in order. A face of eight corners clipped by eight lines has at most
// sixteen.
struct Outline {
  std::array<Vec3, 16> corner;
  std::size_t count = 0;

  void add(const Vec3& p) {
    if (count < corner.size()) corner[count++] = p;
  }
};

// The part of the polygon where normal . p <= offset (Sutherland and Hodgman 1974).
inline Outline clip(const Outline& in, const Vec3& normal, float offset) {
  Outline out;
  for (std::size_t i = 0; i < in.count; ++i) {
    const Vec3& p = in.corner[i];
    const Vec3& q = in.corner[i + 1 == in.count ? 0 : i + 1];
    const float a = normal.dot(p) - offset;
    const float b = normal.dot(q) - offset;
    if (a <= 0.0F) out.add(p);
    if ((a < 0.0F && b > 0.0F) || (a > 0.0F && b < 0.0F)) out.add(p + (a / (a - b)) * (q - p));
  }
  return out;
}

}  // namespace thimble::control
