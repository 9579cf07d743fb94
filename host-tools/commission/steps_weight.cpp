// Steps 7 and 8: the directions of the tip, and the weight.
#include <fmt/format.h>

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host-tools/commission/estimate.h"
#include "host-tools/commission/sweeps.h"

namespace thimble::host {
namespace {

constexpr double kPushAngle_deg = 15;
constexpr double kMass_kg = .1;
constexpr double kScale = .1;    // of the torques
constexpr double kWeight = .05;  // of the largest weight
constexpr double kSpeed = .25;   // rad/s of the sweeps
constexpr double kWay = .04;     // rad, to each side

// Directions in which the tip can be pushed, nearest to the world's axes.
std::vector<Eigen::Vector3d> push_directions(const Expectation& arm) {
  const board::ByJoint J = arm.jacobian(arm.home());
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(J), Eigen::ComputeThinU);
  std::vector<Eigen::Vector3d> directions;
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d along = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < svd.singularValues().size(); ++i)
      if (svd.singularValues()[i] > .1 * svd.singularValues()[0])
        along += svd.matrixU().col(i) * svd.matrixU()(axis, i);
    if (along.norm() > .7) directions.push_back(along.normalized());
  }
  return directions;
}

// Five places around home, within the limits.
std::vector<board::JointVector> weighing_places(const Expectation& arm) {
  constexpr std::array<std::array<double, 3>, 5> kParts{
      {{0, 0, 0}, {0, .12, 0}, {0, -.12, 0}, {0, 0, .12}, {0, 0, -.12}}};
  std::vector<board::JointVector> places;
  for (const auto& part : kParts) {
    board::JointVector at = arm.home();
    for (std::size_t j = 0; j < std::min<std::size_t>(arm.axes(), 3); ++j) {
      const std::size_t which = arm.axes() == 1 ? 1 : j;
      const Expectation::Span span = arm.span(j, arm.home());
      at[static_cast<Eigen::Index>(j)] += part.at(which) * (span.upper - span.lower);
    }
    places.push_back(at);
  }
  return places;
}

struct Weighing {
  std::vector<board::JointVector> places;
  std::vector<PerAxis<double>> torque;  // of each place, without friction
  std::vector<PerAxis<double>> friction;
};

Weighing weigh(StepContext& context, const std::vector<board::JointVector>& places) {
  Weighing weighing;
  weighing.places = places;
  for (const board::JointVector& at : places) {
    const PerAxis<Sweep> seen = sweep_all(context, at, kWay, kSpeed);
    PerAxis<double> torque{}, friction{};
    for (std::size_t j = 0; j < context.arm.axes(); ++j) {
      torque.at(j) = .5 * (seen.at(j).up_N_m + seen.at(j).down_N_m);
      friction.at(j) = .5 * (seen.at(j).up_N_m - seen.at(j).down_N_m);
    }
    weighing.torque.push_back(torque);
    weighing.friction.push_back(friction);
  }
  return weighing;
}

// Of the file, or as it was seen where the file has none. A weak motor seems to have more than there is.
double friction_of(const Expectation& arm, std::size_t j, const Weighing& bare) {
  double most = arm.axis(j).friction.coulomb_N_m.value;
  if (most > 0) return most;
  for (const PerAxis<double>& seen : bare.friction) most = std::max(most, seen.at(j));
  return most;
}

// The torque constant by a weight at the tip: what it adds to the torques.
void judge_scale(StepContext& context, std::size_t j, const Weighing& bare, const Weighing& laden,
                 StepResult& result) {
  const Expectation& arm = context.arm;
  std::vector<double> added, expected;
  double largest = 0;
  for (std::size_t i = 0; i < bare.places.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(j);
    const double weight_N = kMass_kg * static_cast<double>(kinematics::kGravity_m_s2);
    added.push_back(laden.torque[i].at(j) - bare.torque[i].at(j));
    expected.push_back(weight_N * arm.jacobian(bare.places[i]).col(row).z());
    largest = std::max(largest, std::abs(expected.back()));
  }
  if (largest <= 2 * friction_of(arm, j, bare)) {
    result.notes.push_back(quoted(arm, j) +
                           ": gravity hardly turns it, so a weight does not tell its torque scale.");
    return;
  }
  // About the place where it turns nothing, an error of the stops shifts it: the slope counts.
  if (*std::ranges::min_element(expected) * *std::ranges::max_element(expected) < 0) {
    const double middle = mean(expected), shift = mean(added);
    for (double& value : expected) value -= middle;
    for (double& value : added) value -= shift;
  }
  const ScaleFit fit = fit_scale(added, expected);
  const double given = arm.axis(j).motor->torque_constant_N_m_A.value, seen = given / fit.scale;
  context.known.has_torque_scale.at(j) = true;
  if (context.known.torque_constant_N_m_A.at(j) == 0) context.known.torque_constant_N_m_A.at(j) = seen;
  result.measures.push_back(
      {"torque_scale", static_cast<int>(j), 1, 1 / fit.scale, fit.residual, fit.residual, .05});
  if (std::abs(1 / fit.scale - 1) <= kScale) return;
  ArmFinding found =
      finding(arm, ArmFault::kWeakMotor, j,
              fmt::format("a weight of {:.0f} g took {:.2f} times the torque", 1e3 * kMass_kg, fit.scale),
              1 / fit.scale);
  found.corrections = {{fmt::format("/axes/{}/motor/torque_constant_N_m_A", j), seen}};
  result.findings.push_back(found);
}

