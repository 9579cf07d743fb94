#include "board/sim/any_plant.h"

#include <algorithm>
#include <cmath>

#include "board/sim/mechanics/two_link_inertia.h"

namespace thimble::board {
namespace {

using kinematics::kMaxJoints;

// Undriven axes: friction without a rotor that could stick is smoothed below this speed.
constexpr double kSmoothFriction_rad_s = .02;

std::uint64_t next_random(std::uint64_t& state) {  // splitmix64, as Plant has it
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

double stop_push(const AxisTruth& axis, double angle, double speed, double low, double high) {
  const double k = axis.stop_stiffness_N_m_rad, d = axis.stop_damping_N_m_s_rad;
  if (angle > high) return -std::max(0.0, k * (angle - high) + d * speed);
  if (angle < low) return std::max(0.0, k * (low - angle) - d * speed);
  return 0;
}

// M x = b with M symmetric and positive definite, by Cholesky: short, and the order of its sums is fixed.
void solve_in_place(JointMatrix& M, JointVector& b) {
  const Eigen::Index n = b.size();
  for (Eigen::Index j = 0; j < n; ++j) {
    for (Eigen::Index k = 0; k < j; ++k) M(j, j) -= M(j, k) * M(j, k);
    M(j, j) = std::sqrt(M(j, j));
    for (Eigen::Index i = j + 1; i < n; ++i) {
      for (Eigen::Index k = 0; k < j; ++k) M(i, j) -= M(i, k) * M(j, k);
      M(i, j) /= M(j, j);
    }
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index k = 0; k < i; ++k) b[i] -= M(i, k) * b[k];
    b[i] /= M(i, i);
  }
  for (Eigen::Index i = n; i-- > 0;) {
    for (Eigen::Index k = i + 1; k < n; ++k) b[i] -= M(k, i) * b[k];
    b[i] /= M(i, i);
  }
}

ArmInertia inertia_of(const AnyPlantParameters& p) {
  ArmInertia inertia{p.body_kg_m2, JointVector::Zero(static_cast<Eigen::Index>(p.axis.size()))};
  for (std::size_t j = 0; j < p.axis.size(); ++j)
    inertia.rotor_kg_m2[static_cast<Eigen::Index>(j)] = p.axis[j].link_kg_m2;
  return inertia;
}

}  // namespace

AnyPlantParameters AnyPlant::in_world(AnyPlantParameters p) {
  p.geometry.rotation = (p.base.rotation * p.geometry.rotation).eval();
  return p;
}

AnyPlant::AnyPlant(const AnyPlantParameters& parameters, const Hand& hand)
    : parameters_(in_world(parameters)),
      dynamics_(parameters_.geometry, inertia_of(parameters_)),
      rotation_(parameters_.geometry.rotation.cast<double>()),
      home_m_(parameters.base.home_m.cast<double>()),
      frames_(frames_at_rest(parameters_.geometry)),
      hand_(hand) {
  const auto n = static_cast<Eigen::Index>(parameters_.axis.size());
  stiffness_ = damping_ = rotor_ = JointVector::Zero(n);
  motor_torque_ = command_A_ = JointVector::Zero(n);
  torque_ = JointVector::Ones(n);
  loop_slope_ = JointVector::Zero(n);
  release_grip();
  std::uint64_t random = parameters.seed;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const AxisTruth& axis = parameters_.axis[at];
    if (axis.driven) {
      stiffness_[j] = axis.stiffness_N_m_rad;
      damping_[j] = axis.damping_N_m_s_rad;
      rotor_[j] = axis.rotor_kg_m2;
    }
    motors_.at(at).winding_C = motors_.at(at).housing_C = parameters_.ambient_C;
    counter_offset_.at(at) = static_cast<double>(next_random(random) >> 11U) * 0x1p-53 * 0x1p32;
  }
  const JointVector home = parameters_.geometry.home.head(n).cast<double>();
  place(home);
  closed_ = dynamics_.at(home, JointVector::Zero(n), frames_, last_);
  home_tip_m_ = last_.tip.at_m;
  hand_target_m_ = force_point_m();
}

void AnyPlant::command_current(const JointVector& current_A, bool enable) noexcept {
  for (Eigen::Index j = 0; j < axes(); ++j) {
    const auto peak = static_cast<double>(parameters_.axis[static_cast<std::size_t>(j)].motor.peak_current_A);
    command_A_[j] = std::clamp(current_A[j], -peak, peak);
  }
  enable_ = enable;
}

void AnyPlant::set_hand_target(const Vector3d& position_m, const Vector3d& velocity_m_s) noexcept {
  hand_target_m_ = position_m;
  hand_target_velocity_m_s_ = velocity_m_s;
}

