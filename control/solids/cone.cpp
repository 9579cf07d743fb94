// A cone about the z axis: the apex up, a flat base below. The origin is the centre of mass, as in every
// other primitive, so the base is at z = -height / 4 and the apex at z = 3 height / 4. Feature index: 0 side,
// 1 base.
//
// The side is seen in the half-plane through the axis and a direction square to it: a straight line from the
// apex to the rim, with the unit normal (n_r, n_z) across the axis and along it.
#include <algorithm>
#include <array>
#include <cmath>

#include "control/bodies/collide.h"
#include "control/scene/blend.h"
#include "control/scene/check.h"
#include "control/solids/round.h"
#include "control/solids/solid.h"
#include "control/surfaces/chart.h"

namespace thimble::control {
namespace cone {
namespace {

constexpr std::uint32_t kSide = 0;
constexpr std::uint32_t kBase = 1;

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  const scene::Cone& c = *object.shape_as_Cone();
  return require(is_size(c.radius_m()) && is_size(c.height_m()), ImageStatus::kBadNumber);
}

// vector: n_r, n_z, length of the side from apex to rim.
void view(const scene::Object& object, ShapeData& shape) {
  const scene::Cone& c = *object.shape_as_Cone();
  shape.radius_m = c.radius_m();
  shape.half_height_m = 0.5F * c.height_m();
  const float length = planar_length(c.radius_m(), c.height_m());
  shape.vector = {c.height_m() / length, c.radius_m() / length, length};
}

float apex_m(const ShapeData& shape) { return 1.5F * shape.half_height_m; }
float base_m(const ShapeData& shape) { return -0.5F * shape.half_height_m; }

// How far a point is in front of the side's line, and how far down that line from the apex. across: from the
// axis.
float in_front_m(const ShapeData& shape, float across, float z) {
  return shape.vector.x() * across + shape.vector.y() * (z - apex_m(shape));
}
float down_the_side_m(const ShapeData& shape, float across, float z) {
  return shape.vector.y() * across - shape.vector.x() * (z - apex_m(shape));
}
Vec3 on_side(const ShapeData& shape, const Vec3& direction, float down_m) {
  return (shape.vector.y() * down_m) * direction +
         Vec3(0.0F, 0.0F, apex_m(shape) - shape.vector.x() * down_m);
}
Vec3 side_normal(const ShapeData& shape, const Vec3& direction) {
  return shape.vector.x() * direction + Vec3(0.0F, 0.0F, shape.vector.y());
}

// The first entry through the side, moved inwards by inset_m, on the line from + t d: 0 from inside, 2 when
// there is none ahead. n_r^2 (x^2 + y^2) = q^2 with q = -n_z (z - apex) - inset >= 0, below the apex.
float enter_side(const ShapeData& shape, float inset_m, const Vec3& from, const Vec3& d) {
  const float n_r = shape.vector.x();
  const float n_z = shape.vector.y();
  const float q_step = -n_z * d.z();
  float q = -n_z * (from.z() - apex_m(shape)) - inset_m;
  float start = 0.0F;
  Vec3 p = from;
  if (q < 0.0F) {  // above the apex: start where the line falls below it
    if (q_step <= 0.0F || -q > q_step) return 2.0F;
    start = -q / q_step;
    p += start * d;
    q = 0.0F;
  }
  const float across = planar_length(p.x(), p.y());
  const float c = (n_r * across - q) * (n_r * across + q);
  if (c <= 0.0F) return start;
  const float a = n_r * n_r * (d.x() * d.x() + d.y() * d.y()) - q_step * q_step;
  const float b = n_r * n_r * (p.x() * d.x() + p.y() * d.y()) - q * q_step;
  const float discriminant = b * b - a * c;
  if (discriminant < 0.0F) return 2.0F;
  const float divisor = std::sqrt(discriminant) - b;
  if (divisor <= 0.0F) return 2.0F;
  const float t = c / divisor;
  return q + t * q_step >= 0.0F ? start + t : 2.0F;  // below 0: the cone's image above the apex
}

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  // As in the cylinder: entered is the solid less the tolerance, landed on is the solid itself.
  const float floor = base_m(shape) + kSurfaceTolerance_m;
  const auto in_core = [&](const Vec3& p) {
    return in_front_m(shape, planar_length(p.x(), p.y()), p.z()) < -kSurfaceTolerance_m;
  };
  const Vec3 d = to - from;
  const bool ends_inside = to.z() > floor && in_core(to);
  const bool starts_below = from.z() <= floor;
  const bool starts_in_front = !in_core(from);
  if (!starts_below && !starts_in_front) return true;  // from is inside: free to leave
  float enter = -1.0F;
  float land = 0.0F;
  std::uint32_t face = kSide;
  if (starts_below) {
    const float gap = floor - from.z();
    if (d.z() <= 0.0F || gap > d.z()) return true;
    enter = gap / d.z();
    land = std::max(base_m(shape) - from.z(), 0.0F) / d.z();
    face = kBase;
  }
  if (starts_in_front) {
    const float t = enter_side(shape, kSurfaceTolerance_m, from, d);
    if (t > 1.0F && !ends_inside) return true;
    if (t > enter) {
      enter = std::min(t, 1.0F);
      land = std::min(enter_side(shape, 0.0F, from, d), enter);
      face = kSide;
    }
  }
  if (!ends_inside) {  // the other part of the surface may be behind it already
    const Vec3 at = from + enter * d;
    if (face == kSide ? at.z() <= floor : !in_core(at)) return true;
  }
  if (land < hit.t) hit = {land, {.index = face}};
  return true;
}

Slide slide_base(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  const bool in_front = query.target.z() <= base_m(shape);
  if (in_front && !query.hold) return {query.from, SlideEnd::kFree};
  const float across = planar_length(query.target.x(), query.target.y());
  const float scale = across > shape.radius_m ? shape.radius_m / across : 1.0F;
  const Vec3 to(scale * query.target.x(), scale * query.target.y(), base_m(shape));
  if (across <= shape.radius_m) return {to, SlideEnd::kHeld};
  if (!query.hold) return {to, SlideEnd::kFree};  // outside, in front of the side
  if (in_front) return {to, SlideEnd::kHeld};
  feature.index = kSide;
  return {to, SlideEnd::kMoved};
}

Slide slide_side(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  const float from_across = planar_length(query.from.x(), query.from.y());
  const float across = planar_length(query.target.x(), query.target.y());
  const bool at_apex = from_across <= kSurfaceTolerance_m;  // every direction leads down from there
  const bool on_axis = across <= kSurfaceTolerance_m;
  const Vec3 of_target =
      on_axis ? Vec3(Vec3::UnitX()) : Vec3(query.target.x() / across, query.target.y() / across, 0.0F);
  const Vec3 direction_from =
      at_apex ? of_target : Vec3(query.from.x() / from_across, query.from.y() / from_across, 0.0F);
  const Turn turn = limit_turn(direction_from, on_axis ? direction_from : of_target);
  const float towards =
      turn.normal.dot(query.target);  // how far from the axis the target is, in the direction to go in
  const float down = down_the_side_m(shape, towards, query.target.z());
  const Vec3 to = on_side(shape, turn.normal, std::clamp(down, 0.0F, shape.vector.z()));
  const Vec3 via =
      outer_corner(query.from, side_normal(shape, direction_from), to, side_normal(shape, turn.normal));
  if (turn.limited) return {via, to, SlideEnd::kMoved};
  const bool in_front = in_front_m(shape, towards, query.target.z()) >= 0.0F;
  const bool beyond_rim = down > shape.vector.z();
  if (!query.hold) return {via, to, in_front || beyond_rim ? SlideEnd::kFree : SlideEnd::kHeld};
  if (!beyond_rim || in_front) return {via, to, SlideEnd::kHeld};
  feature.index = kBase;
  return {via, to, SlideEnd::kMoved};
}

Slide slide(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  return feature.index == kSide ? slide_side(shape, feature, query) : slide_base(shape, feature, query);
}

// At the apex the plane across the axis stands for all of the side's: it touches the cone there and nowhere
// else.
int normals(const ShapeData& shape, const Feature& feature, const Vec3& point, std::span<Vec3, 3> out) {
  const float across = planar_length(point.x(), point.y());
  if (feature.index == kBase) {
    out[0] = -Vec3::UnitZ();
  } else if (across <= kSurfaceTolerance_m) {
    out[0] = Vec3::UnitZ();
  } else {
    out[0] = side_normal(shape, Vec3(point.x() / across, point.y() / across, 0.0F));
  }
  return 1;
}

std::size_t faces(const ShapeData& shape, const Vec3& point, std::span<NearestPlace, 3> out) {
  out[0] = {-Vec3::UnitZ(), base_m(shape) - point.z()};
  const float across = planar_length(point.x(), point.y());
  if (across <= 0.0F) return 1;
  out[1] = {side_normal(shape, Vec3(point.x() / across, point.y() / across, 0.0F)),
            in_front_m(shape, across, point.z())};
  return 2;
}

// Between the side's slope and the base, the side counts up to half of the angle at the rim.
Feature feature(const ShapeData& shape, const Vec3& normal) {
  const float across = planar_length(normal.x(), normal.y());
  return {.index = -normal.z() > shape.vector.x() * across + shape.vector.y() * normal.z() ? kBase : kSide};
}

Vec3 reach(const ShapeData& shape) { return {shape.radius_m, shape.radius_m, apex_m(shape)}; }

// The point on the side goes round the axis on a circle whose radius falls to nothing at the apex, the tip on
// one that is smaller by the depth across the axis.
Vec3 gradient_at_tip(const ShapeData& /*shape*/, const SurfacePoint& place, const Vec3& along) {
  const float across = planar_length(place.normal.x(), place.normal.y());
  if (across <= 0.0F) return along;  // the base
  const Vec3 direction = place.normal.cwiseProduct(Vec3(1.0F, 1.0F, 0.0F)) / across;
  const float round_m = planar_length(place.at_m.x(), place.at_m.y());
  return faster_round_axis(direction, curvature_gain(round_m, across * place.depth_m), along);
}

// Towards the apex the direction turns upwards, where the normal has none: it is the normal at the rim.
bool blend(const ShapeData& shape, const SurfacePoint& place, Blend& out) {
  if (place.normal.z() < 0.0F) return false;  // the base
  const float outwards = shape.vector.x() / shape.radius_m;
  out = blend_along({outwards * place.at_m.x(), outwards * place.at_m.y(), shape.vector.y()},
                    {outwards, outwards, 0.0F});
  return true;
}

NearestPlace nearest(const ShapeData& shape, const Vec3& p) {
  const float across = planar_length(p.x(), p.y());
  const Vec3 direction = across > 0.0F ? Vec3(p.x() / across, p.y() / across, 0.0F) : Vec3(Vec3::UnitX());
  const float side = in_front_m(shape, across, p.z());
  const float base = base_m(shape) - p.z();
  if (base >= 0.0F && across <= shape.radius_m) return {-Vec3::UnitZ(), base};
  const float down = down_the_side_m(shape, across, p.z());
  const bool below_rim = base >= 0.0F;  // beside the base, which may be behind the side's plane
  if (below_rim || (side > 0.0F && (down < 0.0F || down > shape.vector.z()))) {  // the apex or the rim
    const Vec3 from_edge = p - on_side(shape, direction, std::clamp(down, 0.0F, shape.vector.z()));
    const float distance = from_edge.norm();
    if (distance > 0.0F) return {from_edge / distance, distance};
  }
  return side > base ? NearestPlace{side_normal(shape, direction), side} : NearestPlace{-Vec3::UnitZ(), base};
}

// The apex, and four points of the rim, the lowest one among them.
std::size_t lowest(const ShapeData& shape, const Vec3& down, LowestPoints& out) {
  std::size_t count = 0;
  out[count++] = {0.0F, 0.0F, apex_m(shape)};
  for (const Vec3& direction : rim_directions(down))
    out[count++] = shape.radius_m * direction + Vec3(0.0F, 0.0F, base_m(shape));
  return count;
}

BoxAbout box_about(const ShapeData& shape) {
  return {{0.0F, 0.0F, 0.5F * (apex_m(shape) + base_m(shape))},
          {shape.radius_m, shape.radius_m, shape.half_height_m}};
}

}  // namespace
}  // namespace cone

const SolidOps kConeSolid{.check = cone::check,
                          .view = cone::view,
                          .sweep = cone::sweep,
                          .slide = cone::slide,
                          .faces = cone::faces,
                          .feature = cone::feature,
                          .normals = cone::normals,
                          .reach = cone::reach,
                          .blend = cone::blend,
                          .gradient_at_tip = cone::gradient_at_tip};
const CollisionOps kConeCollision{.form = CollisionForm::kCone,
                                  .nearest = cone::nearest,
                                  .lowest = cone::lowest,
                                  .box_about = cone::box_about};

}  // namespace thimble::control
