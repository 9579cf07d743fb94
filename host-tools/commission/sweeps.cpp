#include "host-tools/commission/sweeps.h"

#include <algorithm>
#include <cmath>

namespace thimble::host {
namespace {

constexpr double kServo_Hz = 14, kServoDamping = .7;
constexpr double kTorque = .6;  // of the peak
constexpr double kBring_s = 1;
// The part of a motion that is used: about its middle, so that what the weight adds on the way up it takes on the way down.
constexpr double kFrom = .3, kTo = .7;

board::JointVector place_now(const StepContext& context) {
  PerAxis<std::int64_t> counts{};
  const PerAxis<AxisReading> readings = context.bench.read();
  for (std::size_t j = 0; j < context.arm.axes(); ++j) counts.at(j) = readings.at(j).counts;
  return angles(context, counts);
}

// Without what still accelerates the axis, as far as the file knows its inertia.
double mean_torque(const Expectation& arm, const BenchRecording& seen, std::size_t axis) {
  double sum = 0;
  const auto n = static_cast<double>(seen.ticks.size());
  const auto from = static_cast<std::size_t>(kFrom * n), to = static_cast<std::size_t>(kTo * n);
  if (to < from + 8) return 0;
  for (std::size_t k = from; k < to; ++k) sum += seen.ticks[k].asked_A.at(axis);
  const auto speed = [&](std::size_t first, std::size_t last) {
    return static_cast<double>(seen.ticks[last].counts.at(axis) - seen.ticks[first].counts.at(axis)) *
           arm.axis(axis).per_count() / (seen.ticks[last].time_s - seen.ticks[first].time_s);
  };
  const std::size_t half = (to - from) / 2;
  const double seconds = .5 * (seen.ticks[to].time_s - seen.ticks[from].time_s);
  const auto row = static_cast<Eigen::Index>(axis);
  const double acceleration = (speed(from + half, to) - speed(from, from + half)) / seconds;
  return sum / static_cast<double>(to - from) * arm.axis(axis).per_ampere() -
         arm.mass(arm.home())(row, row) * acceleration;
}

}  // namespace

ServoProgram servo_to(const Expectation& arm, const board::JointVector& from, const board::JointVector& to) {
  ServoProgram program;
  constexpr double kTip_kg = .1;
  // The least on the way: a tip with a short lever is light, and a servo for its weight at home swings where drives are some milliseconds late.
  const auto inertia_at = [&](const board::JointVector& at) -> board::JointVector {
    return arm.mass(at).diagonal() + kTip_kg * arm.jacobian(at).colwise().squaredNorm().transpose();
  };
  const board::JointVector least = inertia_at(arm.home()).cwiseMin(inertia_at(from)).cwiseMin(inertia_at(to));
  const double omega = 2 * 3.14159265358979 * kServo_Hz;
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const auto row = static_cast<Eigen::Index>(j);
    program.from.at(j) = from[row];
    program.to.at(j) = to[row];
    if (!arm.driven(j)) continue;
    const double inertia = least[row];
    program.stiffness_N_m_rad.at(j) = inertia * omega * omega;
    program.damping_N_m_s_rad.at(j) = 2 * kServoDamping * inertia * omega;
    program.most_torque_N_m.at(j) = kTorque * arm.axis(j).peak_torque();
  }
  return program;
}

PerAxis<Sweep> sweep_all(StepContext& context, const board::JointVector& at, double way, double speed) {
  const Expectation& arm = context.arm;
  board::JointVector by(at.size());
  for (std::size_t j = 0; j < arm.axes(); ++j)
    by[static_cast<Eigen::Index>(j)] = way * per_radian(arm.axis(j));
  ServoProgram bring = servo_to(arm, place_now(context), at - by);
  bring.move_s = kBring_s;
  bring.stay_s = .2;
  static_cast<void>(context.bench.servo(bring));
  PerAxis<Sweep> sweeps{};
  for (const double sign : {1.0, -1.0}) {
    ServoProgram program = servo_to(arm, at - sign * by, at + sign * by);
    program.move_s = 2 * way / speed / (1 - kServoRamp);
    const BenchRecording seen = context.bench.servo(program);
    for (std::size_t j = 0; j < arm.axes(); ++j) {
      if (!arm.driven(j)) continue;
      sweeps.at(j).speed = speed * per_radian(arm.axis(j));
      (sign > 0 ? sweeps.at(j).up_N_m : sweeps.at(j).down_N_m) = mean_torque(arm, seen, j);
    }
  }
  return sweeps;
}

Sweep sweep_one(StepContext& context, std::size_t axis, const board::JointVector& at, double way,
                double speed) {
  const Expectation& arm = context.arm;
  board::JointVector by = board::JointVector::Zero(at.size());
  by[static_cast<Eigen::Index>(axis)] = way;
  const board::JointVector now = place_now(context);
  ServoProgram bring = servo_to(arm, now, at - by);
  bring.move_s = std::max(.2, (at - by - now).cwiseAbs().maxCoeff());
  bring.stay_s = .1;
  static_cast<void>(context.bench.servo(bring));
  Sweep sweep;
  sweep.speed = speed;
  for (const double sign : {1.0, -1.0}) {
    ServoProgram program = servo_to(arm, at - sign * by, at + sign * by);
    program.move_s = 2 * way / speed / (1 - kServoRamp);
    (sign > 0 ? sweep.up_N_m : sweep.down_N_m) = mean_torque(arm, context.bench.servo(program), axis);
  }
  return sweep;
}

}  // namespace thimble::host
