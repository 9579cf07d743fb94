// One step of the bodies, over as many ticks as it takes (control/bodies/bodies.h).
#include <algorithm>

#include "control/bodies/bodies.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

constexpr std::uint32_t kAccelerateWork = 4;  // a body
constexpr std::uint32_t kMoveBodyWork = 12;

}  // namespace

void Bodies::accelerate_all(float period_s) noexcept {
  for (std::size_t i = 0; i < count_; ++i) accelerate(i, searched_loads_[i], period_s);
}

// The load of this tick, where the search began in an earlier one with another load: as far as no point of the body moves more than half of
// the gap at which contacts are collected farther by the difference. So no contact closes that the search left out.
Bodies::Load Bodies::searched_load(std::size_t body, float period_s) const noexcept {
  const BodyModel& model = models_[body];
  const Load& then = searched_loads_[body];
  const Vec3 force = loads_[body].force_N - then.force_N;
  const Vec3 torque = loads_[body].torque_N_m - then.torque_N_m;
  float faster_m_s2 = force.norm() / model.mass_kg;
  switch (model.motion) {
    case scene::Motion::Free:
      faster_m_s2 += model.reach_m * torque.norm() / model.inertia_kg_m2.minCoeff();
      break;
    case scene::Motion::Translate:
    case scene::Motion::Plane:
      break;
    case scene::Motion::Slide:
      faster_m_s2 = force.norm() / model.control_inertia;
      break;
    case scene::Motion::Turn:
      faster_m_s2 = model.reach_m * (torque.norm() + model.reach_m * force.norm()) / model.control_inertia;
      break;
  }
  constexpr float kMost_m = 0.5F * kContactMargin_m;
  const float farther_m = period_s * period_s * faster_m_s2;
  const float part = farther_m > kMost_m ? kMost_m / farther_m : 1.0F;
  return {then.force_N + part * force, then.torque_N_m + part * torque};
}

void Bodies::begin_anew() noexcept {
  stage_ = Stage::kBegin;
  if (pressed_ != 0) pressing_ = {};
  pressed_ = 0;
}

// False: all bodies sleep.
bool Bodies::begin(const World& world, float period_s, Work& work) noexcept {
  BodySet touched = pushed_;
  for (std::size_t i = 0; i < grip_count_; ++i) touched |= of_body(grips_[i].body);
  wake(touched);
  if (asleep_ == (1U << count_) - 1U) return false;
  std::copy_n(loads_.begin(), count_, searched_loads_.begin());
  accelerate_all(period_s);
  work.charge(kAccelerateWork * static_cast<std::uint32_t>(count_));
  wake_touched(world, period_s, work);
  solver_.begin(world, std::span(solver_bodies_).first(count_), std::span(grips_).first(grip_count_),
                period_s);
  stage_ = Stage::kSearch;
  return true;
}

void Bodies::step(World& world, std::span<Finger> fingers, float period_s, bool all_pressed,
                  Effort& effort) noexcept {
  bool done = false;
  if (!all_pressed) {
    stage_ = Stage::kPress;
    ++ticks_;
  } else {
    for (std::size_t i = 0; pressed_ != 0 && i < count_; ++i) {
      loads_[i].force_N += pressing_[i].force_N;
      loads_[i].torque_N_m += pressing_[i].torque_N_m;
    }
    pushed_ |= pressed_;
    if (stage_ <= Stage::kPress && !begin(world, period_s, effort.work)) {
      begin_anew();
      ticks_ = 0;
      pace_ = 1.0F;
      return;
    }
    ++ticks_;
    done = go_on(world, fingers, period_s, effort);
  }
  pace_ = done ? 1.0F / static_cast<float>(ticks_) : std::min(pace_, 1.0F / static_cast<float>(ticks_ + 1));
  if (done) {
    let_sleep(world, period_s);
    begin_anew();
    ticks_ = 0;
  }
  for (std::size_t i = 0; i < count_; ++i) loads_[i] = {};
  grip_count_ = 0;
  pushed_ = 0;
}

