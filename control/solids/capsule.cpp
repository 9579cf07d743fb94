// A capsule about the z axis: all points within a radius of the segment between the caps' centres.
#include <algorithm>
#include <cmath>

#include "control/bodies/collide.h"
#include "control/scene/blend.h"
#include "control/scene/check.h"
#include "control/solids/round.h"
#include "control/solids/solid.h"
#include "control/surfaces/chart.h"

namespace thimble::control {
namespace capsule {
namespace {

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  const scene::Capsule& c = *object.shape_as_Capsule();
  return require(is_size(c.radius_m()) && in_range(c.half_height_m(), 0.0F, kMaxCoordinate_m),
                 ImageStatus::kBadNumber);
}

void view(const scene::Object& object, ShapeData& shape) {
  shape.radius_m = object.shape_as_Capsule()->radius_m();
  shape.half_height_m = object.shape_as_Capsule()->half_height_m();
}

Vec3 from_axis(const ShapeData& shape, const Vec3& p) {
  return {p.x(), p.y(), p.z() - std::clamp(p.z(), -shape.half_height_m, shape.half_height_m)};
}

// The first entry into the capsule of a given radius; 2 when there is none ahead.
float enter(const ShapeData& shape, float radius, const Vec3& from, const Vec3& d) {
  if (from_axis(shape, from).squaredNorm() <= radius * radius) return 0.0F;
  float t = 2.0F;
  const float wall = entry(d.x() * d.x() + d.y() * d.y(), from.x() * d.x() + from.y() * d.y(),
                           from.x() * from.x() + from.y() * from.y() - radius * radius);
  if (std::abs(from.z() + wall * d.z()) <= shape.half_height_m) t = wall;
  for (const float end : {shape.half_height_m, -shape.half_height_m}) {
    const Vec3 p = from - Vec3(0.0F, 0.0F, end);
    t = std::min(t, entry(d.squaredNorm(), p.dot(d), p.squaredNorm() - radius * radius));
  }
  return t;
}

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  const float core = shape.radius_m - kSurfaceTolerance_m;
  if (from_axis(shape, from).squaredNorm() < core * core) return true;  // inside: free to leave
  const Vec3 d = to - from;
  if (from_axis(shape, to).squaredNorm() >= core * core && enter(shape, core, from, d) > 1.0F) return true;
  const float t = std::min(enter(shape, shape.radius_m, from, d), 1.0F);
  if (t < hit.t) hit = {t, {}};
  return true;
}

// The point of the surface whose normal is `normal`: on a cap, or on the round wall at the height z.
Vec3 with_normal(const ShapeData& shape, const Vec3& normal, float z) {
  constexpr float kLevel = 1.0e-4F;
  const float centre = normal.z() > kLevel    ? shape.half_height_m
                       : normal.z() < -kLevel ? -shape.half_height_m
                                              : z;
  return shape.radius_m * normal + Vec3(0.0F, 0.0F, centre);
}

Slide slide(const ShapeData& shape, Feature& /*feature*/, const SlideQuery& query) {
  const Vec3 arm = from_axis(shape, query.target);
  const float distance = arm.norm();
  const Vec3 normal_from = from_axis(shape, query.from).normalized();
  const bool on_axis = distance <= kSurfaceTolerance_m;
  const Turn turn = on_axis ? Turn{normal_from, false} : limit_turn(normal_from, arm / distance);
  const Vec3 to = on_axis || turn.limited ? with_normal(shape, turn.normal, query.target.z() - arm.z())
                                          : Vec3(query.target - arm + shape.radius_m * turn.normal);
  const Vec3 via = outer_corner(query.from, normal_from, to, turn.normal);
  if (turn.limited) return {via, to, SlideEnd::kMoved};
  return {via, to, distance >= shape.radius_m && !query.hold ? SlideEnd::kFree : SlideEnd::kHeld};
}

int normals(const ShapeData& shape, const Feature& /*feature*/, const Vec3& point, std::span<Vec3, 3> out) {
  out[0] = from_axis(shape, point).normalized();
  return 1;
}

Vec3 reach(const ShapeData& shape) {
  return {shape.radius_m, shape.radius_m, shape.radius_m + shape.half_height_m};
}

Vec3 gradient_at_tip(const ShapeData& shape, const SurfacePoint& place, const Vec3& along) {
  const float gain = curvature_gain(shape.radius_m, place.depth_m);
  if (std::abs(place.at_m.z()) > shape.half_height_m) return gain * along;
  return faster_round_axis(place.normal, gain, along);
}

bool blend(const ShapeData& shape, const SurfacePoint& place, Blend& out) {
  const bool on_cap = std::abs(place.at_m.z()) > shape.half_height_m;
  out = blend_along(from_axis(shape, place.at_m), {1.0F, 1.0F, on_cap ? 1.0F : 0.0F});
  return true;
}

NearestPlace nearest(const ShapeData& shape, const Vec3& p) {
  return nearest_on_ball(shape.radius_m, from_axis(shape, p));
}

}  // namespace
}  // namespace capsule

const SolidOps kCapsuleSolid{.check = capsule::check,
                             .view = capsule::view,
                             .sweep = capsule::sweep,
                             .slide = capsule::slide,
                             .normals = capsule::normals,
                             .reach = capsule::reach,
                             .blend = capsule::blend,
                             .gradient_at_tip = capsule::gradient_at_tip,
                             .smooth = true};
const CollisionOps kCapsuleCollision{.form = CollisionForm::kCapsule, .nearest = capsule::nearest};

}  // namespace thimble::control
