#include "control/fields/fields.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/god_object.h"
#include "control/scene/shape_table.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

// Null for a solid.
const VolumeOps* volume_ops(const scene::Object& object) { return shape_row(object.shape_type()).volume; }

// A checksum (FNV-1a) of a volume's kind and pose and the radius of the tip that it meets; never 0. Two of one scene that have the same are
// alike, but for a chance of 2^-31.
[[gnu::cold, gnu::noinline]] std::uint32_t which_of(const scene::Object& object, float tip_radius_m) {
  std::uint32_t which =
      std::bit_cast<std::uint32_t>(tip_radius_m) ^ static_cast<std::uint32_t>(object.shape_type());
  for (const std::byte byte : std::as_bytes(std::span(object.pose(), 1)))
    which = (which ^ std::to_integer<std::uint32_t>(byte)) * 16777619U;
  // The state of a force field belongs to its numbers: with others it begins anew (force_field.cpp).
  const scene::ForceField* const field = object.shape_as_ForceField();
  if (field != nullptr)
    for (const std::byte byte : std::as_bytes(std::span(field, 1)))
      which = (which ^ std::to_integer<std::uint32_t>(byte)) * 16777619U;
  return which | 1U;
}

bool holds(const VolumeBounds& bounds, const Vec3& p) {
  return (p.array() >= bounds.lo_m.array()).all() && (p.array() <= bounds.hi_m.array()).all();
}

}  // namespace

void Fields::apply_materials(const SceneView& view) noexcept {
  std::size_t index = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    if (volume_ops(*object) == nullptr || index == count_) continue;
    placed_[index].source = object;
    placed_[index++].material = view_material(*object->material());
  }
}

// Each volume gets the state that it had in the last scene, or a new one in a place that is left.
void Fields::find_states(float tip_radius_m) noexcept {
  std::uint32_t taken = 0;
  static_assert(kMaxVolumes <= 32);
  for (const bool is_new : {false, true}) {
    for (std::size_t i = 0; i < count_; ++i) {
      Placed& placed = placed_[i];
      if (is_new && placed.state != kMaxVolumes) continue;
      const std::uint32_t which = which_of(*placed.source, tip_radius_m);
      std::size_t at = 0;
      while (at < kMaxVolumes && ((taken >> at & 1U) != 0 || (!is_new && state_[at].of != which))) ++at;
      placed.state = static_cast<std::uint8_t>(at);
      if (at < kMaxVolumes) taken |= 1U << at;
      if (!is_new) continue;
      state_[at].reset();
      state_[at].of = which;
    }
  }
  for (std::size_t at = 0; at < kMaxVolumes; ++at)
    if ((taken >> at & 1U) == 0) state_[at].of = 0;
}

void Fields::bind(const SceneView& view, Binding binding) noexcept {
  count_ = 0;
  if (binding != Binding::kKeepPlaces)
    for (State& state : state_) state.of = 0;
  if (view.scene() == nullptr) return;
  std::uint8_t in_scene = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    const std::uint8_t place = in_scene++;
    const VolumeOps* ops = volume_ops(*object);
    if (ops == nullptr) continue;
    Placed& placed = placed_[count_++];
    placed.ops = ops;
    placed.source = object;
    placed.object = place;
    const scene::ForceField* field = object->shape_as_ForceField();
    placed.trial = field == nullptr ? 0 : static_cast<std::uint8_t>(field->trial());
    placed.material = view_material(*object->material());
    placed.rotation = to_rotation(object->pose()->rotation()).toRotationMatrix();
    placed.position_m = to_vec(object->pose()->position_m());
    placed.bounds = ops->bounds(*object);
    // A tissue is pressed by the lowest point of the tip's sphere; all others act on its centre.
    placed.to_tip_m = {0.0F, 0.0F, ops == &kTissueVolume ? view.scene()->tip_radius_m() : 0.0F};
  }
  find_states(view.scene()->tip_radius_m());
}

void Fields::State::reset() noexcept {
  shared = {};
  arms = {};
}

void Fields::reset() noexcept {
  for (State& state : state_) state.reset();
}

void Fields::reset(std::size_t arm) noexcept {
  for (const Placed& placed : std::span(placed_).first(count_)) {
    State& state = state_[placed.state];
    ArmState& own = state.arms[arm];
    if (own.inside && placed.ops == &kNeedleVolume) --state.shared.holes[own.hole].needles;
    own = {};
  }
}

std::size_t Fields::show(TissueViews& views) const noexcept {
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool is_needle = placed_[i].ops == &kNeedleVolume;
    if (!is_needle && placed_[i].ops != &kTissueVolume) continue;
    for (std::uint8_t arm = 0; arm < kMaxArms; ++arm) {
      const ArmState& own = state_[placed_[i].state].arms[arm];
      if (!own.seen) continue;
      Vec3 middle = own.middle_m;
      if (is_needle) middle = own.grip_m;
      views[count++] = {.object = placed_[i].object,
                        .arm = arm,
                        .is_needle = is_needle,
                        .inside = own.inside,
                        .torn = is_needle && own.inside ? state_[placed_[i].state].shared.holes[own.hole].torn
                                                        : std::uint8_t{0},
                        .x_m = middle.x(),
                        .y_m = middle.y(),
                        .depth_m = own.depth_m};
    }
  }
  return count;
}

void Fields::tick(std::size_t arm, const Tip& tip, float period_s, Touch& touch) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    const Placed& placed = placed_[i];
    State& state = state_[placed.state];
    ArmState& own = state.arms[arm];
    const Vec3 p = placed.rotation.transpose() * (tip.position_m - placed.position_m) - placed.to_tip_m;
    if (!holds(placed.bounds, p) || (placed.trial != 0 && placed.trial != trial_)) {
      own = {};
      continue;
    }
    const Tip local{p, placed.rotation.transpose() * tip.velocity_m_s};
    const VolumeTouch felt =
        placed.ops->tick(*placed.source, placed.material, local, period_s, state.shared, own);
    if (felt.contacts == 0) continue;
    touch.force_N += placed.rotation * felt.force_N;
    // A field without a spring shows the tip itself.
    if (touch.contacts == 0 || touch.god_object_m == tip.position_m)
      touch.god_object_m = placed.rotation * (felt.proxy_m + placed.to_tip_m) + placed.position_m;
    touch.contacts =
        static_cast<std::uint8_t>(std::min<std::size_t>(touch.contacts + felt.contacts, kMaxContacts));
  }
}

}  // namespace thimble::control
