// The simulated arm: rigid links driven through elastic cables, motors, amplifiers, encoders, motor
// temperatures, and a hand at the fingertip. Bit-identical on every machine (own sine and cosine, no libm
// function except sqrt), seeded, with its own clock. The simulated board and tests own one per arm; the
// controller does not know it.
//
//   links   (M(q) + hand mass) qdd + C qd + G = k (phi - q) + d (phid - qd) + stops + J^T F_hand
//   rotors  J_r phidd = torque - k (phi - q) - d (phid - qd) - viscous - Coulomb
//   motors  L di/dt = v - R(T) i - Ke w,   |v| <= supply;   the amplifier controls the current
//   heat    winding -> housing -> ambient, R(T) = R0 (1 + .00393 (T - 25))
//
// Encoders and friction are at the rotors, as on the real arm, so the stretch of the cables is between the
// position that the controller measures and the fingertip: this is the structural mode. Integration is
// Runge-Kutta 4 with steps of at most max_step_s. Units: SI, rad, C; world frame. Variants: premium-1.5,
// premium-1.5-frictionless, wooden.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>
#include <utility>

#include "board/sim/specimen.h"
#include "kinematics/arm_data.h"
#include "kinematics/two_link_arm.h"

namespace thimble::board {

using Vector3d = Eigen::Vector3d;

struct PlantVariant {
  std::string_view name;
  std::string_view arm;  // of kinematics/built_in_arms.h, which the firmware uses
  bool friction;
};
[[nodiscard]] std::span<const PlantVariant> plant_variants() noexcept;
[[nodiscard]] const PlantVariant* find_plant_variant(std::string_view name) noexcept;  // null: unknown

inline constexpr double kPlantStep_s = 25e-6;

// Properties that may differ between two arms of one model. from() fills them from a variant; tests change
// single values.
struct PlantParameters {
  kinematics::ArmData model;
  Vector3d viscous_N_m_s_rad = Vector3d::Zero();
  Vector3d coulomb_N_m = Vector3d::Zero();
  Vector3d cable_stiffness_N_m_rad =
      Vector3d::Zero();  // per joint, from the model's structural stiffness at q = 0
  Vector3d cable_damping_N_m_s_rad = Vector3d::Zero();
  double amplifier_time_constant_s = 50e-6;
  double ambient_C = 25.0;
  double max_step_s = kPlantStep_s;
  kinematics::BasePose base;
  std::uint64_t seed = 1;  // determines the encoder counters at power-on, including the fraction of a count

  [[nodiscard]] static PlantParameters from(const PlantVariant& variant);
  // arm: kinematics::is_two_link(), with its inertia.
  [[nodiscard]] static PlantParameters from(const kinematics::ArmData& arm, bool friction = true);
};

// One motor with its amplifier. The winding current is exact for constant voltage and speed.
struct Motor {
  double current_A = 0;
  double winding_C = 25;
  double housing_C = 25;

  [[nodiscard]] double resistance_ohm(const kinematics::MotorModel& model) const noexcept;
  // Winding current after h at this voltage and shaft speed.
  void step_winding(const kinematics::MotorModel& model, double voltage_V, double speed_rad_s,
                    double h) noexcept;
  void step_heat(const kinematics::MotorModel& model, double ambient_C, double h) noexcept;
};

// The hand at the thimble: its mass moves with the tip; a spring and a damper pull it to its target position.
struct Hand {
  double mass_kg = 0.05;
  double stiffness_N_m = 500.0;
  double damping_N_s_m = 5.0;
};
inline constexpr Hand kNoHand{0, 0, 0};

class Plant {
 public:
  // Starts at rest with the tip and the hand target at home.
  explicit Plant(const PlantParameters& parameters, const Hand& hand = kNoHand);

  // Commands stay in effect until the next ones.
  void command_current(const Vector3d& current_A, bool enable) noexcept;  // not enabled: motors open
  // What is wrong with the drives: the part of the supply's voltage that is there, and of its torque that each motor gives; negative: its
  // wires are exchanged.
  void set_drives(double supply, const Vector3d& torque) noexcept {
    supply_ = supply;
    torque_ = torque;
  }
  void set_hand(const Hand& hand) noexcept { hand_ = hand; }
  void set_hand_target(
      const Vector3d& position_m,
      const Vector3d& velocity_m_s) noexcept;  // the target continues to move with this velocity
  void set_specimen(std::shared_ptr<const Specimen> specimen) noexcept {
    specimen_ = std::move(specimen);
    grip_ = {};
  }  // object that the tip can touch; null: none
  void push(const Vector3d& force_N) noexcept { push_N_ = force_N; }  // an extra force on the tip

  // Sets the joint state with unstretched cables. Motors keep their current and temperature.
  void place(const Vector3d& joints_rad, const Vector3d& joint_speeds_rad_s = Vector3d::Zero()) noexcept;

  void step(double seconds) noexcept;

  [[nodiscard]] std::array<std::uint32_t, 3> encoder_counts()
      const noexcept;  // raw registers, with the width of the model
  [[nodiscard]] Vector3d tip_m() const noexcept;
  [[nodiscard]] Vector3d tip_velocity_m_s() const noexcept;
  [[nodiscard]] Vector3d hand_force_N() const noexcept {
    return hand_force_N_;
  }  // force of the arm on the hand in the last step
  [[nodiscard]] const Vector3d& joints_rad() const noexcept { return state_.q; }
  [[nodiscard]] const Vector3d& joint_speeds_rad_s() const noexcept { return state_.qd; }
  [[nodiscard]] const Vector3d& rotors_rad() const noexcept { return state_.phi; }  // as joint angles
  [[nodiscard]] const std::array<Motor, 3>& motors() const noexcept { return motors_; }
  [[nodiscard]] double time_s() const noexcept { return time_s_; }
  [[nodiscard]] const PlantParameters& parameters() const noexcept { return parameters_; }
  // Kinetic energy (links, rotors, hand), and potential energy of gravity, cables and hand spring. J.
  [[nodiscard]] double energy_J() const noexcept;

 private:
  struct State {
    Vector3d q, qd, phi, phid;
  };
  struct Rates {
    Vector3d qdd, phidd;
  };
  enum class Coulomb : std::uint8_t { kStuck, kForward, kBackward };

  [[nodiscard]] Rates rates(const State& s) noexcept;
  [[nodiscard]] Vector3d cable_torque(const State& s) const noexcept;
  [[nodiscard]] Vector3d stop_torques(const State& s) const noexcept;
  void substep(double h) noexcept;

  PlantParameters parameters_;
  kinematics::TwoLinkArm<double> arm_;
  Hand hand_;
  State state_;
  std::array<Motor, 3> motors_{};
  std::array<Coulomb, 3> coulomb_{};
  Vector3d rotor_inertia_;
  Vector3d motor_torque_ = Vector3d::Zero();
  Vector3d command_A_ = Vector3d::Zero();
  bool enable_ = false;
  double supply_ = 1;
  Vector3d torque_ = Vector3d::Ones();
  Vector3d hand_target_m_, hand_target_velocity_m_s_ = Vector3d::Zero();
  Vector3d push_N_ = Vector3d::Zero();
  std::shared_ptr<const Specimen> specimen_;
  SpecimenGrip grip_;
  Vector3d hand_force_N_ = Vector3d::Zero();
  std::array<double, 3> counter_offset_{};  // in counts
  double time_s_ = 0;
};

}  // namespace thimble::board
