// The arm models: constant data, selected by name at run time. Used by the firmware in every tick and by the
// simulated arm.
//
// All arms here have the same topology: a yaw axis, an upper link and a forearm, both driven from the base,
// so joints 2 and 3 are absolute angles in the vertical plane. In the base frame, with x in the direction in
// which the arm points and z up:
//   x = c1 (l1 c2 + l2 s3)    y = s1 (l1 c2 + l2 s3)    z = l0 + l1 s2 - l2 c3
// At q = 0 the upper link is horizontal and the forearm points down. This pose reproduces the published
// resolutions, forces and apparent masses (tests/unit/kinematics prints them).
//
// Units: SI, rad. Index 0, 1, 2 is joint 1, 2, 3. Only the lookup of an unknown name can fail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace thimble::kinematics {

enum class CounterWidth : std::uint8_t { k16, k32 };

struct JointModel {
  float motor_turns_per_turn;     // transmission
  float encoder_counts_per_turn;  // of the motor
  float sign;                     // +1 or -1: joint angle over encoder count, and torque over current
  float lower_rad, upper_rad;     // mechanical limits
  float viscous_N_m_s_rad;        // friction, seen at the joint
  float coulomb_N_m;
};

struct MotorModel {
  float torque_constant_N_m_A;  // and back-EMF constant, V s/rad
  float resistance_ohm;         // at 25 C
  float inductance_H;
  float rotor_inertia_kg_m2;
  float peak_current_A;
  float continuous_torque_N_m;  // at the shaft, after the losses of the motor
  float winding_to_housing_K_W, housing_to_ambient_K_W;
  float winding_time_constant_s, housing_time_constant_s;
  float max_winding_C;
};

// The inertia of the links, as the coefficients of M(q) and G(q):
//   M11 = m11 + m11_cos_2q2 cos 2q2 + m11_cos_2q3 cos 2q3 + 2 m23 cos q2 sin q3
//   M22 = m22   M33 = m33   M23 = M32 = -m23 sin(q2 - q3)   G2 = g2 cos q2   G3 = g3 sin q3
// Rotors are not included: each adds rotor_inertia x motor_turns_per_turn^2 to the diagonal at its joint.
struct InertiaModel {
  float m11, m11_cos_2q2, m11_cos_2q3, m22, m33, m23;  // kg m2
  float g2, g3;                                        // N m
};

struct ArmModel {
  std::string_view name;
  CounterWidth counter_width;                    // of the encoders' counter registers
  float base_height_m, upper_link_m, forearm_m;  // l0, l1, l2
  std::array<JointModel, 3> joint;
  std::array<float, 3> home_rad;       // joint angles at the home pose, where the tip is at BasePose::home_m
  float min_elbow_rad, max_elbow_rad;  // bounds of q2 - q3
  float max_joint_speed_rad_s;         // joint speed above which an encoder reading is rejected
  float max_force_N;                   // at the tip, in any direction
  float supply_V;                      // of the motor amplifiers
  float structural_stiffness_N_m;      // tip stiffness with locked motors, at q = 0
  MotorModel motor;                    // all three are the same
  InertiaModel inertia;

  [[nodiscard]] constexpr float rad_per_count(int j) const noexcept;  // joint angle per encoder count, signed
  [[nodiscard]] constexpr float torque_per_ampere(int j) const noexcept;  // N m at the joint per A, signed
  [[nodiscard]] constexpr float reflected_rotor_inertia(int j) const noexcept;  // kg m2 at the joint
};

[[nodiscard]] std::span<const ArmModel> arm_models() noexcept;

// Null if no arm model has that name.
[[nodiscard]] const ArmModel* find_arm_model(std::string_view name) noexcept;

inline constexpr float kPi = 3.14159265358979F;

constexpr float ArmModel::rad_per_count(int j) const noexcept {
  const JointModel& m = joint[static_cast<std::size_t>(j)];
  return m.sign * 2.0F * kPi / (m.encoder_counts_per_turn * m.motor_turns_per_turn);
}

constexpr float ArmModel::torque_per_ampere(int j) const noexcept {
  const JointModel& m = joint[static_cast<std::size_t>(j)];
  return m.sign * m.motor_turns_per_turn * motor.torque_constant_N_m_A;
}

constexpr float ArmModel::reflected_rotor_inertia(int j) const noexcept {
  const JointModel& m = joint[static_cast<std::size_t>(j)];
  return motor.rotor_inertia_kg_m2 * m.motor_turns_per_turn * m.motor_turns_per_turn;
}

}  // namespace thimble::kinematics
