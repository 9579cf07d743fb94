// The numbers of an arm as a board needs them: its geometry, and what is at each axis. from an arm image (firmware/arm/arm_image.h). Units: SI, rad; m and N
// where a joint is prismatic.
#pragma once

#include <array>
#include <cstdint>

#include "kinematics/arm_model.h"
#include "kinematics/geometry.h"

namespace thimble::kinematics {

inline constexpr int kMaxLimitSums = 4;
inline constexpr int kMaxArmName = 31;  // bytes

enum class EncoderKind : std::uint8_t { kQuadrature, kPotentiometer, kDrive };
enum class DriveKind : std::uint8_t { kAnalogCurrent, kMoteus, kOdrive, kMit, kDamiao };

struct AxisData {
  std::array<char, kMaxArmName + 1> name{};
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
  float coulomb_N_m = 0, viscous_N_m_s_rad = 0, stiction_ratio = 1;
  float stiffness_N_m_rad = 0, first_resonance_Hz = 0;  // 0: not known
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
  float max_force_N = 0, max_joint_speed_rad_s = 0, tip_stiffness_N_m = 0, supply_V = 0;
};

}  // namespace thimble::kinematics
