#include <algorithm>
#include <cmath>
#include <numbers>

#include "board/sim/any_plant.h"
#include "board/sim/mechanics/two_link_inertia.h"

namespace thimble::board {
namespace {

constexpr double kDampingRatio = .05;        // with locked motors, as Plant has it
constexpr double kGuessedTipMass_kg = .05;   // of an arm of which no weight is known
constexpr double kGuessedLinkOfRotor = .25;  // and its links, of the rotor's inertia
constexpr double kLightLink_kg_m2 = 2e-5;    // of an axis without a motor
constexpr double kShortestLever = .25;       // of the longest one: where home does not load an axis

double as_double(float value) { return static_cast<double>(value); }

bool is_prismatic_axis(const kinematics::Geometry& geometry, int axis) {
  const int k = axis - kinematics::platform_joints(geometry);
  return k >= 0 &&
         geometry.chain.joint.at(static_cast<std::size_t>(k)).kind == kinematics::JointKind::kPrismatic;
}

AxisTruth truth_of(const kinematics::AxisData& data, bool driven, bool prismatic) {
  const double turn = 2 * std::numbers::pi;
  const double motor_rad = prismatic ? turn : 1.0;  // of the shaft, for a turn of the motor per m or per turn
  AxisTruth axis;
  axis.driven = driven;
  axis.lower = as_double(data.lower);
  axis.upper = as_double(data.upper);
  if (prismatic) {
    axis.stop_stiffness_N_m_rad = 20000;
    axis.stop_damping_N_m_s_rad = 40;
  } else if (!driven) {
    axis.stop_stiffness_N_m_rad = 2;
    axis.stop_damping_N_m_s_rad = .004;
  }
  axis.coulomb_N_m = as_double(data.coulomb_N_m);
  axis.viscous_N_m_s_rad = as_double(data.viscous_N_m_s_rad);
  axis.stiction_ratio = std::max(1.0, as_double(data.stiction_ratio));
  axis.rad_per_count = as_double(data.encoder_sign) * (prismatic ? 1.0 : turn) /
                       (as_double(data.counts_per_turn) * as_double(data.encoder_turns));
  axis.counter_bits = data.counter_bits;
  if (!driven) return axis;
  axis.turns = as_double(data.drive_sign) * as_double(data.drive_turns) * motor_rad;
  axis.motor = data.motor;
  axis.rotor_kg_m2 = as_double(data.motor.rotor_inertia_kg_m2) * axis.turns * axis.turns;
  axis.stiffness_N_m_rad = as_double(data.stiffness_N_m_rad);
  return axis;
}

}  // namespace

std::array<Eigen::Vector3d, kinematics::kMaxBodies> AnyPlantParameters::no_body_inertia() {
  std::array<Eigen::Vector3d, kinematics::kMaxBodies> none;
  none.fill(Eigen::Vector3d::Zero());
  return none;
}

AnyPlantParameters AnyPlantParameters::from(
    const kinematics::ArmData& arm, const std::array<Eigen::Vector3d, kinematics::kMaxBodies>& body_kg_m2) {
  AnyPlantParameters p;
  p.geometry = arm.geometry;
  p.body_kg_m2 = body_kg_m2;
  p.has_two_link_inertia = arm.has_inertia;
  p.two_link_inertia = arm.inertia;
  p.supply_V = as_double(arm.supply_V);
  p.sum.assign(arm.sum.begin(), arm.sum.begin() + arm.sum_count);
  const int n = kinematics::axes_of(arm.geometry);
  const bool weightless = arm.geometry.body_count == 0 && !arm.has_inertia;
  if (weightless) p.tip_mass_kg = kGuessedTipMass_kg;
  for (int j = 0; j < n; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const bool driven = arm.geometry.driven.at(at);
    AxisTruth axis = truth_of(arm.axis.at(at), driven, is_prismatic_axis(arm.geometry, j));
    if (!driven) axis.link_kg_m2 = kLightLink_kg_m2;
    if (driven && weightless) axis.link_kg_m2 = kGuessedLinkOfRotor * axis.rotor_kg_m2;
    p.axis.push_back(axis);
  }
  // The stiffness of the transmissions, from that of the tip at home.
  ArmInertia inertia{body_kg_m2, JointVector::Zero(n)};
  const ArmDynamics dynamics(p.geometry, inertia);
  ArmFrames frames = frames_at_rest(p.geometry);
  ArmTerms terms;
  const JointVector home = p.geometry.home.head(n).cast<double>();
  if (!dynamics.at(home, JointVector::Zero(n), frames, terms)) return p;
  if (p.has_two_link_inertia) add_two_link_inertia(p.two_link_inertia, home, JointVector::Zero(n), terms);
  const double longest = std::sqrt(terms.force_point.by_joint.colwise().squaredNorm().maxCoeff());
  for (int j = 0; j < n; ++j) {
    AxisTruth& axis = p.axis[static_cast<std::size_t>(j)];
    if (!axis.driven) continue;
    const double lever2 = std::max(terms.force_point.by_joint.col(j).squaredNorm(),
                                   kShortestLever * kShortestLever * longest * longest);
    if (axis.stiffness_N_m_rad == 0) axis.stiffness_N_m_rad = as_double(arm.tip_stiffness_N_m) * lever2;
    const double link_kg_m2 =
        terms.mass(j, j) + axis.link_kg_m2 + p.tip_mass_kg * terms.force_point.by_joint.col(j).squaredNorm();
    axis.damping_N_m_s_rad = 2 * kDampingRatio * std::sqrt(axis.stiffness_N_m_rad * link_kg_m2);
  }
  return p;
}

}  // namespace thimble::board