void AnyPlant::set_grip(const JointVector& target_rad, const JointVector& speed_rad_s,
                        const JointVector& stiffness_N_m_rad, const JointVector& damping_N_m_s_rad) noexcept {
  grip_target_ = target_rad;
  grip_speed_ = speed_rad_s;
  grip_stiffness_ = stiffness_N_m_rad;
  grip_damping_ = damping_N_m_s_rad;
}

void AnyPlant::release_grip() noexcept {
  const auto n = static_cast<Eigen::Index>(parameters_.axis.size());
  grip_target_ = grip_speed_ = grip_stiffness_ = grip_damping_ = JointVector::Zero(n);
}

void AnyPlant::place(const JointVector& joints_rad, const JointVector& joint_speeds_rad_s) noexcept {
  frames_ = dynamics_.frames_near(joints_rad);
  state_ = {joints_rad, joint_speeds_rad_s, joints_rad, joint_speeds_rad_s};
}

void AnyPlant::step(double seconds) noexcept {
  const auto steps = static_cast<long>(std::ceil(seconds / parameters_.max_step_s - 1e-9));
  const double h = seconds / static_cast<double>(steps);
  for (long k = 0; k < steps; ++k) substep(h);
}

std::array<std::uint32_t, kMaxJoints> AnyPlant::encoder_counts() const noexcept {
  std::array<std::uint32_t, kMaxJoints> counts{};
  for (std::size_t j = 0; j < parameters_.axis.size(); ++j) {
    const AxisTruth& axis = parameters_.axis[j];
    const double count =
        std::floor(state_.phi[static_cast<Eigen::Index>(j)] / axis.rad_per_count + counter_offset_.at(j));
    counts.at(j) = static_cast<std::uint32_t>(static_cast<std::int64_t>(count));
    if (axis.counter_bits < 32) counts.at(j) &= (1U << static_cast<unsigned>(axis.counter_bits)) - 1U;
  }
  return counts;
}

ArmTerms AnyPlant::terms_at(const JointVector& q, const JointVector& qd) const noexcept {
  ArmTerms terms;
  meets_ = dynamics_.at(q, qd, frames_, terms);
  if (!meets_) {
    closed_ = false;
    return last_;
  }
  if (parameters_.has_two_link_inertia) add_two_link_inertia(parameters_.two_link_inertia, q, qd, terms);
  if (parameters_.tip_mass_kg > 0) {
    const MovingPoint& point = terms.force_point;
    terms.mass += parameters_.tip_mass_kg * (point.by_joint.transpose() * point.by_joint);
    const Vector3d up = rotation_.row(2);
    const double weight_N = parameters_.tip_mass_kg * static_cast<double>(kinematics::kGravity_m_s2);
    terms.bias += point.by_joint.transpose() * (parameters_.tip_mass_kg * point.bias + weight_N * up);
    terms.potential_J += weight_N * up.dot(point.at_m);
  }
  last_ = terms;
  return terms;
}

Vector3d AnyPlant::tip_m() const noexcept {
  const ArmTerms terms = terms_at(state_.q, JointVector::Zero(axes()));
  return home_m_ + rotation_ * (terms.tip.at_m - home_tip_m_);
}

Vector3d AnyPlant::force_point_m() const noexcept {
  const ArmTerms terms = terms_at(state_.q, JointVector::Zero(axes()));
  return home_m_ + rotation_ * (terms.force_point.at_m - home_tip_m_);
}

Vector3d AnyPlant::tip_velocity_m_s() const noexcept {
  return rotation_ * (terms_at(state_.q, state_.qd).tip.by_joint * state_.qd);
}

ByJoint AnyPlant::force_jacobian() const noexcept {
  return rotation_ * terms_at(state_.q, state_.qd).force_point.by_joint;
}

JointMatrix AnyPlant::mass_matrix() const noexcept {
  return terms_at(state_.q, JointVector::Zero(axes())).mass;
}

double AnyPlant::energy_J() const noexcept {
  const ArmTerms terms = terms_at(state_.q, state_.qd);
  const Vector3d point_m = home_m_ + rotation_ * (terms.force_point.at_m - home_tip_m_);
  const JointVector stretch = state_.phi - state_.q, grip = grip_target_ - state_.q;
  double joints_J = 0;
  for (Eigen::Index j = 0; j < axes(); ++j) {
    for (Eigen::Index k = 0; k < axes(); ++k) joints_J += .5 * state_.qd[j] * terms.mass(j, k) * state_.qd[k];
    joints_J += .5 * (rotor_[j] * state_.phid[j] * state_.phid[j] + stiffness_[j] * stretch[j] * stretch[j] +
                      grip_stiffness_[j] * grip[j] * grip[j]);
  }
  const Vector3d velocity = terms.force_point.by_joint * state_.qd;
  return joints_J + terms.potential_J + .5 * hand_.mass_kg * velocity.squaredNorm() +
         .5 * hand_.stiffness_N_m * (hand_target_m_ - point_m).squaredNorm();
}

