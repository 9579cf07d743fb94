// Steps 4 to 6: the first current, the first motion, the first closed loop.
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "host-tools/commission/balance.h"
#include "host-tools/commission/pulses.h"

namespace thimble::host {
namespace {

constexpr double kCurrentPart = .1, kCurrentFloor_A = .02;
constexpr double kBelowFault =
    .08;  // of the peak; a device that misses a tenth of it reports current_mismatch
constexpr double kResistancePart = .25;
constexpr double kTorqueConstantPart = .12;
constexpr double kMovesAbove = 1.2;  // friction: less torque shows no motion of a sound axis
constexpr double kNoEmf = .05;       // of the expected one: another joint turns that motor, or none

// Voltage by the speed of the motor while the builder turns the joint.
double torque_constant(StepContext& context, std::size_t axis) {
  const Expectation& arm = context.arm;
  const BenchRecording seen = context.bench.watch(
      prompt(Prompt::Kind::kSwing, axis,
             fmt::format("Turn {} to and fro by hand, as fast as you like. Its drive is on, without torque.",
                         quoted(arm, axis))),
      true);
  constexpr std::size_t kHalf = 10;  // ticks of 1 ms, to either side
  double product = 0, square = 0;
  const double turns = arm.axis(axis).per_ampere() / arm.axis(axis).motor->torque_constant_N_m_A.value;
  for (std::size_t k = kHalf; k + kHalf < seen.ticks.size(); ++k) {
    const double voltage = seen.ticks[k].voltage_V.at(axis);
    if (std::isnan(voltage)) return 0;
    const auto counts =
        static_cast<double>(seen.ticks[k + kHalf].counts.at(axis) - seen.ticks[k - kHalf].counts.at(axis));
    const double seconds = seen.ticks[k + kHalf].time_s - seen.ticks[k - kHalf].time_s;
    const double speed = counts * arm.axis(axis).per_count() * turns / seconds;
    product += voltage * speed;
    square += speed * speed;
  }
  return square > 0 ? product / square : 0;
}

void judge_torque_constant(StepContext& context, std::size_t j, StepResult& result) {
  const double given = context.arm.axis(j).motor->torque_constant_N_m_A.value;
  const double seen = std::abs(torque_constant(context, j));
  if (seen < kNoEmf * given) {
    result.notes.push_back(
        quoted(context.arm, j) +
        ": no voltage was seen while it was turned: the drive does not measure it, or step 5 tells.");
    context.known.torque_constant_N_m_A.at(j) = 0;
    return;
  }
  context.known.torque_constant_N_m_A.at(j) = seen;
  result.measures.push_back({"torque_constant_N_m_A", static_cast<int>(j), given, seen, .01 * seen, 0, .03});
  if (std::abs(seen / given - 1) <= kTorqueConstantPart) return;
  ArmFinding found =
      finding(context.arm, ArmFault::kWeakMotor, j,
              fmt::format("{:.4f} V s/rad when it is turned, {:.4f} N m/A in the file: {:.2f} times", seen,
                          given, seen / given),
              seen / given);
  found.corrections = {{fmt::format("/axes/{}/motor/torque_constant_N_m_A", j), seen}};
  result.findings.push_back(found);
}

void judge_current(StepContext& context, std::size_t j, StepResult& result) {
  const Expectation& arm = context.arm;
  constexpr double kLong_s = .5 * kPulse_s;
  double asked_A =
      std::min(.8 * gentle_current_A(arm, j), kBelowFault * arm.axis(j).motor->peak_current_A.value);
  if (arm.knows_inertia()) asked_A = std::min(asked_A, current_to_end_A(arm, j, kLong_s));
  std::vector<double> ohms;
  double worst_A = 0, least_part = 1;
  for (const double sign : {1.0, -1.0}) {
    if (place(context, j, resting_place(context, j)) == Answer::kStop) {
      result.stopped = true;
      return;
    }
    // Over a link the first reading may come when a pulse is over.
    constexpr int kTrials = 3;
    PulseSeen seen = pulse(context, j, j, sign * asked_A, kLong_s);
    for (int trial = 1; trial < kTrials && std::isnan(seen.current_A); ++trial) {
      if (place(context, j, resting_place(context, j)) == Answer::kStop) {
        result.stopped = true;
        return;
      }
      seen = pulse(context, j, j, sign * asked_A, kLong_s);
    }
    if (std::isnan(seen.current_A)) {
      result.notes.push_back(quoted(arm, j) +
                             ": this drive does not measure its current; step 5 tells whether it flows.");
      return;
    }
    worst_A = std::max(worst_A, std::abs(seen.current_A - sign * asked_A));
    least_part = std::min(least_part, std::abs(seen.current_A) / asked_A);
    if (!std::isnan(seen.voltage_V)) ohms.push_back(seen.voltage_V / seen.current_A);
  }
  if (least_part < .1 && worst_A > .5 * asked_A) {
    result.findings.push_back(
        finding(arm, ArmFault::kOpenWinding, j, fmt::format("{:.2f} A were asked for", asked_A)));
    return;
  }
  if (worst_A > kCurrentPart * asked_A + kCurrentFloor_A)
    result.findings.push_back(finding(arm, ArmFault::kCurrentLoop, j,
                                      fmt::format("{:.2f} A asked for, off by {:.2f} A", asked_A, worst_A)));
  if (ohms.size() < 2) return;
  // Its speed turns the motor, by its weight or for want of friction: that voltage is no resistance.
  if (std::min(ohms[0], ohms[1]) <= 0 || std::abs(ohms[0] - ohms[1]) > .5 * std::abs(ohms[0] + ohms[1])) {
    result.notes.push_back(
        fmt::format("{}: its resistance is not known, {:.2f} and {:.2f} ohm by the two directions: it moves "
                    "when it is let go.",
                    quoted(arm, j), ohms[0], ohms[1]));
    return;
  }
  const double given = arm.axis(j).motor->resistance_ohm.value, mean = .5 * (ohms[0] + ohms[1]);
  result.measures.push_back(
      {"resistance_ohm", static_cast<int>(j), given, mean, .5 * std::abs(ohms[0] - ohms[1]), 0, .1});
  // A voltage of 20 mV is not told apart.
  if (std::abs(mean / given - 1) <= kResistancePart + .02 / (asked_A * given)) return;
  ArmFinding found = finding(arm, ArmFault::kWrongResistance, j,
                             fmt::format("{:.2f} ohm, {:.2f} in the file", mean, given), mean / given);
  found.corrections = {{fmt::format("/axes/{}/motor/resistance_ohm", j), mean}};
  result.findings.push_back(found);
}

// The drive of `axis` does not move it: lets one joint after the other go.
int joint_of_drive(StepContext& context, std::size_t axis) {
  const Expectation& arm = context.arm;
  const double current_A = gentle_current_A(arm, axis);
  for (std::size_t k = 0; k < arm.axes(); ++k) {
    if (k == axis || !arm.driven(k)) continue;
    for (const double sign : {1.0, -1.0}) {
      if (place(context, k, resting_place(context, k)) == Answer::kStop) return -1;
      if (pulse(context, axis, k, sign * current_A, kPulse_s).moved) return static_cast<int>(k);
    }
  }
  return -1;
}

void no_motion(StepContext& context, std::size_t j, StepResult& result) {
  const Expectation& arm = context.arm;
  const int other = joint_of_drive(context, j);
  if (other >= 0) {
    const auto k = static_cast<std::size_t>(other);
    for (const ArmFinding& before : result.findings)
      if (before.fault == ArmFault::kMotorsSwapped && before.axis == other &&
          before.other == static_cast<int>(j))
        return;
    ArmFinding found = finding(arm, ArmFault::kMotorsSwapped, j,
                               fmt::format("the drive of {} moves {}", quoted(arm, j), quoted(arm, k)));
    found.other = other;
    found.corrections = {
        {fmt::format("/axes/{}/drive/port", j), static_cast<double>(arm.axis(k).drive->port)},
        {fmt::format("/axes/{}/drive/port", k), static_cast<double>(arm.axis(j).drive->port)}};
    result.findings.push_back(found);
    return;
  }
  const double torque = gentle_current_A(arm, j) * std::abs(arm.axis(j).per_ampere());
  ArmFinding found = finding(arm, ArmFault::kNoMotion, j,
                             fmt::format("{:.3f} N m, {:.3f} N m of friction in the file", torque,
                                         arm.axis(j).friction.coulomb_N_m.value));
  found.twins = {ArmFault::kOpenWinding, ArmFault::kDeadPhase, ArmFault::kWeakMotor};
  if (torque < kMovesAbove * arm.axis(j).friction.coulomb_N_m.value)
    found.text += fmt::format(
        " No more is allowed before step 7, whichever joint the drive may turn: {:.1g} N at the tip. An "
        "arm with so much friction cannot be commissioned so.",
        .5 * kTipForce_N);
  result.findings.push_back(found);
}

// Three or more motors in a ring: one finding, which puts all of them right.
void join_ring(const Expectation& arm, std::vector<ArmFinding>& findings) {
  const auto is_exchange = [](const ArmFinding& found) { return found.fault == ArmFault::kMotorsSwapped; };
  const auto first = std::ranges::find_if(findings, is_exchange);
  if (std::ranges::count_if(findings, is_exchange) < 3) return;
  std::vector<Correction> all;
  int at = first->axis;
  do {
    const auto step = std::ranges::find_if(
        findings, [&](const ArmFinding& found) { return is_exchange(found) && found.axis == at; });
    if (step == findings.end() || all.size() > findings.size()) return;
    // The drive of this axis moves the other one: its port belongs to that.
    all.push_back({fmt::format("/axes/{}/drive/port", step->other),
                   static_cast<double>(arm.axis(static_cast<std::size_t>(at)).drive->port)});
    at = step->other;
  } while (at != first->axis);
  if (all.size() < 3) return;
  first->corrections = all;
  first->text += fmt::format(" The plugs of {} motors go round.", all.size());
  const ArmFinding kept = *first;
  std::erase_if(findings, is_exchange);
  findings.push_back(kept);
}

// Two places or more at which it does, in both directions, less than half of what it does at most others: what part of that.
std::optional<double> dead_phase(const PulseSeries& series) {
  std::vector<double> strength;
  strength.reserve(series.places());
  for (std::size_t k = 0; k < series.places(); ++k) {
    const PulseSeen &up = series.up[k], &down = series.down[k];
    const auto size = [](const PulseSeen& seen) {
      return seen.clean ? std::abs(seen.acceleration / seen.asked_A) : 0.0;
    };
    const double most = std::max(size(up), size(down));
    if (most > 0 || (!up.moved && !down.moved)) strength.push_back(most);
  }
  if (strength.size() < 4) return {};
  std::ranges::sort(strength);
  const double most = strength[strength.size() - 2];
  if (!(strength[1] < .5 * most)) return {};
  return strength[1] / most;
}

// Torque by inertia is off: the motor or the inertia, unless the torque constant is known.
void judge_strength(StepContext& context, std::size_t j, double ratio, StepResult& result) {
  constexpr double kLeast = .78, kMost = 1.28;
  if (ratio >= kLeast && ratio <= kMost) return;
  const Expectation& arm = context.arm;
  const double known = context.known.torque_constant_N_m_A.at(j);
  const std::string figures =
      fmt::format("{:.2f} times the acceleration that the file's motor and inertia give", ratio);
  if (known > 0) {
    ArmFinding found = finding(arm, ArmFault::kWrongInertia, j,
                               figures + "; its torque constant is as the file says", 1 / ratio);
    result.findings.push_back(found);
    return;
  }
  ArmFinding found =
      finding(arm, ratio < 1 ? ArmFault::kWeakMotor : ArmFault::kWrongInertia, j, figures, ratio);
  found.twins = {ArmFault::kWeakMotor, ArmFault::kWrongInertia};
  found.text +=
      " A motor with less torque and a heavier joint look the same where no voltage is measured; a weight at "
      "the "
      "tip (step 8) tells them apart where gravity turns this joint.";
  result.findings.push_back(found);
}

ArmFinding motor_sign(const Expectation& arm, std::size_t j) {
  ArmFinding found = finding(arm, ArmFault::kMotorSign, j, "both pulses moved it the other way");
  found.corrections = {{fmt::format("/axes/{}/drive/sign", j), -arm.axis(j).drive->sign}};
  return found;
}

// Too few counts in a pulse and after it, of all in one direction, to tell an acceleration: the way alone counts.
void judge_coarse_series(const StepContext& context, std::size_t j, const PulseSeries& series,
                         StepResult& result) {
  const Expectation& arm = context.arm;
  // Of the pulses of one direction: how many moved it as their torque pushes, less those that moved it the other way.
  const auto right = [&](const std::vector<PulseSeen>& pulses) {
    int count = 0;
    for (const PulseSeen& seen : pulses)
      if (seen.way != 0) count += seen.way * seen.asked_A * arm.axis(j).per_ampere() > 0 ? 1 : -1;
    return count;
  };
  const int up = right(series.up), down = right(series.down);
  std::size_t still = 0,
              far = 0;  // places: neither pulse moved it by more than a count, one did by kPulseCounts
  for (std::size_t k = 0; k < series.places(); ++k) {
    const double most = std::max(series.up[k].way_counts, series.down[k].way_counts);
    still += most <= 1;
    far += most >= kPulseCounts;
  }
  if (up < 0 && down < 0) {
    result.findings.push_back(motor_sign(arm, j));
  } else if (up <= 0 || down <= 0) {
    result.findings.push_back(finding(arm, ArmFault::kUneven, j, "it moves as it is pushed one way only"));
  } else if (still >= 2 && far >= series.places() / 2) {
    result.findings.push_back(
        finding(arm, ArmFault::kDeadPhase, j,
                fmt::format("it stood still at {} of {} places", still, series.places())));
  } else {
    result.notes.push_back(quoted(arm, j) +
                           ": it turns the right way. Its encoder counts too few in a pulse to tell its "
                           "torque: a weak motor and a phase that "
                           "does little are not seen here.");
  }
}

void judge_series(StepContext& context, std::size_t j, const PulseSeries& series, StepResult& result) {
  const Expectation& arm = context.arm;
  const double up = answer_of(series.up), down = answer_of(series.down);
  const double per_ampere = arm.axis(j).per_ampere();
  const double strength = .5 * (up + down);
  if (up == 0 || down == 0) return judge_coarse_series(context, j, series, result);
  if (strength * per_ampere < 0) {
    result.findings.push_back(motor_sign(arm, j));
    return;
  }
  if (const std::optional<double> part = dead_phase(series)) {
    result.findings.push_back(finding(
        arm, ArmFault::kDeadPhase, j,
        fmt::format(
            "it moved at {} of {} places, at two of these or more with at most {:.0f} % of the torque "
            "that it has elsewhere",
            series.moving(), series.places(), 100 * *part)));
    return;
  }
  if (std::abs(up - down) > .3 * std::abs(strength))
    result.findings.push_back(finding(arm, ArmFault::kUneven, j, fmt::format("{:.2f} to 1", up / down)));
  Measure measure;
  measure.name = "inertia_kg_m2";
  measure.axis = static_cast<int>(j);
  const double constant = context.known.torque_constant_N_m_A.at(j);
  const double scale = constant > 0 ? constant / arm.axis(j).motor->torque_constant_N_m_A.value : 1;
  measure.value = scale * per_ampere / strength;
  measure.spread = std::abs(up - down) / std::abs(strength) * measure.value / 2;
  measure.promise = .1;
  if (arm.knows_inertia()) {
    const auto row = static_cast<Eigen::Index>(j);
    measure.given = arm.mass(arm.balanced(j))(row, row);
    judge_strength(context, j, strength * measure.given / per_ampere, result);
  }
  result.measures.push_back(measure);
}

// Its weight would be taken for what its motor does.
ArmFinding no_rest(const Expectation& arm, std::size_t j) {
  const std::string figures =
      arm.knows_inertia()
          ? fmt::format("where its weight turns it least that is {:.3g} {}, its friction {:.3g} in the file",
                        arm.turning(j, arm.balanced(j)), arm.axis(j).is_prismatic ? "N" : "N m",
                        arm.axis(j).friction.coulomb_N_m.value)
          : "it fell from each place";
  ArmFinding found = finding(arm, ArmFault::kNoRest, j, figures);
  found.text += " Steps 4 to 9 let it go: an arm with such a joint cannot be commissioned.";
  return found;
}

// As measured, or as asked for where the drive does not measure it.
double flowing_A(const BenchTick& tick, std::size_t axis) {
  return std::isnan(tick.current_A.at(axis)) ? tick.asked_A.at(axis) : tick.current_A.at(axis);
}

}  // namespace

StepResult prove_currents(StepContext& context) {
  StepResult result;
  for (std::size_t j = 0; j < context.arm.axes() && !result.stopped; ++j) {
    if (!context.arm.driven(j)) continue;
    const std::size_t before = result.findings.size();
    const Rest rest = rest_of(context, j);
    result.stopped = rest == Rest::kStopped;
    if (rest == Rest::kFalls) result.findings.push_back(no_rest(context.arm, j));
    if (rest != Rest::kStays) continue;
    judge_current(context, j, result);
    if (result.findings.size() == before && !result.stopped) judge_torque_constant(context, j, result);
  }
  result.passed = result.findings.empty() && !result.stopped;
  return result;
}

StepResult prove_motors(StepContext& context) {
  StepResult result;
  for (std::size_t j = 0; j < context.arm.axes(); ++j) {
    if (!context.arm.driven(j)) continue;
    const PulseSeries series = pulse_series(context, j);
    if (series.places() == 0) {
      result.stopped = true;
      return result;
    }
    if (series.moving() == 0) {
      no_motion(context, j, result);
    } else {
      judge_series(context, j, series, result);
    }
  }
  join_ring(context.arm, result.findings);
  result.passed = result.findings.empty();
  return result;
}

StepResult prove_damping(StepContext& context) {
  StepResult result;
  const Expectation& arm = context.arm;
  const BenchFacts facts = context.bench.facts();
  TipProgram program;
  program.kind = TipProgram::Kind::kDamping;
  // 1 N s/m, or a hundredth of m/T where that is less.
  const board::ByJoint J = arm.jacobian(arm.home());
  double mass_kg = .05;
  if (arm.knows_inertia()) {
    const Eigen::Matrix3d mobility = J * arm.mass(arm.home()).inverse() * J.transpose();
    mass_kg = 1 / mobility.diagonal().maxCoeff();
  }
  program.damping_N_s_m = std::min(1.0, .01 * mass_kg / facts.tick_s);
  program.most_force_N = .5 * kTipForce_N;
  program.most_speed_m_s = .9 * kTipSpeed_m_s;
  // The place of a closed loop at which an axis is balanced may be near to where its links part.
  const Answer answer =
      arm.has_loop() ? hold(context, arm.home()) : place(context, 0, resting_place(context, 0));
  if (answer == Answer::kStop) return {.stopped = true};
  const BenchRecording seen = context.bench.feel(
      program, prompt(Prompt::Kind::kMoveAbout, 0,
                      "Hold the tip and move it slowly about, by 2 cm; it feels like oil."));
  // The torques times the way, over each 100 ms.
  const auto window = static_cast<std::size_t>(std::lround(.1 / facts.tick_s));
  double worst_J = 0, all_J = 0;
  for (std::size_t from = 1; from + window <= seen.ticks.size(); from += window) {
    double work_J = 0;
    for (std::size_t k = from; k < from + window; ++k)
      for (std::size_t j = 0; j < arm.axes(); ++j)
        if (arm.driven(j))
          work_J += flowing_A(seen.ticks[k], j) * arm.axis(j).per_ampere() * arm.axis(j).per_count() *
                    static_cast<double>(seen.ticks[k].counts.at(j) - seen.ticks[k - 1].counts.at(j));
    worst_J = std::max(worst_J, work_J);
    all_J += work_J;
  }
  if (seen.ending == Ending::kSpeed || worst_J > 5e-5 || all_J >= 0) {
    result.findings.push_back(
        finding(ArmFault::kFeedsEnergy, "The arm",
                fmt::format("{:.2g} mJ in 100 ms{}", 1e3 * worst_J,
                            seen.ending == Ending::kSpeed ? ", and the tip became too fast" : "")));
  }
  result.passed = result.findings.empty();
  return result;
}

}  // namespace thimble::host
