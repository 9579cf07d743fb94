// A cylinder about the z axis with flat caps. Feature index: 0 side, 1 cap at +z, 2 cap at -z.
#include <algorithm>
#include <cmath>

#include "control/bodies/collide.h"
#include "control/scene/check.h"
#include "control/solids/round.h"
#include "control/solids/solid.h"
#include "control/surfaces/chart.h"

namespace thimble::control {
namespace cylinder {
namespace {

constexpr std::uint32_t kSide = 0;
constexpr std::uint32_t kTop = 1;
constexpr std::uint32_t kBottom = 2;

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  const scene::Cylinder& c = *object.shape_as_Cylinder();
  return require(is_size(c.radius_m()) && is_size(c.half_height_m()), ImageStatus::kBadNumber);
}

void view(const scene::Object& object, ShapeData& shape) {
  shape.radius_m = object.shape_as_Cylinder()->radius_m();
  shape.half_height_m = object.shape_as_Cylinder()->half_height_m();
}

float radial2(const Vec3& p) { return p.x() * p.x() + p.y() * p.y(); }

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  // As in the box: the entry test uses the solid reduced by the tolerance, the landing point the solid
  // itself.
  const float core = shape.radius_m - kSurfaceTolerance_m;
  const float half = shape.half_height_m - kSurfaceTolerance_m;
  const Vec3 d = to - from;
  const bool ends_inside = std::abs(to.z()) < half && radial2(to) < core * core;
  float enter = -1.0F;
  float leave = 2.0F;
  float land = 0.0F;
  std::uint32_t face = kSide;

  const float sign = from.z() >= half ? 1.0F : from.z() <= -half ? -1.0F : 0.0F;
  if (sign != 0.0F) {
    const float approach = -sign * d.z();
    const float gap = sign * from.z() - half;
    if (approach <= 0.0F || gap > approach) return true;
    enter = gap / approach;
    land = std::max(sign * from.z() - shape.half_height_m, 0.0F) / approach;
    face = sign > 0.0F ? kTop : kBottom;
  }
  if (d.z() != 0.0F) leave = (std::copysign(half, d.z()) - from.z()) / d.z();

