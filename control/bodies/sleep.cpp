// Bodies that sleep (control/bodies/bodies.h).
#include "control/bodies/bodies.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

// A body whose surface moves more slowly than this, for as long as this, lies still: what the contacts of a stack have left of their
// iterations is a tenth of it.
constexpr float kStill_m_s = 1.0e-4F;
// A slider, dial or button can be damped as much as its spring is weak, and comes to rest on springs, friction or stops of its own.
constexpr float kStillControl_m_s = 1.0e-6F;
constexpr float kStill_s = 0.25F;
// Between boxes: what wakes, for a body that is still.
constexpr float kNear_m = 2.0F * kContactMargin_m;
constexpr std::uint32_t kBoxesPerUnit = 2;  // of work

}  // namespace

bool Bodies::is_still(std::size_t body) const noexcept {
  const BodyModel& model = models_[body];
  if ((pushed_ & of_body(body)) != 0) return false;
  const float spin_m_s = model.reach_m * states_[body].spin_rad_s.norm();
  const float most_m_s = states_[body].controlled ? kStillControl_m_s : kStill_m_s;
  return centres_[body].velocity_m_s.norm() + spin_m_s < most_m_s;
}

void Bodies::wake(BodySet bodies) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    if ((bodies & asleep_ & of_body(i)) == 0) continue;
    const BodySet island = islands_[i];
    for (std::size_t k = 0; k < count_; ++k)
      if ((island & of_body(k)) != 0) still_s_[k] = 0.0F;
    asleep_ &= static_cast<BodySet>(~island);
  }
}

// Those that an awake body comes near to in this step, and those that they in turn are near to.
void Bodies::wake_touched(const World& world, float period_s, Work& work) noexcept {
  const auto all = static_cast<BodySet>((1U << count_) - 1U);
  BodySet looked = asleep_;
  while (asleep_ != 0 && looked != all) {
    BodySet touched = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      if ((looked & of_body(i)) != 0) continue;
      looked |= of_body(i);
      work.charge(1 + static_cast<std::uint32_t>(count_) / kBoxesPerUnit);
      const PlacedObject& near = world.objects[models_[i].object];
      const float margin_m = kContactMargin_m + period_s * solver_bodies_[i].velocity_m_s.norm();
      for (std::size_t k = 0; k < count_; ++k) {
        if ((asleep_ & of_body(k)) != 0 && boxes_overlap(near, world.objects[models_[k].object], margin_m))
          touched |= of_body(k);
      }
    }
    const BodySet before = asleep_;
    wake(touched);
    const auto woken = static_cast<BodySet>(before & ~asleep_);
    looked &= static_cast<BodySet>(~woken);
    for (std::size_t k = 0; k < count_; ++k)
      if ((woken & of_body(k)) != 0) accelerate(k, searched_loads_[k], period_s);
  }
}

// After a step: all that are near each other lie still, or none of them sleeps. Near is what would wake them: else two that lie side by side
// would wake each other in turns.
void Bodies::let_sleep(const World& world, float period_s) noexcept {
  BodySet still = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if ((asleep_ & of_body(i)) != 0) continue;
    still_s_[i] = is_still(i) ? still_s_[i] + period_s : 0.0F;
    if (still_s_[i] >= kStill_s) still |= of_body(i);
  }
  if (still == 0) return;
  std::array<BodySet, kMaxBodies> near{};
  for (std::size_t i = 0; i < count_; ++i) {
    if ((still & of_body(i)) == 0) continue;
    for (std::size_t k = 0; k < count_; ++k) {
      const bool awake = (asleep_ & of_body(k)) == 0;
      if (awake && boxes_overlap(world.objects[models_[i].object], world.objects[models_[k].object], kNear_m))
        near[i] |= of_body(k);
    }
  }
  for (std::size_t i = 0; i < count_; ++i) {
    if ((still & ~asleep_ & of_body(i)) == 0) continue;
    BodySet island = of_body(i);
    for (BodySet before = 0; island != before;) {
      before = island;
      for (std::size_t k = 0; k < count_; ++k)
        if ((before & of_body(k)) != 0) island |= near[k];
    }
    if ((island & ~still) != 0) continue;
    for (std::size_t k = 0; k < count_; ++k) {
      if ((island & of_body(k)) == 0) continue;
      islands_[k] = island;
      stop(k);
    }
    asleep_ |= island;
  }
}

}  // namespace thimble::control
