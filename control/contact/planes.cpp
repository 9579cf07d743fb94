#include "control/contact/planes.h"

#include <algorithm>

namespace thimble::control {

Planes planes_at(const World& world, const GodObject& god) noexcept {
  Planes planes;
  if (god.is_ball) {
    for (; planes.count < god.count; ++planes.count) {
      planes.plane[planes.count] = {god.normals[planes.count], 0.0F};
      planes.contact[planes.count] = planes.count;
    }
    return planes;
  }
  for (std::size_t i = 0; i < god.count; ++i) {
    const PlacedObject& object = world.objects[god.contacts[i].object];
    std::array<Vec3, 3> normals;
    const Vec3 at = object.to_local(god.position_m);
    const int count = object.ops->normals(object.shape, god.contacts[i].feature, at, normals);
    Feature feature = god.contacts[i].feature;
    Work work(kInPlaceWork);
    const Vec3 out = object.ops->slide(object.shape, feature, {work, at, at, true}).to - at;
    for (int n = 0; n < count && planes.count < kMaxPlanes; ++n) {
      const Vec3& normal = normals[static_cast<std::size_t>(n)];
      planes.plane[planes.count] = {object.turn(normal),
                                    std::clamp(normal.dot(out), -kSurfaceTolerance_m, kSurfaceTolerance_m)};
      planes.contact[planes.count++] = i;
    }
  }
  return planes;
}

NearestInside project(const Planes& planes, const Vec3& r) noexcept {
  Work work(kHoldWork);
  NearestInside out = nearest_inside(std::span(planes.plane).first(planes.count), r, work);
  if (out.found) return out;
  out.count = 0;
  out.point_m = Vec3::Zero();
  return out;
}

std::size_t contact_normals(const World& world, const GodObject& god,
                            std::span<Vec3, kMaxContacts> normals) noexcept {
  const Planes planes = planes_at(world, god);
  const std::size_t count = std::min(planes.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) normals[i] = planes.plane[i].normal;
  return count;
}

Constraints constraints(const World& world, const GodObject& god, const Vec3& tip) noexcept {
  Constraints out;
  if (god.count == 0) return out;
  const Vec3 pull = god.position_m - tip;
  if (god.count > 1 || god.contacts[0].feature.kind != 0) {
    const Planes planes = planes_at(world, god);
    const NearestInside projection = project(planes, -pull);
    // When the planes do not balance the whole pull, they are not the constraints (a ridge, a saddle).
    constexpr float kHeld = 1.0e-3F;
    if (projection.point_m.squaredNorm() <= kHeld * kHeld * pull.squaredNorm()) {
      for (std::size_t i = 0; i < projection.count; ++i) {
        const std::size_t contact = planes.contact[projection.holding[i]];
        const std::uint8_t object = god.contacts[contact].object;
        out.list[i] = {object,
                       planes.plane[projection.holding[i]].normal,
                       projection.lambda_m[static_cast<Eigen::Index>(i)],
                       world.objects[object].material,
                       static_cast<std::uint8_t>(contact),
                       to_place(world, god, contact)};
      }
      out.count = projection.count;
      if (out.count > 0) return out;
    }
  }
  // One surface: it pushes along the line to the tip, which is its normal when the god object is at rest.
  const float depth = pull.norm();
  out.count = 1;
  const std::uint8_t object = god.contacts[0].object;
  out.list[0] = {object, depth > 0.0F ? Vec3(pull / depth) : Vec3(Vec3::Zero()),
                 depth,  world.objects[object].material,
                 0,      to_place(world, god, 0)};
  return out;
}

}  // namespace thimble::control
