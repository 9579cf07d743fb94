// A half-space: solid where normal . p <= offset.
#include <algorithm>
#include <limits>

#include "control/shapes/shape.h"

namespace thimble::control {
namespace plane {
namespace {

bool sweep(const ShapeData& shape, const Vec3& from, const Vec3& to, std::span<const Feature> /*leaving*/,
           Hit& hit) {
  const float a = shape.vector.dot(from) - shape.radius_m;
  const float b = shape.vector.dot(to) - shape.radius_m;
  if (a >= -kSurfaceTolerance_m && b < -kSurfaceTolerance_m) {
    const float t = std::max(a, 0.0F) / (a - b);
    if (b < a && t < hit.t) hit = {t, {}};
  }
  return true;
}

Slide slide(const ShapeData& shape, Feature& /*feature*/, const Vec3& from, const Vec3& target,
            SlideOptions options) {
  const float height = shape.vector.dot(target) - shape.radius_m;
  if (height >= 0.0F && !options.hold) return {from, SlideEnd::kFree};
  const Vec3 to = target - height * shape.vector;
  return {to, SlideEnd::kHeld};
}

int normals(const ShapeData& shape, const Feature& /*feature*/, const Vec3& /*point*/,
            std::span<Vec3, 3> out) {
  out[0] = shape.vector;
  return 1;
}

Vec3 reach(const ShapeData& /*shape*/) { return Vec3::Constant(std::numeric_limits<float>::infinity()); }

}  // namespace
}  // namespace plane

const ShapeOps kPlaneOps{plane::sweep, plane::slide, plane::normals, plane::reach, nullptr, false};

}  // namespace thimble::control
