// A ball about the origin.
#include "control/bodies/collide.h"
#include "control/scene/blend.h"
#include "control/scene/check.h"
#include "control/solids/round.h"
#include "control/solids/solid.h"
#include "control/surfaces/chart.h"

namespace thimble::control {
namespace sphere {
namespace {

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  return require(is_size(object.shape_as_Sphere()->radius_m()), ImageStatus::kBadNumber);
}

void view(const scene::Object& object, ShapeData& shape) {
  shape.radius_m = object.shape_as_Sphere()->radius_m();
}

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  const float core = shape.radius_m - kSurfaceTolerance_m;
  const float from2 = from.squaredNorm();
  if (from2 < core * core) return true;  // from is inside: free to leave
  const Vec3 d = to - from;
  const float a = d.squaredNorm();
  const float b = from.dot(d);
  if (to.squaredNorm() >= core * core && entry(a, b, from2 - core * core) > 1.0F) return true;
  const float t = std::min(entry(a, b, from2 - shape.radius_m * shape.radius_m), 1.0F);
  if (t < hit.t) hit = {t, {}};
  return true;
}

Slide slide(const ShapeData& shape, Feature& /*feature*/, const SlideQuery& query) {
  const float distance = query.target.norm();
  // At the centre every direction is equally near: stay.
  if (distance < kSurfaceTolerance_m) return {query.from, SlideEnd::kHeld};
  const Vec3 normal_to = query.target / distance;
  if (!query.one_piece) {  // no other object is near, so the path around the sphere does not matter
    const Vec3 to = shape.radius_m * normal_to;
    return {to, distance >= shape.radius_m && !query.hold ? SlideEnd::kFree : SlideEnd::kHeld};
  }
  const Vec3 normal_from = query.from.normalized();
  const Turn turn = limit_turn(normal_from, normal_to);
  const Vec3 to = shape.radius_m * turn.normal;
  const SlideEnd end = turn.limited                                ? SlideEnd::kMoved
                       : distance >= shape.radius_m && !query.hold ? SlideEnd::kFree
                                                                   : SlideEnd::kHeld;
  return {outer_corner(query.from, normal_from, to, turn.normal), to, end};
}

int normals(const ShapeData& /*shape*/, const Feature& /*feature*/, const Vec3& point,
            std::span<Vec3, 3> out) {
  out[0] = point.normalized();
  return 1;
}

Vec3 reach(const ShapeData& shape) { return Vec3::Constant(shape.radius_m); }

Vec3 gradient_at_tip(const ShapeData& shape, const SurfacePoint& place, const Vec3& along) {
  return curvature_gain(shape.radius_m, place.depth_m) * along;
}

bool blend(const ShapeData& shape, const SurfacePoint& place, Blend& out) {
  out = blend_along(place.at_m, Vec3::Ones());
  return shape.radius_m > 0.0F;
}

NearestPlace nearest(const ShapeData& shape, const Vec3& p) { return nearest_on_ball(shape.radius_m, p); }

}  // namespace
}  // namespace sphere

const SolidOps kSphereSolid{.check = sphere::check,
                            .view = sphere::view,
                            .sweep = sphere::sweep,
                            .slide = sphere::slide,
                            .normals = sphere::normals,
                            .reach = sphere::reach,
                            .blend = sphere::blend,
                            .gradient_at_tip = sphere::gradient_at_tip,
                            .smooth = true};
const CollisionOps kSphereCollision{.form = CollisionForm::kBall, .nearest = sphere::nearest};

}  // namespace thimble::control
