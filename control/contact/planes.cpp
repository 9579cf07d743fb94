#include "control/contact/planes.h"

#include <algorithm>

namespace thimble::control {

Resting::Resting() noexcept = default;

void Resting::forget() noexcept {
  placed_ = projected_ = false;
  for (ShortSlide& slide : slides_) slide.shape = nullptr;
}

[[gnu::noinline]] ShortSlide& Resting::slide(const PlacedObject& object, const Feature& feature,
                                             const Vec3& from_m, const Vec3& target_m, Work& work) noexcept {
#pragma GCC unroll 1
  for (ShortSlide& slide : slides_)
    if (slide.target_m == target_m && slide.shape == &object.shape && slide.feature == feature &&
        slide.from_m == from_m)
      return slide;
  ShortSlide& slide = slides_[next_];
  next_ = (next_ + 1) % slides_.size();
  slide.feature = slide.feature_there = feature;
  slide.from_m = from_m;
  slide.target_m = target_m;
  const Slide found = object.ops->slide(object.shape, slide.feature_there, {work, from_m, target_m, true});
  slide.to_m = found.to;
  slide.end = found.end;
  slide.normal_count = 0;
  slide.shape = work.is_spent() ? nullptr : &object.shape;
  return slide;
}

bool Resting::is_at(const World& world, const GodObject& god) const noexcept {
  return placed_ && god.position_m == position_m_ && god.count == count_ && !world.any_bodies &&
         !god.is_ball && same_contacts(god, contacts_);
}

void Resting::find_planes(const World& world, const GodObject& god) noexcept {
  planes_.count = 0;
  placed_ = !god.is_ball;
  if (god.is_ball) {
    for (; planes_.count < god.count; ++planes_.count) {
      planes_.plane[planes_.count] = {god.normals[planes_.count], 0.0F};
      planes_.contact[planes_.count] = planes_.count;
    }
    return;
  }
  position_m_ = god.position_m;
  contacts_ = god.contacts;
  count_ = god.count;
  for (std::size_t i = 0; i < god.count; ++i) {
    const PlacedObject& object = world.objects[god.contacts[i].object];
    const Vec3 at = object.to_local(god.position_m);
    const Feature& feature = god.contacts[i].feature;
    Work work(kInPlaceWork);
    ShortSlide& there = slide(object, feature, at, at, work);
    placed_ = placed_ && there.shape != nullptr;
    if (there.normal_count == 0)
      there.normal_count = object.ops->normals(object.shape, feature, at, there.normals);
    const Vec3 out = there.to_m - at;
    for (int n = 0; n < there.normal_count && planes_.count < kMaxPlanes; ++n) {
      const Vec3& normal = there.normals[static_cast<std::size_t>(n)];
      planes_.plane[planes_.count] = {object.turn(normal),
                                      std::clamp(normal.dot(out), -kSurfaceTolerance_m, kSurfaceTolerance_m)};
      planes_.contact[planes_.count++] = i;
    }
  }
}

const Planes& Resting::planes_at(const World& world, const GodObject& god) noexcept {
  if (!is_at(world, god)) {
    find_planes(world, god);
    projected_ = false;
  }
  return planes_;
}

const NearestInside& Resting::project(const Vec3& r) noexcept {
  if (projected_ && r == r_m_) return projection_;
  projected_ = true;
  r_m_ = r;
  Work work(kHoldWork);
  projection_ = nearest_inside(std::span(planes_.plane).first(planes_.count), r, work);
  if (!projection_.found) {
    projection_.count = 0;
    projection_.point_m = Vec3::Zero();
  }
  return projection_;
}

std::size_t contact_normals(const World& world, const GodObject& god,
                            std::span<Vec3, kMaxContacts> normals) noexcept {
  Resting resting;
  const Planes& planes = resting.planes_at(world, god);
  const std::size_t count = std::min(planes.count, kMaxContacts);
  for (std::size_t i = 0; i < count; ++i) normals[i] = planes.plane[i].normal;
  return count;
}

void find_constraints(const World& world, const GodObject& god, const Vec3& tip, Resting& resting,
                      Constraints& held) noexcept {
  held.count = 0;
  if (god.count == 0) return;
  const Vec3 pull = god.position_m - tip;
  if (god.count > 1 || god.contacts[0].feature.kind != 0) {
    const Planes& planes = resting.planes_at(world, god);
    const NearestInside& projection = resting.project(tip - god.position_m);
    // When the planes do not balance the whole pull, they are not the constraints (a ridge, a saddle).
    constexpr float kHeld = 1.0e-3F;
    if (projection.point_m.squaredNorm() <= kHeld * kHeld * pull.squaredNorm()) {
      for (std::size_t i = 0; i < projection.count; ++i) {
        const std::size_t contact = planes.contact[projection.holding[i]];
        const std::uint8_t object = god.contacts[contact].object;
        held.list[i] = {object,
                        planes.plane[projection.holding[i]].normal,
                        projection.lambda_m[static_cast<Eigen::Index>(i)],
                        world.objects[object].material,
                        static_cast<std::uint8_t>(contact),
                        to_place(world, god, contact)};
      }
      held.count = projection.count;
      if (held.count > 0) return;
    }
  }
  // One surface: it pushes along the line to the tip, which is its normal when the god object is at rest.
  const float depth = pull.norm();
  held.count = 1;
  const std::uint8_t object = god.contacts[0].object;
  held.list[0] = {object, depth > 0.0F ? Vec3(pull / depth) : Vec3(Vec3::Zero()),
                  depth,  world.objects[object].material,
                  0,      to_place(world, god, 0)};
}

}  // namespace thimble::control