void judge_weight(StepContext& context, const Weighing& bare, StepResult& result) {
  const Expectation& arm = context.arm;
  double largest = 0;
  for (const board::JointVector& at : bare.places)
    largest = std::max(largest, arm.weight(at).cwiseAbs().maxCoeff());
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    if (!arm.driven(j)) continue;
    std::vector<double> measured, expected;
    for (std::size_t i = 0; i < bare.places.size(); ++i) {
      const double known = context.known.torque_constant_N_m_A.at(j);
      const double scale = known > 0 ? known / arm.axis(j).motor->torque_constant_N_m_A.value : 1;
      measured.push_back(scale * bare.torque[i].at(j));
      expected.push_back(arm.weight(bare.places[i])[static_cast<Eigen::Index>(j)]);
    }
    const double most = *std::ranges::max_element(expected, {}, [](double v) { return std::abs(v); });
    if (std::abs(most) <= 2 * friction_of(arm, j, bare)) continue;
    const ScaleFit fit = fit_scale(measured, expected);
    result.measures.push_back(
        {"weight_scale", static_cast<int>(j), 1, fit.scale, fit.residual, fit.residual, .05});
    if (std::abs(fit.scale - 1) > 2 * kWeight || fit.residual * std::abs(most) > kWeight * largest) {
      ArmFinding found = finding(
          arm, ArmFault::kWrongWeight, j,
          fmt::format("{:.2f} times, {:.0f} % unexplained", fit.scale, 100 * fit.residual), fit.scale);
      result.findings.push_back(found);
    }
  }
}

}  // namespace

StepResult prove_directions(StepContext& context) {
  StepResult result;
  const Expectation& arm = context.arm;
  TipProgram program;
  program.kind = TipProgram::Kind::kSpring;
  program.stiffness_N_m = 50;
  program.most_force_N = .95 * kTipForce_N;
  for (const Eigen::Vector3d& direction : push_directions(arm)) {
    if (hold(context, arm.home()) == Answer::kStop) return {.stopped = true};
    Prompt asked = prompt(
        Prompt::Kind::kPush, 0,
        "Push the tip slowly " + towards(direction) + ", by 2 cm, and back. It feels like a soft spring.");
    asked.direction = direction;
    const BenchRecording seen = context.bench.feel(program, asked);
    Eigen::Vector3d farthest = Eigen::Vector3d::Zero();
    if (seen.ticks.empty()) continue;
    const Eigen::Vector3d begin_m = arm.tip_m(angles(context, seen.ticks.front().counts));
    for (std::size_t k = 0; k < seen.ticks.size(); k += 20) {
      const Eigen::Vector3d moved = arm.tip_m(angles(context, seen.ticks[k].counts)) - begin_m;
      if (moved.norm() > farthest.norm()) farthest = moved;
    }
    const double angle_deg =
        farthest.norm() < .004 ? 180
                               : std::acos(std::clamp(farthest.dot(direction) / farthest.norm(), -1.0, 1.0)) *
                                     180 / std::numbers::pi;
    result.notes.push_back(fmt::format("pushed {}: off by {:.0f} degrees", towards(direction), angle_deg));
    if (angle_deg <= kPushAngle_deg) continue;
    ArmFinding found;
    found.fault = ArmFault::kWrongDirection;
    found.text = fmt::format("Pushed {}: {} ({:.0f} degrees off, {:.0f} mm). {}.", towards(direction),
                             text_of(found.fault).what, angle_deg, 1e3 * farthest.norm(),
                             sentence(text_of(found.fault).remedy));
    result.findings.push_back(found);
  }
  result.passed = result.findings.empty();
  return result;
}

StepResult prove_weight(StepContext& context) {
  StepResult result;
  const std::vector<board::JointVector> places = weighing_places(context.arm);
  Prompt hang =
      prompt(Prompt::Kind::kHang, 0, "Nothing hangs at the tip; take your hands off. The arm moves slowly.");
  if (context.bench.ask(hang) == Answer::kStop) return {.stopped = true};
  const Weighing bare = weigh(context, places);
  hang.mass_kg = kMass_kg;
  hang.text = fmt::format("Hang a weight of {:.0f} g at the tip, then take your hands off.", 1e3 * kMass_kg);
  const Answer answer = context.bench.ask(hang);
  if (answer == Answer::kStop) return {.stopped = true};
  if (answer == Answer::kDone) {
    const Weighing laden = weigh(context, places);
    for (std::size_t j = 0; j < context.arm.axes(); ++j)
      if (context.arm.driven(j)) judge_scale(context, j, bare, laden, result);
    hang.mass_kg = 0;
    hang.text = "Take the weight off.";
    if (context.bench.ask(hang) == Answer::kStop) return {.stopped = true};
  } else {
    result.notes.emplace_back("Without a weight the scale of the torques is not known.");
  }
  if (context.arm.knows_inertia()) judge_weight(context, bare, result);
  result.passed = result.findings.empty();
  return result;
}

}  // namespace thimble::host
