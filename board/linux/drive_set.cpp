#include "board/linux/drive_set.h"

#include <algorithm>
#include <cmath>

namespace thimble::board {
namespace {

using drives::DriveFault;
using drives::DriveState;
using drives::State;

constexpr float kEnable_s = 3;  // until all run: an ODrive reports its state ten times a second

bool is_off(const DriveState& one) {
  return one.state != State::kEnabled && one.state != State::kRunning && one.state != State::kBraking;
}
bool has_failed(const DriveState& one) { return one.fault != DriveFault::kNone; }
bool is_idle(const DriveState& one) { return one.state == State::kIdle; }
bool runs(const DriveState& one) { return one.state == State::kRunning; }

}  // namespace

template <class Test>
bool DriveSet::all(Test test) const noexcept {
  return std::ranges::all_of(buses_, [&](const Bus& bus) { return std::ranges::all_of(bus.states, test); });
}

void DriveSet::read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept {
  if (empty()) return;
  e_stop_ = in.e_stop;
  for (std::size_t i = 0; i < arms_.size(); ++i)
    if (driven_[i]) in.arm[i].evidence = {};
  for (Bus& bus : buses_) {
    bus.states = bus.bus->end_cycle(now_ns / 1000);
    read_bus(bus, in, period_ns);
  }
  if (!all([](const DriveState& one) { return !has_failed(one); })) fail();
  for (std::size_t i = 0; i < arms_.size(); ++i)
    if (driven_[i] && faulted_ && !acknowledged_) in.arm[i].drive_fault = true;
}

void DriveSet::read_bus(Bus& bus, firmware::Inputs& in, std::uint64_t period_ns) noexcept {
  for (std::size_t k = 0; k < bus.joints.size(); ++k) {
    const Joint& joint = *bus.joints[k];
    const DriveState& state = bus.states[k];
    bus.joints[k]->fault.store(static_cast<std::uint8_t>(state.fault), std::memory_order_relaxed);
    firmware::ArmInputs& arm = in.arm[joint.arm];
    take_evidence(joint, bus.torque_N_m[k], state, arm.evidence);
    if (!joint.encoder) continue;
    if (!state.position_known || std::isnan(state.age_us)) {
      arm.sample_tick = 0;
      continue;
    }
    // On the drive's own timer a sample is up to a period of that older, and still its newest.
    const float old_us = std::max(0.0F, state.age_us - bus.configs[k].reply_period_s * 1e6F);
    const auto old_ticks = static_cast<std::uint64_t>(std::min(old_us, 1e9F)) * 1000 / period_ns;
    arm.sample_tick = std::min(arm.sample_tick, in.tick - std::min(in.tick, old_ticks));
    const auto counts =
        std::llround(static_cast<double>(joint.direction) * state.position_rad * joint.counts_per_rad);
    arm.counts[joint.joint] = static_cast<std::uint32_t>(static_cast<std::uint64_t>(counts) & joint.mask);
  }
}

// The present command and what the drive gives more than was asked of it: a reply is a tick and a lag behind the command, which would look like
// a wrong current whenever the force changes fast. The drive's own damping is in both torques that are compared.
void DriveSet::take_evidence(const Joint& joint, float commanded_N_m, const DriveState& state,
                             firmware::ArmEvidence& evidence) const noexcept {
  if (gain_ == 1 && state.state == State::kRunning && !std::isnan(state.torque_N_m))
    evidence.current_A[joint.joint] =
        joint.direction * (commanded_N_m + state.torque_difference_N_m) / joint.torque_per_A;
  evidence.motor_C[joint.joint] = state.motor_C;
  // Of several the one that is farther off.
  const float nominal_V = arms_[joint.arm].arm.supply_V;
  if (!(std::abs(state.supply_V - nominal_V) <= std::abs(evidence.supply_V - nominal_V)) &&
      !std::isnan(state.supply_V))
    evidence.supply_V = state.supply_V;
}

void DriveSet::write(const firmware::Outputs& out, bool works, std::uint64_t now_ns) noexcept {
  if (empty()) return;
  bool wanted = works;
  for (std::size_t i = 0; i < arms_.size(); ++i)
    if (driven_[i]) wanted = wanted && out.arm[i].enable;
  follow(wanted, out.mode == firmware::Mode::kFaulted);
  for (Bus& bus : buses_) {
    for (std::size_t k = 0; k < bus.joints.size(); ++k) {
      const Joint& joint = *bus.joints[k];
      bus.torque_N_m[k] =
          gain_ * joint.direction * joint.torque_per_A * out.arm[joint.arm].current_A[joint.joint];
    }
    bus.bus->begin_cycle(now_ns / 1000, std::span(bus.torque_N_m).first(bus.joints.size()), {});
  }
}

// From what the controller wants to what the drives are told, before a cycle begins.
void DriveSet::follow(bool wanted, bool faulted_mode) noexcept {
  if (was_faulted_mode_ && !faulted_mode) {  // the controller's fault was cleared
    for (Bus& bus : buses_) bus.bus->clear();
    faulted_ = acknowledged_ = false;
    may_wake_ = true;
  }
  was_faulted_mode_ = faulted_mode;
  // The drives that have not failed brake for their time; until then the fault is shown.
  if (faulted_ && faulted_mode && all(is_off)) acknowledged_ = true;
  if (faulted_) return;

  waited_s_ = wanted ? waited_s_ + period_s_ : 0;
  switch (phase_) {
    case Phase::kOff:
      if ((wanted || (!faulted_mode && wants_to_wake())) && all(is_idle)) {
        enable();
      } else if (wanted && waited_s_ > kEnable_s) {
        fail();
      }
      break;
    case Phase::kEnabling:
      if (!wanted && !waking_) {
        stop();
      } else if (all(runs)) {
        phase_ = Phase::kOn;
        if (!wanted) stop();  // its position is known now
        waking_ = false;
      }
      break;
    case Phase::kOn:
      if (!wanted) stop();
      break;
  }
  gain_ = phase_ == Phase::kOn ? std::min(1.0F, gain_ + period_s_ / kRamp_s) : 0.0F;
}

bool DriveSet::wants_to_wake() const noexcept {
  return may_wake_ && !e_stop_ && std::ranges::any_of(buses_, [](const Bus& bus) {
           for (std::size_t k = 0; k < bus.states.size(); ++k)
             if (bus.joints[k]->encoder && !bus.states[k].position_known) return true;
           return false;
         });
}

void DriveSet::enable() noexcept {
  waking_ = waited_s_ == 0;
  may_wake_ = false;
  for (Bus& bus : buses_)
    if (!bus.bus->enable().empty()) return fail();
  phase_ = Phase::kEnabling;
}

void DriveSet::fail() noexcept {
  faulted_ = true;
  waking_ = false;
  phase_ = Phase::kOff;
  gain_ = 0;
  for (Bus& bus : buses_) bus.bus->disable();
}

void DriveSet::cut() noexcept {
  for (Bus& bus : buses_) bus.bus->stop(true);
}

void DriveSet::stop() noexcept {
  for (Bus& bus : buses_) bus.bus->stop();
  phase_ = Phase::kOff;
  // A controller that starts anew meanwhile: the positions are still not known.
  may_wake_ = may_wake_ || waking_;
  waking_ = false;
  gain_ = 0;
}

std::string DriveSet::news() {
  std::string all;
  for (Bus& bus : buses_)
    for (const auto& joint : bus.joints) {
      const std::uint8_t fault = joint->fault.load(std::memory_order_relaxed);
      if (fault == joint->told) continue;
      joint->told = fault;
      if (fault == 0) continue;
      const auto reason = static_cast<DriveFault>(fault);
      all.append(all.empty() ? "" : "; ").append(joint->text).append(": ").append(drives::name_of(reason));
      all.append(", ").append(drives::sentence_of(reason));
    }
  return all;
}

}  // namespace thimble::board