JointVector AnyPlant::cable_torque(const State& s) const noexcept {
  return stiffness_.cwiseProduct(s.phi - s.q) + damping_.cwiseProduct(s.phid - s.qd);
}

JointVector AnyPlant::stop_torques(const State& s) const noexcept {
  JointVector torque(axes());
  for (Eigen::Index j = 0; j < axes(); ++j) {
    const AxisTruth& axis = parameters_.axis[static_cast<std::size_t>(j)];
    torque[j] = stop_push(axis, s.q[j], s.qd[j], axis.lower, axis.upper);
    if (!axis.driven) {
      torque[j] -= axis.viscous_N_m_s_rad * s.qd[j] +
                   axis.coulomb_N_m * std::clamp(s.qd[j] / kSmoothFriction_rad_s, -1.0, 1.0);
    }
  }
  for (const kinematics::LimitSum& sum : parameters_.sum) {
    double angle = 0, speed = 0;
    for (Eigen::Index j = 0; j < axes(); ++j) {
      const auto weight = static_cast<double>(sum.weight.at(static_cast<std::size_t>(j)));
      angle += weight * s.q[j];
      speed += weight * s.qd[j];
    }
    const double push = stop_push(parameters_.axis[0], angle, speed, static_cast<double>(sum.lower),
                                  static_cast<double>(sum.upper));
    for (Eigen::Index j = 0; j < axes(); ++j)
      torque[j] += static_cast<double>(sum.weight.at(static_cast<std::size_t>(j))) * push;
  }
  return torque;
}

// Precondition: terms_at() was last called for s.
JointVector AnyPlant::loop_torques(const State& s) noexcept {
  constexpr double kStep_rad = 1e-6;
  if (parameters_.least_spread == 0) return JointVector::Zero(axes());
  const double spread = meets_ ? frames_.spread : 0;
  if (spread >= parameters_.least_spread) return JointVector::Zero(axes());
  // Where the links do not meet there is no slope: the last one points back.
  if (spread > 0) {
    for (Eigen::Index j = 0; j < axes(); ++j) {
      JointVector beside = s.q;
      beside[j] += kStep_rad;
      ArmFrames there = frames_;
      const double ahead = dynamics_.spread(beside, there);
      beside[j] -= 2 * kStep_rad;
      there = frames_;
      const double behind = dynamics_.spread(beside, there);
      if (ahead > 0 && behind > 0) loop_slope_[j] = (ahead - behind) / (2 * kStep_rad);
    }
  }
  const double push = parameters_.loop_stiffness_N_m * (parameters_.least_spread - spread) -
                      parameters_.loop_damping_N_m_s * loop_slope_.dot(s.qd);
  return std::max(0.0, push) * loop_slope_;
}

AnyPlant::Rates AnyPlant::rates(const State& s) noexcept {
  ArmTerms terms = terms_at(s.q, s.qd);
  const JointVector cable = cable_torque(s);
  const ByJoint J = rotation_ * terms.force_point.by_joint;
  const Vector3d velocity = J * s.qd, bias = rotation_ * terms.force_point.bias;
  const Vector3d point_m = home_m_ + rotation_ * (terms.force_point.at_m - home_tip_m_);
  const Vector3d finger_N = hand_.stiffness_N_m * (hand_target_m_ - point_m) +
                            hand_.damping_N_s_m * (hand_target_velocity_m_s_ - velocity);
  Vector3d outside_N = finger_N + push_N_;
  if (specimen_ != nullptr) outside_N += specimen_->force_N(point_m, velocity, touch_);
  JointMatrix M = terms.mass + hand_.mass_kg * (J.transpose() * J);
  Rates r;
  r.qdd = cable + stop_torques(s) + loop_torques(s) - terms.bias +
          grip_stiffness_.cwiseProduct(grip_target_ - s.q) + grip_damping_.cwiseProduct(grip_speed_ - s.qd) +
          J.transpose() * (outside_N - hand_.mass_kg * bias);
  solve_in_place(M, r.qdd);
  hand_force_N_ = hand_.mass_kg * (J * r.qdd + bias) - finger_N;
  r.phidd = r.qdd;
  for (Eigen::Index j = 0; j < axes(); ++j) {
    const AxisTruth& axis = parameters_.axis[static_cast<std::size_t>(j)];
    if (!axis.driven) continue;  // moves with its link
    double rotor = motor_torque_[j] - cable[j] - axis.viscous_N_m_s_rad * s.phid[j];
    switch (coulomb_.at(static_cast<std::size_t>(j))) {
      case Coulomb::kStuck:
        rotor = 0;
        break;
      case Coulomb::kForward:
        rotor -= axis.coulomb_N_m;
        break;
      case Coulomb::kBackward:
        rotor += axis.coulomb_N_m;
        break;
    }
    r.phidd[j] = rotor / rotor_[j];
  }
  return r;
}

