// The numbers of an arm: its geometry, and what is at each axis. Built in (built_in_arms.h), or from an arm image (firmware/arm/arm_image.h); used by
// the firmware in every tick, by the simulated arm and by tools.
//
// An axis is what an encoder counts and what a motor may drive. Units: SI, rad; for a prismatic axis m and N take the place of rad and N m.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "kinematics/geometry.h"

namespace thimble::kinematics {

inline constexpr float kPi = 3.14159265358979F;
inline constexpr int kMaxLimitSums = 4;
inline constexpr int kMaxArmName = 31;  // bytes

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

// The inertia of the links of a two-link arm, as the coefficients of M(q) and G(q):
//   M11 = m11 + m11_cos_2q2 cos 2q2 + m11_cos_2q3 cos 2q3 + 2 m23 cos q2 sin q3
//   M22 = m22   M33 = m33   M23 = M32 = -m23 sin(q2 - q3)   G2 = g2 cos q2   G3 = g3 sin q3
// Rotors are not included: AxisData::reflected_rotor_inertia() is added to the diagonal.
struct InertiaModel {
  float m11, m11_cos_2q2, m11_cos_2q3, m22, m33, m23;  // kg m2
  float g2, g3;                                        // N m
};

enum class EncoderKind : std::uint8_t { kQuadrature, kPotentiometer, kDrive };
enum class DriveKind : std::uint8_t { kAnalogCurrent, kMoteus, kOdrive, kMit, kDamiao };

struct AxisData {
  std::array<char, kMaxArmName + 1> name{};
  bool prismatic = false;
  float lower = 0, upper = 0;  // home is Geometry::home
  // The encoder: its sign is that of the counts for a positive motion of the axis, its turns are for one of the axis, or for a metre.
  EncoderKind encoder_kind{};
  std::uint8_t encoder_port = 0, counter_bits = 32;
  float encoder_sign = 1, counts_per_turn = 1, encoder_turns = 1;
  float max_rate_Hz = 0;  // 0: not known
  // The drive, where Geometry::driven says that there is one.
  DriveKind drive_kind{};
  std::uint8_t drive_port = 0;
  float drive_sign = 1, drive_turns = 1, delay_s = 0;
  MotorModel motor{};
  float coulomb_N_m = 0, viscous_N_m_s_rad = 0, stiction_ratio = 1;  // friction, seen at the axis
  float stiffness_N_m_rad = 0, first_resonance_Hz = 0;               // 0: not known

  [[nodiscard]] constexpr float rad_per_count() const noexcept {  // signed
    const float turn = prismatic ? 1.0F : 2.0F * kPi;
    return encoder_sign * turn / (counts_per_turn * encoder_turns);
  }
  [[nodiscard]] constexpr float torque_per_ampere() const noexcept {  // signed
    return drive_sign * shaft_per_axis() * motor.torque_constant_N_m_A;
  }
  [[nodiscard]] constexpr float reflected_rotor_inertia() const noexcept {  // kg m2, or kg
    return motor.rotor_inertia_kg_m2 * shaft_per_axis() * shaft_per_axis();
  }
  // rad of the motor's shaft for one of the axis, or for a metre.
  [[nodiscard]] constexpr float shaft_per_axis() const noexcept {
    return prismatic ? 2.0F * kPi * drive_turns : drive_turns;
  }
};

struct LimitSum {
  std::array<float, kMaxJoints> weight{};
  float lower = 0, upper = 0;
};

struct ArmData {
  std::array<char, kMaxArmName + 1> name{};
  Geometry geometry;
  std::array<AxisData, kMaxJoints> axis{};
  int sum_count = 0;
  std::array<LimitSum, kMaxLimitSums> sum{};
  bool has_inertia = false;  // of a two-link arm
  InertiaModel inertia{};
  bool commissioned =
      false;  // of an arm image: its file has passed `thimble commission`, and nothing in it was changed since
  // At the tip, in any direction; above which speed of an axis a reading of its encoder is rejected; with locked motors; of the amplifiers.
  float max_force_N = 0, max_joint_speed_rad_s = 0, tip_stiffness_N_m = 0, supply_V = 0;
};

[[nodiscard]] inline std::string_view name_of(const ArmData& arm) noexcept { return arm.name.data(); }

}  // namespace thimble::kinematics