  const float a = radial2(d);
  const float b = from.x() * d.x() + from.y() * d.y();
  const float c = radial2(from) - core * core;
  if (c >= 0.0F) {  // outside the round wall: it must be entered
    const float t = entry(a, b, c);
    if (t > 1.0F && !ends_inside) return true;
    if (t > enter) {
      enter = std::min(t, 1.0F);
      land = std::min(entry(a, b, radial2(from) - shape.radius_m * shape.radius_m), 1.0F);
      face = kSide;
    }
  }
  if (a > 0.0F) leave = std::min(leave, (-b + std::sqrt(std::max(b * b - a * c, 0.0F))) / a);
  if (enter < 0.0F) return true;  // from is inside: free to leave
  if (!ends_inside && enter > leave) return true;
  if (land < hit.t) hit = {land, {.index = face}};
  return true;
}

Slide slide_cap(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  const float sign = feature.index == kTop ? 1.0F : -1.0F;
  const bool in_front = sign * query.target.z() >= shape.half_height_m;
  if (in_front && !query.hold) return {query.from, SlideEnd::kFree};
  const float radial = std::sqrt(radial2(query.target));
  const float scale = radial > shape.radius_m ? shape.radius_m / radial : 1.0F;
  const Vec3 to(scale * query.target.x(), scale * query.target.y(), sign * shape.half_height_m);
  if (radial <= shape.radius_m) return {to, SlideEnd::kHeld};
  if (!query.hold) return {to, SlideEnd::kFree};  // outside, in front of the round wall
  if (in_front) return {to, SlideEnd::kHeld};
  feature.index = kSide;
  return {to, SlideEnd::kMoved};
}

Slide slide_side(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  const float radial = std::sqrt(radial2(query.target));
  const Vec3 normal_from = Vec3(query.from.x(), query.from.y(), 0.0F).normalized();
  const Vec3 normal_to = radial > kSurfaceTolerance_m
                             ? Vec3(query.target.x() / radial, query.target.y() / radial, 0.0F)
                             : normal_from;
  const Turn turn = limit_turn(normal_from, normal_to);
  Vec3 to = shape.radius_m * turn.normal;
  to.z() = std::clamp(query.target.z(), -shape.half_height_m, shape.half_height_m);
  const Vec3 via = outer_corner(query.from, normal_from, to, turn.normal);
  if (turn.limited) return {via, to, SlideEnd::kMoved};
  const bool in_front = radial >= shape.radius_m;
  const bool beyond_cap = std::abs(query.target.z()) > shape.half_height_m;
  if (!query.hold) return {via, to, in_front || beyond_cap ? SlideEnd::kFree : SlideEnd::kHeld};
  if (!beyond_cap || in_front) return {via, to, SlideEnd::kHeld};
  feature.index = query.target.z() > 0.0F ? kTop : kBottom;
  return {via, to, SlideEnd::kMoved};
}

Slide slide(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  return feature.index == kSide ? slide_side(shape, feature, query) : slide_cap(shape, feature, query);
}

int normals(const ShapeData& /*shape*/, const Feature& feature, const Vec3& point, std::span<Vec3, 3> out) {
  if (feature.index == kSide) {
    out[0] = Vec3(point.x(), point.y(), 0.0F).normalized();
  } else {
    out[0] = Vec3(0.0F, 0.0F, feature.index == kTop ? 1.0F : -1.0F);
  }
  return 1;
}

std::size_t faces(const ShapeData& shape, const Vec3& point, std::span<NearestPlace, 3> out) {
  const float across = planar_length(point.x(), point.y());
  out[0] = {{0.0F, 0.0F, std::copysign(1.0F, point.z())}, std::abs(point.z()) - shape.half_height_m};
  if (across <= shape.radius_m) return 1;
  out[1] = {{point.x() / across, point.y() / across, 0.0F}, across - shape.radius_m};
  return 2;
}

Feature feature(const ShapeData& /*shape*/, const Vec3& normal) {
  constexpr float kSlant = 0.70710678F;
  return {.index = normal.z() > kSlant ? kTop : normal.z() < -kSlant ? kBottom : kSide};
}

Vec3 reach(const ShapeData& shape) { return {shape.radius_m, shape.radius_m, shape.half_height_m}; }

bool on_side(const Vec3& normal) {
  constexpr float kCap = 0.5F;  // a cap's normal is +-z, a side's is square to it
  return std::abs(normal.z()) < kCap;
}

Chart chart(const ShapeData& shape, const SurfacePoint& place) {
  if (!on_side(place.normal)) return plane_chart(place.normal, place.at_m);
  const Vec3 around(-place.normal.y(), place.normal.x(), 0.0F);
  return {shape.radius_m * angle(place.at_m.y(), place.at_m.x()), place.at_m.z(),
          curvature_gain(shape.radius_m, place.depth_m) * around, Vec3::UnitZ()};
}

Vec3 gradient_at_tip(const ShapeData& shape, const SurfacePoint& place, const Vec3& along) {
  if (!on_side(place.normal)) return along;
  return faster_round_axis(place.normal, curvature_gain(shape.radius_m, place.depth_m), along);
}

NearestPlace nearest(const ShapeData& shape, const Vec3& p) {
  const float across = planar_length(p.x(), p.y());
  const Vec3 out = across > 0.0F ? Vec3(p.x() / across, p.y() / across, 0.0F) : Vec3(Vec3::UnitX());
  const Vec3 up(0.0F, 0.0F, p.z() < 0.0F ? -1.0F : 1.0F);
  const float side = across - shape.radius_m;
  const float cap = std::abs(p.z()) - shape.half_height_m;
  if (side > 0.0F && cap > 0.0F) {
    const float distance = planar_length(side, cap);
    return {(side * out + cap * up) / distance, distance};
  }
  return side > cap ? NearestPlace{out, side} : NearestPlace{up, cap};
}

// Four points of each rim, the lowest one among them.
std::size_t lowest(const ShapeData& shape, const Vec3& down, LowestPoints& out) {
  const std::array<Vec3, 4> directions = rim_directions(down);
  std::size_t count = 0;
  for (const float z : {-shape.half_height_m, shape.half_height_m}) {
    const Vec3 middle(0.0F, 0.0F, z);
    for (const Vec3& direction : directions) out[count++] = middle + shape.radius_m * direction;
  }
  return count;
}

BoxAbout box_about(const ShapeData& shape) {
  return {Vec3::Zero(), {shape.radius_m, shape.radius_m, shape.half_height_m}};
}

}  // namespace
}  // namespace cylinder

const SolidOps kCylinderSolid{.check = cylinder::check,
                              .view = cylinder::view,
                              .sweep = cylinder::sweep,
                              .slide = cylinder::slide,
                              .faces = cylinder::faces,
                              .feature = cylinder::feature,
                              .normals = cylinder::normals,
                              .reach = cylinder::reach,
                              .chart = cylinder::chart,
                              .gradient_at_tip = cylinder::gradient_at_tip};
const CollisionOps kCylinderCollision{.form = CollisionForm::kCylinder,
                                      .nearest = cylinder::nearest,
                                      .lowest = cylinder::lowest,
                                      .box_about = cylinder::box_about};

}  // namespace thimble::control
