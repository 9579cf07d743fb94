#include "control/fields/fields.h"

#include <algorithm>
#include <cstddef>

#include "control/contact/god_object.h"
#include "control/scene/shape_table.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

// Null for a solid.
const VolumeOps* volume_ops(const scene::Object& object) { return shape_row(object.shape_type()).volume; }

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

// State `to` becomes that of `which` in the last scene, or a new one. Those behind it keep their order: they may be asked for next.
void Fields::take_state(std::size_t to, const Which& which) noexcept {
  std::size_t at = to;
  while (at < state_.size() && !(state_[at].which == which)) ++at;
  const bool is_new = at == state_.size();
  if (is_new) {
    at = to;
    while (at + 1 < state_.size() && state_[at].which.ops != nullptr) ++at;
  }
  const State found = is_new ? State{which, {}, {}} : state_[at];
  for (; at > to; --at) state_[at] = state_[at - 1];
  state_[to] = found;
}

void Fields::bind(const SceneView& view, Binding binding) noexcept {
  count_ = 0;
  if (binding != Binding::kKeepPlaces) state_ = {};
  if (view.scene() == nullptr) return;
  std::uint8_t in_scene = 0;
  for (const scene::Object* object : *view.scene()->objects()) {
    const std::uint8_t place = in_scene++;
    const VolumeOps* ops = volume_ops(*object);
    if (ops == nullptr) continue;
    const scene::Vec3& position = object->pose()->position_m();
    const scene::Quat& rotation = object->pose()->rotation();
    take_state(count_, {ops,
                        {position.x(), position.y(), position.z(), rotation.w(), rotation.x(), rotation.y(),
                         rotation.z(), view.scene()->tip_radius_m()}});
    Placed& placed = placed_[count_++];
    placed.ops = ops;
    placed.source = object;
    placed.object = place;
    placed.material = view_material(*object->material());
    placed.rotation = to_rotation(object->pose()->rotation()).toRotationMatrix();
    placed.position_m = to_vec(object->pose()->position_m());
    placed.bounds = ops->bounds(*object);
    // A tissue is pressed by the lowest point of the tip's sphere; all others act on its centre.
    placed.to_tip_m = {0.0F, 0.0F, ops == &kTissueVolume ? view.scene()->tip_radius_m() : 0.0F};
  }
  for (std::size_t i = count_; i < state_.size(); ++i) state_[i] = {};
}

void Fields::reset() noexcept {
  for (State& state : state_) {
    state.shared = {};
    state.arms = {};
  }
}

void Fields::reset(std::size_t arm) noexcept {
  for (State& state : state_) {
    ArmState& own = state.arms[arm];
    if (own.inside && state.which.ops == &kNeedleVolume) --state.shared.holes[own.hole].needles;
    own = {};
  }
}

std::size_t Fields::show(TissueViews& views) const noexcept {
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const bool is_needle = placed_[i].ops == &kNeedleVolume;
    if (!is_needle && placed_[i].ops != &kTissueVolume) continue;
    for (std::uint8_t arm = 0; arm < kMaxArms; ++arm) {
      const ArmState& own = state_[i].arms[arm];
      if (!own.seen) continue;
      Vec3 middle = own.middle_m;
      if (is_needle) middle = own.grip_m;
      views[count++] = {
          .object = placed_[i].object,
          .arm = arm,
          .is_needle = is_needle,
          .inside = own.inside,
          .torn = is_needle && own.inside ? state_[i].shared.holes[own.hole].torn : std::uint8_t{0},
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
    ArmState& own = state_[i].arms[arm];
    const Vec3 p = placed.rotation.transpose() * (tip.position_m - placed.position_m) - placed.to_tip_m;
    if (!holds(placed.bounds, p)) {
      own = {};
      continue;
    }
    const Tip local{p, placed.rotation.transpose() * tip.velocity_m_s};
    const VolumeTouch felt =
        placed.ops->tick(*placed.source, placed.material, local, period_s, state_[i].shared, own);
    if (felt.contacts == 0) continue;
    touch.force_N += placed.rotation * felt.force_N;
    if (touch.contacts == 0)
      touch.god_object_m = placed.rotation * (felt.proxy_m + placed.to_tip_m) + placed.position_m;
    touch.contacts =
        static_cast<std::uint8_t>(std::min<std::size_t>(touch.contacts + felt.contacts, kMaxContacts));
  }
}

}  // namespace thimble::control