void AnyPlant::step_motor(std::size_t at, double cable, double h) noexcept {
  const auto j = static_cast<Eigen::Index>(at);
  const AxisTruth& axis = parameters_.axis[at];
  Motor& motor = motors_.at(at);
  const double supply = supply_ * parameters_.supply_V;
  const double shaft_rad_s = state_.phid[j] * axis.turns;
  const auto kt = static_cast<double>(axis.motor.torque_constant_N_m_A);
  if (enable_ && !open_.at(at)) {
    // The amplifier of Plant: it compensates resistance and back-EMF and removes the error within its time constant.
    const double wanted_V = motor.resistance_ohm(axis.motor) * motor.current_A + kt * shaft_rad_s +
                            static_cast<double>(axis.motor.inductance_H) * (command_A_[j] - motor.current_A) /
                                std::max(parameters_.amplifier_time_constant_s, h);
    voltage_V_.at(at) = std::clamp(wanted_V, -supply, supply);
    motor.step_winding(axis.motor, voltage_V_.at(at), shaft_rad_s, h);
  } else {
    motor.current_A = 0;
    // An open motor shows its back-EMF; an amplifier that finds no circuit gives all it has.
    voltage_V_.at(at) =
        !enable_ || command_A_[j] == 0 ? kt * shaft_rad_s : (command_A_[j] > 0 ? supply : -supply);
  }
  motor.step_heat(axis.motor, parameters_.ambient_C, h);
  motor_torque_[j] = torque_[j] * motor.current_A * axis.turns * kt;
  const double drive = motor_torque_[j] - cable;
  const double direction = state_.phid[j] != 0 ? state_.phid[j] : drive;
  if (state_.phid[j] == 0 && std::abs(drive) <= axis.stiction_ratio * axis.coulomb_N_m) {
    coulomb_.at(at) = Coulomb::kStuck;
  } else {
    coulomb_.at(at) = direction > 0 ? Coulomb::kForward : Coulomb::kBackward;
  }
}

AnyPlant::State AnyPlant::moved(const State& s, double h, const State& by, const Rates& rates) {
  return {s.q + h * by.qd, s.qd + h * rates.qdd, s.phi + h * by.phid, s.phid + h * rates.phidd};
}

void AnyPlant::substep(double h) noexcept {
  const JointVector cable = cable_torque(state_);
  for (std::size_t j = 0; j < parameters_.axis.size(); ++j)
    if (parameters_.axis[j].driven) step_motor(j, cable[static_cast<Eigen::Index>(j)], h);
  const State& s = state_;
  const Rates a = rates(s);
  const State s2 = moved(s, h / 2, s, a);
  const Rates b = rates(s2);
  const State s3 = moved(s, h / 2, s2, b);
  const Rates c = rates(s3);
  const State s4 = moved(s, h, s3, c);
  const Rates d = rates(s4);
  State next{s.q + h / 6 * (s.qd + 2 * s2.qd + 2 * s3.qd + s4.qd),
             s.qd + h / 6 * (a.qdd + 2 * b.qdd + 2 * c.qdd + d.qdd),
             s.phi + h / 6 * (s.phid + 2 * s2.phid + 2 * s3.phid + s4.phid),
             s.phid + h / 6 * (a.phidd + 2 * b.phidd + 2 * c.phidd + d.phidd)};
  for (std::size_t at = 0; at < parameters_.axis.size(); ++at) {
    const auto j = static_cast<Eigen::Index>(at);
    if (!parameters_.axis[at].driven) {
      next.phi[j] = next.q[j];
      next.phid[j] = next.qd[j];
      continue;
    }
    // Friction can stop a rotor but not reverse it.
    const Coulomb was = coulomb_.at(at);
    const bool reversed =
        (was == Coulomb::kForward && next.phid[j] < 0) || (was == Coulomb::kBackward && next.phid[j] > 0);
    if (reversed && parameters_.axis[at].coulomb_N_m > 0) next.phid[j] = 0;
  }
  state_ = next;
  if (specimen_ != nullptr && specimen_->has_friction()) {
    const ArmTerms terms = terms_at(state_.q, state_.qd);
    specimen_->update(home_m_ + rotation_ * (terms.force_point.at_m - home_tip_m_),
                      rotation_ * (terms.force_point.by_joint * state_.qd), touch_);
  }
  hand_target_m_ += h * hand_target_velocity_m_s_;
  grip_target_ += h * grip_speed_;
  time_s_ += h;
}

}  // namespace thimble::board
