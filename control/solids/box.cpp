// A box about the origin. Feature index: 2 axis + (1 on the negative side).
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "control/bodies/collide.h"
#include "control/scene/check.h"
#include "control/solids/solid.h"

namespace thimble::control {
namespace box {
namespace {

ImageVerdict check(const scene::Object& object, std::size_t& /*triangles*/, Pauses& /*pauses*/) {
  const scene::Vec3& half = object.shape_as_Box()->half_size_m();
  return require(is_size(half.x()) && is_size(half.y()) && is_size(half.z()), ImageStatus::kBadNumber);
}

void view(const scene::Object& object, ShapeData& shape) {
  shape.vector = to_vec(object.shape_as_Box()->half_size_m());
}

bool sweep(const ShapeData& shape, const SweepQuery& query, Hit& hit) {
  const Vec3& from = query.from;
  const Vec3& to = query.to;
  // The entry test uses the box reduced by the surface tolerance, the landing point the box itself. So a
  // landing point is never close to counting as inside.
  const Vec3 core = shape.vector.array() - kSurfaceTolerance_m;
  const Vec3 d = to - from;
  float enter = -1.0F;
  float leave = 2.0F;
  float land = 0.0F;
  std::uint32_t face = 0;
  bool ends_inside = true;
  for (int axis = 0; axis < 3; ++axis) {
    ends_inside = ends_inside && std::abs(to[axis]) < core[axis];
    const float sign = from[axis] >= core[axis] ? 1.0F : from[axis] <= -core[axis] ? -1.0F : 0.0F;
    if (sign != 0.0F) {  // outside this slab: it must be entered
      const float approach = -sign * d[axis];
      const float gap = sign * from[axis] - core[axis];
      if (approach <= 0.0F || gap > approach) return true;
      const float t = gap / approach;
      if (t > enter) {
        enter = t;
        face = 2U * static_cast<std::uint32_t>(axis) + (sign < 0.0F ? 1U : 0U);
        land = std::max(sign * from[axis] - shape.vector[axis], 0.0F) / approach;
      }
    }
    if (d[axis] != 0.0F) leave = std::min(leave, (std::copysign(core[axis], d[axis]) - from[axis]) / d[axis]);
  }
  if (enter < 0.0F) return true;  // from is inside: free to leave
  if (!ends_inside && enter > leave) return true;
  if (land < hit.t) hit = {land, {.index = face}};
  return true;
}

Slide slide(const ShapeData& shape, Feature& feature, const SlideQuery& query) {
  const Vec3& half = shape.vector;
  const int axis = static_cast<int>(feature.index >> 1U);
  const float sign = (feature.index & 1U) == 0U ? 1.0F : -1.0F;
  const bool in_front = sign * query.target[axis] >= half[axis];
  if (in_front && !query.hold) return {query.from, SlideEnd::kFree};
  Vec3 to = query.target.cwiseMax(-half).cwiseMin(half);
  to[axis] = sign * half[axis];
  SlideEnd end = SlideEnd::kHeld;
  for (int side = 0; side < 3; ++side) {
    if (side == axis || to[side] == query.target[side]) continue;
    // The target is beyond this face's edge, so outside the box, in front of the face round the corner.
    if (!query.hold) return {to, SlideEnd::kFree};
    if (!in_front) {
      feature.index = 2U * static_cast<std::uint32_t>(side) + (query.target[side] < 0.0F ? 1U : 0U);
      end = SlideEnd::kMoved;
    }
  }
  return {to, end};
}

int normals(const ShapeData& /*shape*/, const Feature& feature, const Vec3& /*point*/,
            std::span<Vec3, 3> out) {
  out[0] = Vec3::Zero();
  out[0][static_cast<int>(feature.index >> 1U)] = (feature.index & 1U) == 0U ? 1.0F : -1.0F;
  return 1;
}

std::size_t faces(const ShapeData& shape, const Vec3& point, std::span<NearestPlace, 3> out) {
  for (int axis = 0; axis < 3; ++axis) {
    const float sign = std::copysign(1.0F, point[axis]);
    out[static_cast<std::size_t>(axis)] = {sign * Vec3::Unit(axis), sign * point[axis] - shape.vector[axis]};
  }
  return 3;
}

Feature feature(const ShapeData& /*shape*/, const Vec3& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return {.index = 2U * static_cast<std::uint32_t>(axis) + (normal[axis] < 0.0F ? 1U : 0U)};
}

Vec3 reach(const ShapeData& shape) { return shape.vector; }

NearestPlace nearest(const ShapeData& shape, const Vec3& p) { return nearest_on_box(shape.vector, p); }

std::size_t lowest(const ShapeData& shape, const Vec3& /*down*/, LowestPoints& out) {
  const Vec3& half = shape.vector;
  for (unsigned corner = 0; corner < 8; ++corner) {
    out[corner] = {(corner & 1U) != 0 ? half.x() : -half.x(), (corner & 2U) != 0 ? half.y() : -half.y(),
                   (corner & 4U) != 0 ? half.z() : -half.z()};
  }
  return 8;
}

BoxAbout box_about(const ShapeData& shape) { return {Vec3::Zero(), shape.vector}; }

}  // namespace
}  // namespace box

const SolidOps kBoxSolid{.check = box::check,
                         .view = box::view,
                         .sweep = box::sweep,
                         .slide = box::slide,
                         .faces = box::faces,
                         .feature = box::feature,
                         .normals = box::normals,
                         .reach = box::reach};
const CollisionOps kBoxCollision{
    .form = CollisionForm::kBox, .nearest = box::nearest, .lowest = box::lowest, .box_about = box::box_about};

}  // namespace thimble::control
