#include "host-tools/arms/arm_data.h"

#include <algorithm>
#include <stdexcept>

namespace thimble::host {
namespace {

using kinematics::DriveKind;
using kinematics::EncoderKind;

float as_float(const Quantity& quantity) { return static_cast<float>(quantity.value); }

template <typename Kind, std::size_t kCount>
Kind kind_named(const std::string& word, const std::array<std::pair<const char*, Kind>, kCount>& kinds) {
  for (const auto& [name, kind] : kinds)
    if (word == name) return kind;
  throw std::logic_error("no kind of an axis for " + word);
}

constexpr std::array kEncoderKinds{std::pair{"quadrature", EncoderKind::kQuadrature},
                                   std::pair{"potentiometer", EncoderKind::kPotentiometer},
                                   std::pair{"drive", EncoderKind::kDrive}};
constexpr std::array kDriveKinds{std::pair{"analog_current", DriveKind::kAnalogCurrent},
                                 std::pair{"moteus", DriveKind::kMoteus},
                                 std::pair{"odrive", DriveKind::kOdrive}, std::pair{"mit", DriveKind::kMit},
                                 std::pair{"damiao", DriveKind::kDamiao}};

template <std::size_t kSize>
void set_name(std::array<char, kSize>& to, const std::string& from) {
  std::copy_n(from.begin(), std::min(from.size(), kSize - 1), to.begin());
}

kinematics::MotorModel motor_data(const ArmMotor& m) {
  return {.torque_constant_N_m_A = as_float(m.torque_constant_N_m_A),
          .resistance_ohm = as_float(m.resistance_ohm),
          .inductance_H = as_float(m.inductance_H),
          .rotor_inertia_kg_m2 = as_float(m.rotor_inertia_kg_m2),
          .peak_current_A = as_float(m.peak_current_A),
          .continuous_torque_N_m = as_float(m.continuous_torque_N_m),
          .winding_to_housing_K_W = as_float(m.winding_to_housing_K_W),
          .housing_to_ambient_K_W = as_float(m.housing_to_ambient_K_W),
          .winding_time_constant_s = as_float(m.winding_time_constant_s),
          .housing_time_constant_s = as_float(m.housing_time_constant_s),
          .max_winding_C = as_float(m.max_winding_C)};
}

kinematics::AxisData axis_data(const ArmAxis& from) {
  kinematics::AxisData axis;
  set_name(axis.name, from.name);
  axis.prismatic = from.is_prismatic;
  axis.lower = as_float(from.lower);
  axis.upper = as_float(from.upper);
  axis.encoder_kind = kind_named(from.encoder.kind, kEncoderKinds);
  axis.encoder_port = static_cast<std::uint8_t>(from.encoder.port);
  axis.counter_bits = static_cast<std::uint8_t>(from.encoder.counter_bits);
  axis.encoder_sign = static_cast<float>(from.encoder.sign);
  axis.counts_per_turn = as_float(from.encoder.counts_per_turn);
  axis.encoder_turns = as_float(from.encoder.turns_per_turn);
  axis.max_rate_Hz = static_cast<float>(from.encoder.max_rate_Hz);
  if (from.drive) {
    axis.drive_kind = kind_named(from.drive->kind, kDriveKinds);
    axis.drive_port = static_cast<std::uint8_t>(from.drive->port);
    axis.drive_sign = static_cast<float>(from.drive->sign);
    axis.drive_turns = as_float(from.drive->turns_per_turn);
    axis.delay_s = as_float(from.drive->delay_s);
    axis.motor = motor_data(*from.motor);
  }
  axis.coulomb_N_m = as_float(from.friction.coulomb_N_m);
  axis.viscous_N_m_s_rad = as_float(from.friction.viscous_N_m_s_rad);
  axis.stiction_ratio = std::max(1.0F, as_float(from.friction.stiction_ratio));
  if (from.stiffness_N_m_rad) axis.stiffness_N_m_rad = as_float(*from.stiffness_N_m_rad);
  if (from.first_resonance_Hz) axis.first_resonance_Hz = as_float(*from.first_resonance_Hz);
  return axis;
}

}  // namespace

kinematics::ArmData arm_data(const ArmFile& from) {
  kinematics::ArmData arm;
  set_name(arm.name, from.name);
  arm.geometry = from.geometry;
  for (std::size_t j = 0; j < from.axes.size(); ++j) arm.axis.at(j) = axis_data(from.axes[j]);
  arm.sum_count = static_cast<int>(from.limit_sums.size());
  for (std::size_t i = 0; i < from.limit_sums.size(); ++i) {
    const ArmLimitSum& sum = from.limit_sums[i];
    for (std::size_t j = 0; j < sum.weights.size(); ++j)
      arm.sum.at(i).weight.at(j) = static_cast<float>(sum.weights[j]);
    arm.sum.at(i).lower = as_float(sum.lower_rad);
    arm.sum.at(i).upper = as_float(sum.upper_rad);
  }
  if (from.two_link_inertia) {
    const auto as = [](double value) { return static_cast<float>(value); };
    const TwoLinkInertia& i = *from.two_link_inertia;
    arm.has_inertia = true;
    arm.inertia = {.m11 = as(i.m11),
                   .m11_cos_2q2 = as(i.m11_cos_2q2),
                   .m11_cos_2q3 = as(i.m11_cos_2q3),
                   .m22 = as(i.m22),
                   .m33 = as(i.m33),
                   .m23 = as(i.m23),
                   .g2 = as(i.g2),
                   .g3 = as(i.g3)};
  }
  arm.max_force_N = static_cast<float>(from.max_force_N);
  arm.max_joint_speed_rad_s = static_cast<float>(from.max_joint_speed_rad_s);
  arm.tip_stiffness_N_m = static_cast<float>(from.tip_stiffness_N_m);
  arm.supply_V = static_cast<float>(from.supply_V);
  arm.commissioned = from.is_commissioned;
  return arm;
}

}  // namespace thimble::host
