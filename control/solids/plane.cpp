// A half-space: solid where normal . p <= offset.
#include <algorithm>
#include <limits>

#include "control/bodies/collide.h"
#include "control/scene/check.h"
#include "control/solids/solid.h"

namespace thimble::control {
namespace plane {
namespace {

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  const scene::Plane& plane = *object.shape_as_Plane();
  return require(is_unit(plane.normal()) && in_range(plane.offset_m(), -kMaxCoordinate_m, kMaxCoordinate_m),
                 ImageStatus::kBadNumber);
}

void view(const scene::Object& object, ShapeData& shape) {
  shape.vector = to_vec(object.shape_as_Plane()->normal()).normalized();
  shape.radius_m = object.shape_as_Plane()->offset_m();
}

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  const float a = shape.vector.dot(from) - shape.radius_m;
  const float b = shape.vector.dot(to) - shape.radius_m;
  if (a >= -kSurfaceTolerance_m && b < -kSurfaceTolerance_m) {
    const float t = std::max(a, 0.0F) / (a - b);
    if (b < a && t < hit.t) hit = {t, {}};
  }
  return true;
}

Slide slide(const ShapeData& shape, Feature& /*feature*/, const SlideQuery& query) {
  const float height = shape.vector.dot(query.target) - shape.radius_m;
  if (height >= 0.0F && !query.hold) return {query.from, SlideEnd::kFree};
  const Vec3 to = query.target - height * shape.vector;
  return {to, SlideEnd::kHeld};
}

int normals(const ShapeData& shape, const Feature& /*feature*/, const Vec3& /*point*/,
            std::span<Vec3, 3> out) {
  out[0] = shape.vector;
  return 1;
}

Vec3 reach(const ShapeData& /*shape*/) { return Vec3::Constant(std::numeric_limits<float>::infinity()); }

NearestPlace nearest(const ShapeData& shape, const Vec3& p) {
  return {shape.vector, shape.vector.dot(p) - shape.radius_m};
}

}  // namespace
}  // namespace plane

const SolidOps kPlaneSolid{.check = plane::check,
                           .view = plane::view,
                           .sweep = plane::sweep,
                           .slide = plane::slide,
                           .normals = plane::normals,
                           .reach = plane::reach,
                           .smooth = true};
const CollisionOps kPlaneCollision{.form = CollisionForm::kHalfSpace, .nearest = plane::nearest};

}  // namespace thimble::control