bool Bodies::go_on(World& world, std::span<Finger> fingers, float period_s, Effort& effort) noexcept {
  const std::span<SolverBody> bodies = std::span(solver_bodies_).first(count_);
  const bool whole_tick = stage_ == Stage::kMove;
  if (stage_ == Stage::kSearch) {
    if (!solver_.find(world, bodies, period_s, effort)) return false;
    if (ticks_ > 1) {
      for (std::size_t i = 0; i < count_; ++i) searched_loads_[i] = searched_load(i, period_s);
      accelerate_all(period_s);
      effort.work.charge(kAccelerateWork * static_cast<std::uint32_t>(count_));
    }
    stage_ = Stage::kSolve;
    if (effort.work.left() == 0) return false;
  }
  if (stage_ == Stage::kSolve) {
    if (!solver_.solve(bodies, period_s, effort.work)) return false;
    stage_ = Stage::kMove;
    moved_ = 0;
    pinned_ = {};
  }
  return move(world, fingers, period_s, whole_tick, effort);
}

// whole_tick: nothing else was done in this tick.
bool Bodies::move(World& world, std::span<Finger> fingers, float period_s, bool whole_tick,
                  Effort& effort) noexcept {
  for (bool first = true; moved_ < count_; ++moved_) {
    if (solver_bodies_[moved_].asleep) continue;
    const bool may_wait = !(whole_tick && first);
    if (may_wait && effort.work.left() == 0) return false;
    first = false;
    effort.work.charge(kMoveBodyWork);
    if (!move_body(moved_, world, fingers, period_s, may_wait, effort)) return false;
  }
  // When all have moved: a body that comes later would take its velocity from the contact solver.
  for (std::size_t i = 0; i < count_; ++i) {
    if (pinned_[i]) press(world, i, pins_[i]);
  }
  return true;
}

// False, where it may wait: the work does not suffice to carry a god object along, and nothing has changed. Where the work of a whole tick does not
// suffice, the body stops: it must go neither through the god object nor faster from tick to tick.
bool Bodies::move_body(std::size_t body, World& world, std::span<Finger> fingers, float period_s,
                       bool may_wait, Effort& effort) noexcept {
  const std::uint8_t index = models_[body].object;
  const PlacedObject before = world.objects[index];
  const Before was{states_[body], centres_[body], angular_momentum_[body], controls_[body], efforts_[body]};
  apply_contacts(body, period_s);
  limit_speed(body, period_s);
  advance(body, period_s);
  place(body, world.objects[index]);
  std::array<bool, kMaxArms> kept{};
  std::size_t carried = 0;
  for (; carried < fingers.size(); ++carried) {
    Finger& finger = fingers[carried];
    if (!finger.started || (finger.inside & only(index)) != 0) continue;
    kept[carried] = carried + 1 < fingers.size();
    if (kept[carried]) fingers_before_[carried] = {finger.god, finger.rest, finger.anchor};
    if (!carry(world, index, before, finger, pins_[body], effort)) break;
  }
  if (carried == fingers.size()) return true;
  for (std::size_t i = 0; i < carried; ++i) {
    if (!kept[i]) continue;
    fingers[i].god = fingers_before_[i].god;
    fingers[i].rest = fingers_before_[i].rest;
    fingers[i].anchor = fingers_before_[i].anchor;
  }
  world.objects[index] = before;
  if (effort.work.is_spent() && may_wait) {
    states_[body] = was.state;
    centres_[body] = was.centre;
    angular_momentum_[body] = was.angular_momentum;
    controls_[body] = was.control;
    efforts_[body] = was.effort;
    return false;
  }
  centres_[body].position_m = was.centre.position_m;
  states_[body].position_m = was.state.position_m;
  states_[body].rotation = was.state.rotation;
  states_[body].q = was.state.q;
  states_[body].on = was.state.on;
  const float speed = controls_[body].speed;
  controls_[body] = was.control;
  controls_[body].speed = speed;  // press() ends it
  still_s_[body] = 0.0F;
  if (effort.work.is_spent()) {
    stop(body);
  } else {
    pinned_[body] = true;
  }
  return true;
}

}  // namespace thimble::control
