#include "board/sim/plant.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kinematics/built_in_arms.h"
#include "kinematics/dynamics.h"

namespace thimble::board {
namespace {

using Eigen::Matrix3d;
using kinematics::MotorModel;

constexpr std::array<PlantVariant, 3> kVariants{{
    {"premium-1.5", "premium-1.5", true},
    {"premium-1.5-frictionless", "premium-1.5", false},
    {"wooden", "wooden", true},
}};

constexpr double kCopperPerKelvin = .00393;
constexpr double kReference_C = 25.0;
constexpr double kStructuralDamping =
    .05;  // fraction of critical damping with locked motors: metal links on steel cable
// Rubber stops at the joint limits.
constexpr double kStopStiffness_N_m_rad = 100.0;
constexpr double kStopDamping_N_m_s_rad = .2;

std::uint64_t split_mix(std::uint64_t& state) {
  state += 0x9E3779B97F4A7C15U;
  std::uint64_t z = state;
  z = (z ^ (z >> 30U)) * 0xBF58476D1CE4E5B9U;
  z = (z ^ (z >> 27U)) * 0x94D049BB133111EBU;
  return z ^ (z >> 31U);
}

// Pushes back beyond [low, high]; damps only inward motion.
double stop_torque(double angle, double speed, double low, double high) {
  if (angle > high)
    return -std::max(0.0, kStopStiffness_N_m_rad * (angle - high) + kStopDamping_N_m_s_rad * speed);
  if (angle < low)
    return std::max(0.0, kStopStiffness_N_m_rad * (low - angle) - kStopDamping_N_m_s_rad * speed);
  return 0.0;
}

}  // namespace

std::span<const PlantVariant> plant_variants() noexcept { return kVariants; }

const PlantVariant* find_plant_variant(std::string_view name) noexcept {
  for (const PlantVariant& variant : kVariants) {
    if (variant.name == name) return &variant;
  }
  return nullptr;
}

PlantParameters PlantParameters::from(const PlantVariant& variant) {
  return from(kinematics::built_in_arm(variant.arm), variant.friction);
}

PlantParameters PlantParameters::from(const kinematics::ArmData& data, bool friction) {
  PlantParameters p;
  p.model = data;
  const kinematics::TwoLinkArm<double> arm(p.model);
  const kinematics::TwoLinkPosture<double> posture = arm.at(Vector3d::Zero());
  const Matrix3d M = kinematics::mass_matrix(p.model.inertia, posture);
  for (int j = 0; j < 3; ++j) {
    const kinematics::AxisData& joint = p.model.axis[static_cast<std::size_t>(j)];
    if (friction) {
      p.viscous_N_m_s_rad[j] = static_cast<double>(joint.viscous_N_m_s_rad);
      p.coulomb_N_m[j] = static_cast<double>(joint.coulomb_N_m);
    }
    p.cable_stiffness_N_m_rad[j] =
        static_cast<double>(p.model.tip_stiffness_N_m) * posture.jacobian.col(j).squaredNorm();
    p.cable_damping_N_m_s_rad[j] = 2 * kStructuralDamping * std::sqrt(p.cable_stiffness_N_m_rad[j] * M(j, j));
  }
  return p;
}

double Motor::resistance_ohm(const MotorModel& model) const noexcept {
  return static_cast<double>(model.resistance_ohm) * (1 + kCopperPerKelvin * (winding_C - kReference_C));
}

void Motor::step_winding(const MotorModel& model, double voltage_V, double speed_rad_s, double h) noexcept {
  const double R = resistance_ohm(model);
  const double settled_A = (voltage_V - static_cast<double>(model.torque_constant_N_m_A) * speed_rad_s) / R;
  // exp(-a) by its (2,2) Pade approximant, bit-identical on every machine; error below a^5/720, 1e-6 at 25
  // us.
  const double a = R * h / static_cast<double>(model.inductance_H);
  const double decay = (12 - 6 * a + a * a) / (12 + 6 * a + a * a);
  current_A = settled_A + (current_A - settled_A) * decay;
}

void Motor::step_heat(const MotorModel& model, double ambient_C, double h) noexcept {
  const auto R_wh = static_cast<double>(model.winding_to_housing_K_W);
  const auto R_ha = static_cast<double>(model.housing_to_ambient_K_W);
  const double C_w = static_cast<double>(model.winding_time_constant_s) / R_wh;
  const double C_h = static_cast<double>(model.housing_time_constant_s) / R_ha;
  const double loss_W = current_A * current_A * resistance_ohm(model);
  const double inner_W = (winding_C - housing_C) / R_wh, outer_W = (housing_C - ambient_C) / R_ha;
  winding_C += h * (loss_W - inner_W) / C_w;
  housing_C += h * (inner_W - outer_W) / C_h;
}

Plant::Plant(const PlantParameters& parameters, const Hand& hand)
    : parameters_(parameters), arm_(parameters.model, parameters.base), hand_(hand) {
  std::uint64_t random = parameters.seed;
  for (std::size_t j = 0; j < 3; ++j) {
    rotor_inertia_[static_cast<Eigen::Index>(j)] =
        static_cast<double>(parameters.model.axis[j].reflected_rotor_inertia());
    motors_[j].winding_C = motors_[j].housing_C = parameters.ambient_C;
    counter_offset_[j] =
        static_cast<double>(split_mix(random) >> 11U) * 0x1p-53 * 0x1p32;  // anywhere in the register
  }
  place(arm_.home());
  hand_target_m_ = tip_m();
}

void Plant::command_current(const Vector3d& current_A, bool enable) noexcept {
  for (int j = 0; j < 3; ++j) {
    const auto peak_A =
        static_cast<double>(parameters_.model.axis[static_cast<std::size_t>(j)].motor.peak_current_A);
    command_A_[j] = std::clamp(current_A[j], -peak_A, peak_A);
  }
  enable_ = enable;
}

void Plant::set_hand_target(const Vector3d& position_m, const Vector3d& velocity_m_s) noexcept {
  hand_target_m_ = position_m;
  hand_target_velocity_m_s_ = velocity_m_s;
}

void Plant::place(const Vector3d& joints_rad, const Vector3d& joint_speeds_rad_s) noexcept {
  state_ = {joints_rad, joint_speeds_rad_s, joints_rad, joint_speeds_rad_s};
}

void Plant::step(double seconds) noexcept {
  const auto steps = static_cast<long>(std::ceil(seconds / parameters_.max_step_s - 1e-9));
  const double h = seconds / static_cast<double>(steps);
  for (long k = 0; k < steps; ++k) substep(h);
}

std::array<std::uint32_t, 3> Plant::encoder_counts() const noexcept {
  std::array<std::uint32_t, 3> counts{};
  for (std::size_t j = 0; j < 3; ++j) {
    const auto per_count = static_cast<double>(parameters_.model.axis[j].rad_per_count());
    const double count =
        std::floor(state_.phi[static_cast<Eigen::Index>(j)] / per_count + counter_offset_[j]);
    counts[j] = static_cast<std::uint32_t>(static_cast<std::int64_t>(count));
    if (parameters_.model.axis[j].counter_bits == 16) counts[j] &= 0xFFFFU;
  }
  return counts;
}

Vector3d Plant::tip_m() const noexcept { return arm_.at(state_.q).tip_m; }

Vector3d Plant::tip_velocity_m_s() const noexcept { return arm_.at(state_.q).jacobian * state_.qd; }

double Plant::energy_J() const noexcept {
  const kinematics::TwoLinkPosture<double> p = arm_.at(state_.q);
  const Matrix3d M = kinematics::mass_matrix(parameters_.model.inertia, p);
  const Vector3d stretch = state_.phi - state_.q;
  return .5 * state_.qd.dot(M * state_.qd) + .5 * state_.phid.dot(rotor_inertia_.cwiseProduct(state_.phid)) +
         .5 * hand_.mass_kg * (p.jacobian * state_.qd).squaredNorm() +
         kinematics::gravity_energy(parameters_.model.inertia, p) +
         .5 * stretch.dot(parameters_.cable_stiffness_N_m_rad.cwiseProduct(stretch)) +
         .5 * hand_.stiffness_N_m * (hand_target_m_ - p.tip_m).squaredNorm();
}

Vector3d Plant::cable_torque(const State& s) const noexcept {
  return parameters_.cable_stiffness_N_m_rad.cwiseProduct(s.phi - s.q) +
         parameters_.cable_damping_N_m_s_rad.cwiseProduct(s.phid - s.qd);
}

Vector3d Plant::stop_torques(const State& s) const noexcept {
  const kinematics::ArmData& m = parameters_.model;
  Vector3d torque;
  for (int j = 0; j < 3; ++j) {
    const kinematics::AxisData& joint = m.axis[static_cast<std::size_t>(j)];
    torque[j] =
        stop_torque(s.q[j], s.qd[j], static_cast<double>(joint.lower), static_cast<double>(joint.upper));
  }
  const double elbow = stop_torque(s.q[1] - s.q[2], s.qd[1] - s.qd[2], static_cast<double>(m.sum[0].lower),
                                   static_cast<double>(m.sum[0].upper));
  torque[1] += elbow;
  torque[2] -= elbow;
  return torque;
}

// Flat: four calls a step are most of what a simulation takes, and the calls in them are short.
[[gnu::flatten]] Plant::Rates Plant::rates(const State& s) noexcept {
  const kinematics::InertiaModel& inertia = parameters_.model.inertia;
  const kinematics::TwoLinkPosture<double> p = arm_.at(s.q);
  const Vector3d cable = cable_torque(s);
  const Vector3d finger_N = hand_.stiffness_N_m * (hand_target_m_ - p.tip_m) +
                            hand_.damping_N_s_m * (hand_target_velocity_m_s_ - p.jacobian * s.qd);
  const Vector3d bias = arm_.acceleration_bias(p, s.qd);
  const Matrix3d M =
      kinematics::mass_matrix(inertia, p) + hand_.mass_kg * (p.jacobian.transpose() * p.jacobian);
  Vector3d outside_N = finger_N + push_N_;
  if (specimen_ != nullptr) outside_N += specimen_->force_N(p.tip_m, p.jacobian * s.qd, grip_);
  const Vector3d torque = cable + stop_torques(s) - kinematics::coriolis_matrix(inertia, p, s.qd) * s.qd -
                          kinematics::gravity_torques(inertia, p) +
                          p.jacobian.transpose() * (outside_N - hand_.mass_kg * bias);
  Rates r;
  r.qdd = M.inverse() * torque;
  hand_force_N_ = hand_.mass_kg * (p.jacobian * r.qdd + bias) - finger_N;
  for (int j = 0; j < 3; ++j) {
    double rotor = motor_torque_[j] - cable[j] - parameters_.viscous_N_m_s_rad[j] * s.phid[j];
    switch (coulomb_[static_cast<std::size_t>(j)]) {
      case Coulomb::kStuck:
        rotor = 0;
        break;
      case Coulomb::kForward:
        rotor -= parameters_.coulomb_N_m[j];
        break;
      case Coulomb::kBackward:
        rotor += parameters_.coulomb_N_m[j];
        break;
    }
    r.phidd[j] = rotor / rotor_inertia_[j];
  }
  return r;
}

void Plant::substep(double h) noexcept {
  const double supply = supply_ * static_cast<double>(parameters_.model.supply_V);
  const Vector3d cable = cable_torque(state_);
  for (int j = 0; j < 3; ++j) {
    const auto at = static_cast<std::size_t>(j);
    Motor& motor = motors_[at];
    const kinematics::AxisData& joint = parameters_.model.axis[at];
    const MotorModel& motor_model = joint.motor;
    const double shaft_rad_s = state_.phid[j] * static_cast<double>(joint.drive_sign * joint.drive_turns);
    if (enable_) {
      // Voltage of an ideal current controller: it compensates resistance and back-EMF and removes the error
      // within its time constant, or within the step if that is longer.
      const double wanted_V = motor.resistance_ohm(motor_model) * motor.current_A +
                              static_cast<double>(motor_model.torque_constant_N_m_A) * shaft_rad_s +
                              static_cast<double>(motor_model.inductance_H) *
                                  (command_A_[j] - motor.current_A) /
                                  std::max(parameters_.amplifier_time_constant_s, h);
      motor.step_winding(motor_model, std::clamp(wanted_V, -supply, supply), shaft_rad_s, h);
    } else {
      motor.current_A = 0;
    }
    motor.step_heat(motor_model, parameters_.ambient_C, h);
    motor_torque_[j] = torque_[j] * motor.current_A * static_cast<double>(joint.torque_per_ampere());
    // Coulomb friction: a rotor at rest stays at rest until the torque exceeds the friction.
    const double drive = motor_torque_[j] - cable[j];
    const double direction = state_.phid[j] != 0 ? state_.phid[j] : drive;
    if (state_.phid[j] == 0 && std::abs(drive) <= parameters_.coulomb_N_m[j]) {
      coulomb_[at] = Coulomb::kStuck;
    } else {
      coulomb_[at] = direction > 0 ? Coulomb::kForward : Coulomb::kBackward;
    }
  }

  const State& s = state_;
  const Rates a = rates(s);
  const State s2{s.q + h / 2 * s.qd, s.qd + h / 2 * a.qdd, s.phi + h / 2 * s.phid, s.phid + h / 2 * a.phidd};
  const Rates b = rates(s2);
  const State s3{s.q + h / 2 * s2.qd, s.qd + h / 2 * b.qdd, s.phi + h / 2 * s2.phid,
                 s.phid + h / 2 * b.phidd};
  const Rates c = rates(s3);
  const State s4{s.q + h * s3.qd, s.qd + h * c.qdd, s.phi + h * s3.phid, s.phid + h * c.phidd};
  const Rates d = rates(s4);
  State next{s.q + h / 6 * (s.qd + 2 * s2.qd + 2 * s3.qd + s4.qd),
             s.qd + h / 6 * (a.qdd + 2 * b.qdd + 2 * c.qdd + d.qdd),
             s.phi + h / 6 * (s.phid + 2 * s2.phid + 2 * s3.phid + s4.phid),
             s.phid + h / 6 * (a.phidd + 2 * b.phidd + 2 * c.phidd + d.phidd)};
  for (int j = 0; j < 3; ++j) {
    // Friction can stop a rotor but not reverse it.
    const Coulomb state = coulomb_[static_cast<std::size_t>(j)];
    const bool reversed =
        (state == Coulomb::kForward && next.phid[j] < 0) || (state == Coulomb::kBackward && next.phid[j] > 0);
    if (reversed && parameters_.coulomb_N_m[j] > 0) next.phid[j] = 0;
  }
  state_ = next;
  if (specimen_ != nullptr && specimen_->has_friction()) {
    const kinematics::TwoLinkPosture<double> p = arm_.at(state_.q);
    specimen_->update(p.tip_m, p.jacobian * state_.qd, grip_);
  }
  hand_target_m_ += h * hand_target_velocity_m_s_;
  time_s_ += h;
}

}  // namespace thimble::board
