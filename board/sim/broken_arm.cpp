#include "board/sim/broken_arm.h"

#include <cmath>

namespace thimble::board {
namespace {

// Levels of the channels at a count: A leads B, four counts a cycle.
bool channel_a(std::uint32_t count) { return count % 4 == 1 || count % 4 == 2; }
bool channel_b(std::uint32_t count) { return count % 4 >= 2; }

std::uint32_t wrapped(const kinematics::AxisData& axis, std::uint32_t count) {
  return count & UINT32_MAX >> (32U - axis.counter_bits);
}

}  // namespace

void BrokenArm::set_joint(const PlannedFault& fault, bool broken, const SimArm& arm, std::size_t joint) {
  using enum Injection;
  Joint& j = joints_[joint];
  const double now_s = arm.time_s();
  const std::uint32_t now = counts(j, arm.encoder_counts()[joint], now_s);
  if (fault.kind == kEncoderDead || fault.kind == kEncoderCable) {
    j.register_now = broken ? std::optional(now) : std::nullopt;
    j.line = broken && fault.kind == kEncoderCable;
  } else if (fault.kind == kEncoderStuck) {
    j.register_now = broken ? std::optional(static_cast<std::uint32_t>(fault.value)) : std::nullopt;
  } else if (fault.kind == kEncoderPhaseA || fault.kind == kEncoderPhaseB) {
    j.dead_phase_b = broken ? std::optional(fault.kind == kEncoderPhaseB) : std::nullopt;
    j.phase_base = now;
  } else if (fault.kind == kEncoderSlip) {
    if (broken) j.slip_counts += fault.value;  // what was lost stays lost
  } else if (fault.kind == kEncoderDrift) {
    j.slip_counts += j.drift_counts_s * (now_s - j.drift_from_s);
    j.drift_counts_s = broken ? fault.value : 0;
    j.drift_from_s = now_s;
  } else if (fault.kind == kMotorReversed) {
    j.reversed = broken;
  } else if (fault.kind == kMotorWeak) {
    j.torque = broken ? fault.value : 1;
  } else if (fault.kind == kAmplifierStuck) {
    j.stuck_A = broken ? std::optional(fault.value) : std::nullopt;
  }
}

void BrokenArm::set(const PlannedFault& fault, bool broken, const SimArm& arm) {
  using enum Injection;
  if (fault.kind == kSamplesStale) stale_ = broken;
  if (fault.kind == kIndexMissing) index_missing_ = broken;
  if (fault.kind == kIndexElsewhere) index_at_rad_ = broken ? fault.value : 0;
  if (fault.kind == kConverterStuck) converter_stuck_ = broken;
  if (fault.kind == kSupply) supply_ = broken ? fault.value : 1;
  if (fault.kind == kDriveFault) drive_fault_ = broken;
  for (std::size_t j = 0; j < arm.axes(); ++j)
    if (!fault.joint || *fault.joint == j) set_joint(fault, broken, arm, j);
}

std::uint32_t BrokenArm::counts(const Joint& joint, std::uint32_t sound, double time_s) const {
  if (joint.register_now) return *joint.register_now;
  const double slipped = joint.slip_counts + joint.drift_counts_s * (time_s - joint.drift_from_s);
  const std::uint32_t count = sound + static_cast<std::uint32_t>(std::llround(slipped));
  if (!joint.dead_phase_b) return count;
  // The decoder sees the edges of one channel only; the level of the other one gives their direction.
  const std::uint32_t base = joint.phase_base;
  const int edge =
      *joint.dead_phase_b ? channel_a(count) - channel_a(base) : channel_b(count) - channel_b(base);
  const bool forward = *joint.dead_phase_b ? !channel_b(base) : channel_a(base);
  return base + static_cast<std::uint32_t>(forward ? edge : -edge);
}

void BrokenArm::sense(const SimArm& arm, const Sensors& sensors, double time_s, firmware::ArmInputs& in) {
  const auto sound = arm.encoder_counts();
  firmware::ArmEvidence& evidence = in.evidence;
  evidence = {};
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    if (!stale_) in.counts[j] = wrapped(arm.data().axis[j], counts(joints_[j], sound[j], time_s));
    if (sensors.line_loss) evidence.line_loss = evidence.line_loss || joints_[j].line;
    if (sensors.current) evidence.current_A[j] = static_cast<float>(arm.motor(j).current_A);
    if (sensors.temperature) evidence.motor_C[j] = static_cast<float>(arm.motor(j).winding_C);
  }
  if (sensors.supply) evidence.supply_V = static_cast<float>(supply_) * arm.data().supply_V;
  in.drive_fault = drive_fault_;
  in.index = false;
  if (!sensors.index || index_missing_) return;
  in.index = true;
  const SimArm::PerAxis rotors_rad = arm.rotors_rad();
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const auto axis = static_cast<Eigen::Index>(j);
    const double off = rotors_rad[axis] - static_cast<double>(arm.data().geometry.home[axis]) - index_at_rad_;
    const float count_rad = std::abs(arm.data().axis[j].rad_per_count());
    in.index = in.index && std::abs(off) <= 2 * static_cast<double>(count_rad);
  }
}

bool BrokenArm::drive(const firmware::ArmOutputs& out, SimArm& arm) {
  SimArm::PerAxis current_A = SimArm::PerAxis::Zero(), torque = SimArm::PerAxis::Ones();
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const auto axis = static_cast<Eigen::Index>(j);
    if (!converter_stuck_) commanded_A_[axis] = static_cast<double>(out.current_A[j]);
    current_A[axis] = joints_[j].stuck_A.value_or(commanded_A_[axis]);
    torque[axis] = joints_[j].reversed ? -joints_[j].torque : joints_[j].torque;
  }
  arm.set_drives(supply_, torque);
  const bool on = out.enable && !drive_fault_;
  arm.command_current(current_A, on);
  return on;
}

}  // namespace thimble::board
