// Step 9: friction, stiction, inertia, stiffness, resonances and delay of each axis.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-tools/commission/balance.h"
#include "host-tools/commission/estimate.h"
#include "host-tools/commission/sweeps.h"

namespace thimble::host {
namespace {

constexpr int kRuns = 3;
constexpr double kCoulombPromise = .2;
constexpr std::array kSpeeds{.15, .3, .5, .75, 1.0};  // of the largest
constexpr double kLargestSpeed = 2;                   // rad/s
constexpr double kLongestWay = .4, kShortest_s = .4;  // rad to each side, and what a sweep takes
constexpr double kLowest_Hz = 12, kHighest_Hz = 350;
constexpr int kFrequencies = 26;
constexpr double kTone_s = .25;
// Amplitude by friction, and of the peak: from crest to crest less than encoder_frozen.
constexpr double kToneFriction = 12, kTonePeak = .12;
constexpr std::size_t kToneRuns = 2;  // that the model explains
constexpr int kMostToneRuns = 5;
constexpr int kRamps = 6;
constexpr double kRamp_s = 2;    // so slow that it is found where it begins to move
constexpr int kTonesAPlace = 4;  // before the arm is put back

void add(StepResult& result, const char* name, std::size_t axis, double given, std::span<const double> values,
         double residual, double promise) {
  Measure measure;
  measure.name = name;
  measure.axis = static_cast<int>(axis);
  measure.given = given;
  measure.value = mean(values);
  measure.spread = values.size() < 2 ? std::nan("") : spread(values);  // one run does not tell
  measure.residual = residual;
  measure.promise = promise;
  result.measures.push_back(measure);
}

// By how much currents of the file's torque constant are too small or too large.
double torque_scale(const StepContext& context, std::size_t axis) {
  const double known = context.known.torque_constant_N_m_A.at(axis);
  return known > 0 ? known / context.arm.axis(axis).motor->torque_constant_N_m_A.value : 1;
}

// In the middle between the stops: the weight cancels.
std::vector<FrictionFit> find_friction(StepContext& context, std::size_t axis) {
  const double scale = torque_scale(context, axis), unit = per_radian(context.arm.axis(axis));
  board::JointVector at = context.arm.home();
  const Expectation::Span span = context.arm.span(axis, at);
  at[static_cast<Eigen::Index>(axis)] = .5 * (span.lower + span.upper);
  const double way = std::min(kLongestWay * unit, .3 * (span.upper - span.lower));
  const double largest = std::min(kLargestSpeed * unit, 2 * way / kShortest_s);
  std::vector<FrictionFit> fits;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<Sweep> sweeps;
    for (const double part : kSpeeds) {
      const double speed = part * largest;
      Sweep sweep = sweep_one(context, axis, at, std::min(way, .75 * speed), speed);
      sweep.up_N_m *= scale;
      sweep.down_N_m *= scale;
      sweeps.push_back(sweep);
    }
    const FrictionFit fit = fit_friction(sweeps);
    if (fit.accepted) fits.push_back(fit);
  }
  return fits;
}

// The torque at which it begins to move, by ramps of current up and down.
std::vector<double> find_stiction(StepContext& context, std::size_t axis, const board::JointVector& at,
                                  double coulomb_N_m) {
  const Expectation& arm = context.arm;
  const double scale = torque_scale(context, axis);
  std::vector<double> torques;
  for (int run = 0; run < kRamps; ++run) {
    if (place(context, axis, at) == Answer::kStop) return torques;
    AxisProgram program;
    program.axis = axis;
    const double most_A = std::min(2 * coulomb_N_m / scale / std::abs(arm.axis(axis).per_ampere()),
                                   .3 * arm.axis(axis).motor->peak_current_A.value);
    program.seconds = kRamp_s;
    program.slope_A_s = (run % 2 == 0 ? most_A : -most_A) / kRamp_s;
    // The transmission stretches before the motor moves on: two counts more than that.
    program.ends.counts.at(axis) = 8;
    const BenchRecording seen = context.bench.run(program);
    if (seen.ending != Ending::kCounts || seen.driven_ticks < 2) continue;
    // Back to the tick in which the last rest ended.
    const std::int64_t start = seen.ticks.front().counts.at(axis);
    std::size_t k = seen.driven_ticks - 1;
    while (k > 0 && std::abs(seen.ticks[k].counts.at(axis) - start) > 1) --k;
    torques.push_back(std::abs(seen.ticks[k].asked_A.at(axis) * arm.axis(axis).per_ampere()) * scale);
  }
  return torques;
}

std::vector<Response> find_responses(StepContext& context, std::size_t axis, const board::JointVector& at,
                                     double coulomb_N_m) {
  const Expectation& arm = context.arm;
  const double tick_s = context.bench.facts().tick_s, scale = torque_scale(context, axis);
  const double peak = arm.axis(axis).peak_torque(), per_ampere = arm.axis(axis).per_ampere();
  const double amplitude = std::min(kTonePeak * peak, std::max(.05 * peak, kToneFriction * coulomb_N_m));
  std::vector<Response> responses;
  const double highest = std::min(kHighest_Hz, .2 / tick_s);
  for (int i = 0; i < kFrequencies; ++i) {
    const double Hz =
        kLowest_Hz * std::pow(highest / kLowest_Hz, static_cast<double>(i) / (kFrequencies - 1));
    if (i % kTonesAPlace == 0 && place(context, axis, at) == Answer::kStop) return responses;
    AxisProgram program;
    program.axis = axis;
    program.seconds = std::max(kTone_s, 4 / Hz);
    program.tone_A = amplitude / per_ampere;
    program.tone_Hz = Hz;
    std::vector<double> torque, angle;
    for (std::size_t k = 0; k < program.ticks(tick_s); ++k)
      torque.push_back(scale * per_ampere * program.current_A(tick_s * static_cast<double>(k)));
    const BenchRecording seen = context.bench.run(program);
    for (const BenchTick& tick : seen.ticks)
      angle.push_back(static_cast<double>(tick.counts.at(axis) - seen.ticks.front().counts.at(axis)) *
                      arm.axis(axis).per_count());
    if (angle.size() != torque.size()) continue;
    const Response response = response_at(Hz, tick_s, torque, angle);
    // Less than a count is noise.
    if (response.amplitude > 1.5 * std::abs(arm.axis(axis).per_count())) responses.push_back(response);
  }
  return responses;
}

void identify_axis(StepContext& context, std::size_t axis, StepResult& result) {
  const Expectation& arm = context.arm;
  const ArmAxis& own = arm.axis(axis);
  const board::JointVector at = resting_place(context, axis);
  if (place(context, axis, at) == Answer::kStop ||
      context.bench.ask(prompt(Prompt::Kind::kLetGo, axis,
                               "Take your hands off: the board holds the arm.")) == Answer::kStop) {
    result.stopped = true;
    return;
  }
  std::vector<double> coulomb, viscous;
  double residual = 0;
  for (const FrictionFit& fit : find_friction(context, axis)) {
    coulomb.push_back(fit.coulomb_N_m);
    viscous.push_back(fit.viscous_N_m_s_rad);
    residual = std::max(residual, fit.residual);
  }
  // Coarse counts make the servo tremble, and what trembles has no friction: then its runs differ.
  if (coulomb.size() < 2 || spread(coulomb) > kCoulombPromise * mean(coulomb)) {
    result.notes.push_back(quoted(arm, axis) + ": its friction was not found; the sweeps do not agree.");
    return;
  }
  add(result, "coulomb_N_m", axis, own.friction.coulomb_N_m.value, coulomb, residual, kCoulombPromise);
  add(result, "viscous_N_m_s_rad", axis, own.friction.viscous_N_m_s_rad.value, viscous, residual, .3);
  const FrictionFit friction{mean(coulomb), mean(viscous), residual, true};
  const std::vector<double> stiction = find_stiction(context, axis, at, friction.coulomb_N_m);
  if (!stiction.empty()) {
    std::vector<double> ratios;
    ratios.reserve(stiction.size());
    for (const double torque : stiction) ratios.push_back(std::max(1.0, torque / friction.coulomb_N_m));
    add(result, "stiction_ratio", axis, std::max(1.0, own.friction.stiction_ratio.value), ratios, 0, .2);
  }
  const auto row = static_cast<Eigen::Index>(axis);
  const double inertia = std::max(arm.mass(at)(row, row), 1e-9);
  std::vector<double> totals, rotors, stiffness, locked, damping, delay;
  for (int run = 0; run < kMostToneRuns && locked.size() < kToneRuns; ++run) {
    const TwoMass mass = fit_two_mass(find_responses(context, axis, at, friction.coulomb_N_m), inertia,
                                      friction, context.bench.facts().tick_s);
    if (!mass.accepted) continue;
    totals.push_back(mass.rotor_kg_m2 + mass.link_kg_m2);
    rotors.push_back(mass.rotor_kg_m2);
    stiffness.push_back(mass.stiffness_N_m_rad);
    locked.push_back(mass.locked_Hz);
    damping.push_back(mass.damping_ratio);
    delay.push_back(mass.delay_s);
    residual = mass.residual;
  }
  if (locked.empty()) {
    result.notes.push_back(quoted(arm, axis) +
                           ": no resonance was found below the highest frequency that the counts show.");
    return;
  }
  add(result, "inertia_kg_m2", axis, inertia, totals, residual, .1);
  add(result, "rotor_kg_m2", axis,
      own.motor->rotor_inertia_kg_m2.value *
          std::pow(own.per_ampere() / own.motor->torque_constant_N_m_A.value, 2),
      rotors, residual, .2);
  add(result, "stiffness_N_m_rad", axis, own.stiffness_N_m_rad ? own.stiffness_N_m_rad->value : std::nan(""),
      stiffness, residual, .1);
  add(result, "first_resonance_Hz", axis,
      own.first_resonance_Hz ? own.first_resonance_Hz->value : std::nan(""), locked, residual, .03);
  add(result, "damping_ratio", axis, std::nan(""), damping, residual, .3);
  add(result, "delay_s", axis, own.drive->delay_s.value, delay, residual, .1);
}

}  // namespace

StepResult identify(StepContext& context) {
  StepResult result;
  for (std::size_t j = 0; j < context.arm.axes() && !result.stopped; ++j)
    if (context.arm.driven(j)) identify_axis(context, j, result);
  result.passed = result.findings.empty() && !result.stopped;
  return result;
}

}  // namespace thimble::host
