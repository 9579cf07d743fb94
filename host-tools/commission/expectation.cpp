#include "host-tools/commission/expectation.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "board/sim/mechanics/two_link_inertia.h"
#include "host-tools/arms/arm_data.h"

namespace thimble::host {
namespace {

constexpr double kShortLever_m = .01;                // an axis that moves the tip less pushes nothing with it
constexpr double kMargin = .08, kLeastMargin = .03;  // of a way between stops, at each end
constexpr int kGrid = 9;

board::ArmInertia inertia_of(const board::AnyPlantParameters& p) {
  board::ArmInertia inertia{p.body_kg_m2, JointVector::Zero(static_cast<Eigen::Index>(p.axis.size()))};
  for (std::size_t j = 0; j < p.axis.size(); ++j)
    inertia.rotor_kg_m2[static_cast<Eigen::Index>(j)] = p.axis[j].rotor_kg_m2;
  return inertia;
}

}  // namespace

Expectation::Expectation(const ArmFile& arm)
    : arm_(&arm),
      data_(arm_data(arm)),
      numbers_(board::AnyPlantParameters::from(data_, arm.body_inertia_kg_m2)),
      dynamics_(data_.geometry, inertia_of(numbers_)),
      knows_inertia_(data_.has_inertia || data_.geometry.body_count > 0) {}

JointVector Expectation::home() const {
  return data_.geometry.home.head(static_cast<Eigen::Index>(axes())).cast<double>();
}

board::ArmTerms Expectation::terms(const JointVector& at) const {
  board::ArmFrames frames = dynamics_.frames_near(at);
  board::ArmTerms terms;
  const JointVector still = JointVector::Zero(at.size());
  if (!dynamics_.at(at, still, frames, terms)) {
    terms = {};
    terms.mass = JointMatrix::Zero(at.size(), at.size());
    terms.bias = still;
    terms.tip = terms.force_point = board::MovingPoint::fixed(Eigen::Vector3d::Zero(), at.size());
    return terms;
  }
  if (data_.has_inertia) board::add_two_link_inertia(data_.inertia, at, still, terms);
  return terms;
}

JointMatrix Expectation::mass(const JointVector& at) const { return terms(at).mass; }
JointVector Expectation::weight(const JointVector& at) const { return terms(at).bias; }

double Expectation::inertia(std::size_t j, const JointVector& at) const {
  const auto row = static_cast<Eigen::Index>(j);
  return mass(at)(row, row) + numbers_.tip_mass_kg * jacobian(at).col(row).squaredNorm();
}

board::ByJoint Expectation::jacobian(const JointVector& at) const {
  return data_.geometry.rotation.cast<double>() * terms(at).force_point.by_joint;
}

Eigen::Vector3d Expectation::tip_m(const JointVector& at) const {
  return data_.geometry.rotation.cast<double>() * (terms(at).tip.at_m - terms(home()).tip.at_m);
}

Expectation::Span Expectation::span(std::size_t j, const JointVector& others) const {
  Span span{axis(j).lower.value, axis(j).upper.value};
  for (const ArmLimitSum& sum : arm_->limit_sums) {
    const double own = sum.weights[j];
    if (own == 0) continue;
    double rest = 0;
    for (std::size_t k = 0; k < axes(); ++k)
      if (k != j) rest += sum.weights[k] * others[static_cast<Eigen::Index>(k)];
    const double a = (sum.lower_rad.value - rest) / own, b = (sum.upper_rad.value - rest) / own;
    span.lower = std::max(span.lower, std::min(a, b));
    span.upper = std::min(span.upper, std::max(a, b));
  }
  return span;
}

double Expectation::spread(const JointVector& at) const {
  board::ArmFrames frames = dynamics_.frames_near(at);
  return dynamics_.spread(at, frames);
}

bool Expectation::stays_closed(std::size_t j, const JointVector& others) const {
  constexpr int kPlaces = 40;
  const Span way = span(j, others);
  for (int k = 0; k <= kPlaces; ++k) {
    JointVector at = others;
    at[static_cast<Eigen::Index>(j)] = way.lower + (way.upper - way.lower) * k / kPlaces;
    if (spread(at) < kLeastSpread) return false;
  }
  return true;
}

double Expectation::counts(std::size_t j, double way) const { return way / axis(j).per_count(); }

Eigen::Vector3d Expectation::direction(std::size_t j) const {
  const board::ByJoint J = jacobian(home());
  const Eigen::Vector3d way = J.col(static_cast<Eigen::Index>(j));
  const double lever_m = way.norm();
  if (lever_m > kShortLever_m) return way / lever_m;
  return Eigen::Vector3d::Zero();
}

double Expectation::turning(std::size_t j, const JointVector& at) const {
  constexpr double kGuess_N = .05 * 9.81;
  const auto row = static_cast<Eigen::Index>(j);
  if (knows_inertia_) return std::abs(weight(at)[row]);
  return kGuess_N * std::abs(jacobian(at)(2, row));
}

bool Expectation::gravity_turns(std::size_t j) const {
  constexpr double kBeside_rad = .3;
  JointVector at = home();
  double most = turning(j, at);
  for (Eigen::Index k = 0; k < at.size(); ++k) {
    JointVector beside = at;
    beside[k] += kBeside_rad;
    most = std::max(most, turning(j, beside));
  }
  return most > .1 * std::max(axis(j).friction.coulomb_N_m.value, 1e-4);
}

bool Expectation::within_limits(const JointVector& at, double part) const {
  for (std::size_t j = 0; j < axes(); ++j) {
    const Span own = span(j, at);
    const double margin = part * (own.upper - own.lower), here = at[static_cast<Eigen::Index>(j)];
    if (!(here >= own.lower + margin && here <= own.upper - margin)) return false;
  }
  return spread(at) >= kLeastSpread;
}

// Moves `count` axes from `first` on to where the weight turns axis j less.
void Expectation::nearer(std::size_t j, JointVector& best, Eigen::Index first, Eigen::Index count,
                         double margin) const {
  double part = 1.0 / (kGrid - 1);
  for (int round = 0; round < 20; ++round, part *= .6) {
    for (Eigen::Index k = first; k < first + count; ++k) {
      const ArmAxis& moved = axis(static_cast<std::size_t>(k));
      for (const double sign : {-1.0, 1.0}) {
        JointVector at = best;
        at[k] += sign * part * (moved.upper.value - moved.lower.value);
        if (within_limits(at, margin) &&
            turning_about(j, at, first, count) < turning_about(j, best, first, count))
          best = at;
      }
    }
  }
}

// The most that the weight turns axis j where a hand may have brought the arm that was told to bring it there.
double Expectation::turning_about(std::size_t j, const JointVector& at, Eigen::Index first,
                                  Eigen::Index count) const {
  constexpr double kHand_rad = .01;
  double most = turning(j, at);
  for (Eigen::Index k = first; count > 1 && k < first + count; ++k) {
    for (const double by : {-kHand_rad, kHand_rad}) {
      JointVector beside = at;
      beside[k] += by;
      most = std::max(most, turning(j, beside));
    }
  }
  return most;
}

const JointVector& Expectation::balanced(std::size_t j) const {
  std::optional<JointVector>& known = balanced_.at(j);
  if (!known) known = find_balanced(j);
  return *known;
}

JointVector Expectation::find_balanced(std::size_t j) const {
  JointVector best = balanced_within(j, kMargin);
  if (turning(j, best) <= .5 * std::max(axis(j).friction.coulomb_N_m.value, 1e-4)) return best;
  const JointVector nearer_stop = balanced_within(j, kLeastMargin);
  return turning(j, nearer_stop) < turning(j, best) ? nearer_stop : best;
}

JointVector Expectation::balanced_within(std::size_t j, double margin) const {
  const JointVector start = home();
  const auto n = static_cast<Eigen::Index>(axes());
  const double friction = std::max(axis(j).friction.coulomb_N_m.value, 1e-4);
  // Home is best where it will do; then a grid over up to three axes that turn the weight.
  JointVector best = start;
  double least = turning(j, start) / friction;
  if (least < .25) return best;
  const Eigen::Index tried = std::min<Eigen::Index>(n, 3);
  long places = 1;
  for (Eigen::Index k = 0; k < tried; ++k) places *= kGrid;
  for (long place = 0; place < places; ++place) {
    JointVector at = start;
    long rest = place;
    double far = 0;
    for (Eigen::Index k = 0; k < tried; ++k) {
      const ArmAxis& own = axis(static_cast<std::size_t>(k));
      const double part = static_cast<double>(rest % kGrid) / (kGrid - 1);
      at[k] = own.lower.value + part * (own.upper.value - own.lower.value);
      if (k != static_cast<Eigen::Index>(j) && rest % kGrid == kGrid / 2) at[k] = start[k];
      far += std::abs(at[k] - start[k]);
      rest /= kGrid;
    }
    if (!within_limits(at, margin)) continue;
    const double score = turning(j, at) / friction + .1 * far;
    if (score < least) {
      least = score;
      best = at;
    }
  }
  // The axis alone, where that will do; else the others, too.
  nearer(j, best, static_cast<Eigen::Index>(j), 1, margin);
  if (turning(j, best) > .25 * friction) nearer(j, best, 0, tried, margin);
  return best;
}

namespace {

// By the motor alone.
double motor_current_A(const ArmAxis& axis) {
  const double peak_A = axis.motor->peak_current_A.value;
  const double friction_A = kOverFriction * axis.friction.coulomb_N_m.value / std::abs(axis.per_ampere());
  return .9 * std::max(kTorqueShare * peak_A, std::min(kFrictionShare * peak_A, friction_A));
}

}  // namespace

double gentle_current_A(const Expectation& arm, std::size_t j) {
  constexpr double kMostPart = .9;  // of the force, where an axis is tried at a place with a shorter lever
  double most_A = motor_current_A(arm.axis(j));
  for (std::size_t place = 0; place < arm.axes(); ++place) {
    if (!arm.driven(place)) continue;
    const board::ByJoint J = arm.jacobian(arm.balanced(place));
    for (std::size_t k = 0; k < arm.axes(); ++k) {
      const double lever_m = J.col(static_cast<Eigen::Index>(k)).norm();
      if (arm.driven(k) && lever_m >= kShortLever_m)
        most_A = std::min(most_A, kMostPart * kTipForce_N * lever_m / std::abs(arm.axis(k).per_ampere()));
    }
  }
  // Behind the drive may be any other motor of the arm, as long as step 5 has not shown whose it is.
  const board::ByJoint J = arm.jacobian(arm.home());
  for (std::size_t k = 0; k < arm.axes(); ++k) {
    if (!arm.driven(k)) continue;
    const double lever_m = J.col(static_cast<Eigen::Index>(k)).norm();
    most_A = std::min(most_A, motor_current_A(arm.axis(k)));
    if (lever_m < kShortLever_m) continue;
    most_A = std::min(most_A, .5 * kTipForce_N * lever_m / std::abs(arm.axis(k).per_ampere()));
  }
  return most_A;
}

EndsAt gentle_ends(const Expectation& arm) {
  constexpr double kWay_rad = 2 * std::numbers::pi / 180, kSpeed_rad_s = 1;
  EndsAt ends;
  const board::ByJoint J = arm.jacobian(arm.home());
  for (std::size_t j = 0; j < arm.axes(); ++j) {
    const double lever_m = J.col(static_cast<Eigen::Index>(j)).norm();
    const double speed = lever_m > kShortLever_m ? std::min(kSpeed_rad_s, .6 * kTipSpeed_m_s / lever_m)
                                                 : kSpeed_rad_s * per_radian(arm.axis(j));
    ends.counts.at(j) = std::abs(arm.counts(j, kWay_rad * per_radian(arm.axis(j))));
    ends.counts_s.at(j) = std::abs(arm.counts(j, speed));
  }
  ends.energy_J = kPulseEnergy_J;
  return ends;
}

void demand_gentle(const Expectation& arm, const AxisProgram& program) {
  const double most_A = gentle_current_A(arm, program.axis);
  const double asked_A =
      std::abs(program.constant_A) + std::abs(program.slope_A_s * program.seconds) + std::abs(program.tone_A);
  if (!(asked_A <= 1.0001 * most_A)) throw std::logic_error("a current that is not allowed before step 7");
  const EndsAt gentle = gentle_ends(arm);
  for (std::size_t j = 0; j < arm.axes(); ++j)
    if (!(program.ends.counts.at(j) > 0 && program.ends.counts.at(j) <= gentle.counts.at(j) &&
          program.ends.counts_s.at(j) > 0 && program.ends.counts_s.at(j) <= gentle.counts_s.at(j)))
      throw std::logic_error("a motion before step 7 that does not end by itself");
  if (!(program.ends.energy_J > 0 && program.ends.energy_J <= kPulseEnergy_J))
    throw std::logic_error("a motion before step 7 without a bound of energy");
}

}  // namespace thimble::host
