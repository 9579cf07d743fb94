// The arm file as plain data, read and checked key by key: docs/arm-format.md. check_arm() (arm_checks.h) judges whether the arm can work.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/keys/part.h"
#include "kinematics/geometry.h"

namespace thimble::host {

struct ArmEncoder {
  int port = 0;
  std::string kind;
  Quantity counts_per_turn;
  int counter_bits = 32;
  double sign = 1;
  Quantity turns_per_turn;
  double max_rate_Hz = 0;  // 0: not given
};

struct ArmDrive {
  int port = 0;
  std::string kind;
  double sign = 1;
  Quantity turns_per_turn, delay_s;
};

struct ArmMotor {
  Quantity torque_constant_N_m_A, resistance_ohm, inductance_H, rotor_inertia_kg_m2, peak_current_A,
      continuous_torque_N_m, winding_to_housing_K_W, housing_to_ambient_K_W, winding_time_constant_s,
      housing_time_constant_s, max_winding_C;
};

struct ArmFriction {
  Quantity coulomb_N_m, viscous_N_m_s_rad, stiction_ratio;
};

// Angles in rad; where is_prismatic, in m, as its torques are forces.
struct ArmAxis {
  std::string name;
  bool is_prismatic = false;
  Quantity lower, upper, home;
  ArmEncoder encoder;
  std::optional<ArmDrive> drive;
  std::optional<ArmMotor> motor;  // of each driven axis
  ArmFriction friction;
  std::optional<Quantity> stiffness_N_m_rad, first_resonance_Hz;

  [[nodiscard]] double per_count() const;    // rad or m, signed
  [[nodiscard]] double per_ampere() const;   // N m or N, signed; 0 without a drive
  [[nodiscard]] double peak_torque() const;  // N m or N
};

struct ArmLimitSum {
  std::vector<double> weights;
  Quantity lower_rad, upper_rad;
};

struct ArmWall {
  double rate_Hz = 0, damping_N_s_m = 0;
  Quantity stiffness_N_m;
};

struct TwoLinkInertia {
  double m11, m11_cos_2q2, m11_cos_2q3, m22, m33, m23, g2, g3;
};

struct ArmFile {
  std::string name, description, source;
  std::string family;  // the word of the file: "serial", ...
  kinematics::Geometry geometry;
  std::vector<std::string> joints;  // their names, those of the platform first
  std::vector<ArmAxis> axes;
  std::vector<ArmLimitSum> limit_sums;
  std::array<Eigen::Vector3d, kinematics::kMaxBodies> body_inertia_kg_m2{};  // of geometry.body
  std::optional<TwoLinkInertia> two_link_inertia;
  double max_force_N = 0, max_joint_speed_rad_s = 0, tip_stiffness_N_m = 0, supply_V = 0;
  std::vector<ArmWall> largest_walls;
  std::string commissioned_on;   // the day; empty: it has not passed a commissioning
  bool is_commissioned = false;  // and nothing that a board works by was changed since

  [[nodiscard]] bool changed_since() const { return !commissioned_on.empty() && !is_commissioned; }
};

// `name` stands in messages. Throws Error (kBadInput) with file, line, JSON pointer, the value and what is allowed.
[[nodiscard]] ArmFile read_arm_file(const std::string& text, const std::string& name);

}  // namespace thimble::host
