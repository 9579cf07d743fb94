// The simulated arm of any family: what board/sim/plant.h is for a two-link arm, with 1 to 7 axes, by the rigid-body model of board/sim/mechanics.
//
//   links   (M(a) + hand mass) add + h(a, ad) = k (phi - a) + d (phid - ad) + stops + grip + J^T F
//   rotors  J_r phidd = torque - k (phi - a) - d (phid - ad) - viscous - Coulomb
//   motors  L di/dt = v - R(T) i - Ke w,   |v| <= supply;   the amplifier controls the current
//
// An axis without a motor has no rotor: its encoder is at the link, and so is its friction. The force F of hand, push and specimen acts at the
// force point of the arm (the gimbal of one whose wrist is only sensed). Integration: Runge-Kutta 4 with steps of at most max_step_s. The same
// program gives the same numbers in every run. Units: SI, rad (m and N where an axis is prismatic), C; world frame, in which the tip is at
// base.home_m with all axes at home. A step that would part the links of a five-bar or a delta keeps the terms of the step before, and
// closed() says so. With least_spread its stops keep it away from there.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "board/sim/mechanics/arm_dynamics.h"
#include "board/sim/plant.h"
#include "kinematics/arm_data.h"

namespace thimble::board {

// What is truly at an axis, as seen there; it may differ from what the arm's file says.
struct AxisTruth {
  bool driven = false;
  double lower = 0, upper = 0;
  double stop_stiffness_N_m_rad = 100, stop_damping_N_m_s_rad = .2;
  double coulomb_N_m = 0, viscous_N_m_s_rad = 0;
  double stiction_ratio = 1;                            // of the torque that starts a rotor to Coulomb's
  double stiffness_N_m_rad = 0, damping_N_m_s_rad = 0;  // of the transmission
  double rotor_kg_m2 = 0;
  double link_kg_m2 = 0;  // of the link, beside the bodies of the geometry
  double rad_per_count = 0;
  int counter_bits = 32;
  double turns =
      0;  // of the motor for one of the axis, signed: with the drive's sign; rad per m where it is prismatic
  kinematics::MotorModel motor{};
};

struct AnyPlantParameters {
  kinematics::Geometry geometry;
  std::array<Eigen::Vector3d, kinematics::kMaxBodies> body_kg_m2{};  // ArmInertia
  bool has_two_link_inertia = false;
  kinematics::InertiaModel two_link_inertia{};
  double tip_mass_kg = 0;  // beside the bodies
  // Stops of a closed loop, between its last links: below this spread (ArmFrames) they push with the energy k/2 (least - spread)^2, and damp. 0: none.
  double least_spread = 0;
  double loop_stiffness_N_m = 100, loop_damping_N_m_s = .2;
  std::vector<AxisTruth> axis;
  std::vector<kinematics::LimitSum> sum;
  double supply_V = 24;
  double amplifier_time_constant_s = 50e-6;
  double ambient_C = 25;
  double max_step_s = kPlantStep_s;
  kinematics::BasePose base;
  std::uint64_t seed = 1;  // of the counters at power-on

  // As the data say. body_kg_m2: of the bodies, which an arm's data do not have. An arm without any weight gets links (50 g at the tip, a part
  // of the rotors' inertia at each axis), as a guess. Where no stiffness of an axis is known, that of the tip is taken at home.
  [[nodiscard]] static AnyPlantParameters from(
      const kinematics::ArmData& arm,
      const std::array<Eigen::Vector3d, kinematics::kMaxBodies>& body_kg_m2 = no_body_inertia());
  [[nodiscard]] static std::array<Eigen::Vector3d, kinematics::kMaxBodies> no_body_inertia();
};

class AnyPlant {
 public:
  // Starts at rest with the tip at home and the hand's target where the force acts. Precondition: the links meet there.
  explicit AnyPlant(const AnyPlantParameters& parameters, const Hand& hand = kNoHand);

  // Commands stay in effect until the next ones.
  void command_current(const JointVector& current_A, bool enable) noexcept;  // not enabled: motors open
  // As Plant::set_drives(). A motor that gives 0 of its torque has its current all the same; one that is open has none.
  void set_drives(double supply, const JointVector& torque) noexcept {
    supply_ = supply;
    torque_ = torque;
  }
  void set_open(std::size_t axis, bool open) noexcept { open_.at(axis) = open; }
  void set_hand(const Hand& hand) noexcept { hand_ = hand; }
  void set_hand_target(const Vector3d& position_m, const Vector3d& velocity_m_s) noexcept;
  // Two hands at the links: a spring and a damper for each axis, whose targets move on. Stiffness 0 lets go.
  void set_grip(const JointVector& target_rad, const JointVector& speed_rad_s,
                const JointVector& stiffness_N_m_rad, const JointVector& damping_N_m_s_rad) noexcept;
  void release_grip() noexcept;
  void set_specimen(std::shared_ptr<const Specimen> specimen) noexcept {
    specimen_ = std::move(specimen);
    touch_ = {};
  }
  void push(const Vector3d& force_N) noexcept { push_N_ = force_N; }
  void set_max_step(double seconds) noexcept { parameters_.max_step_s = seconds; }

  // A delta is assembled there as on a straight way from home.
  void place(const JointVector& joints_rad, const JointVector& joint_speeds_rad_s) noexcept;
  void place(const JointVector& joints_rad) noexcept {
    place(joints_rad, JointVector::Zero(joints_rad.size()));
  }
  // Where the other one is, at rest: an arm of the same geometry, whose links are assembled in the same way.
  void place_as(const AnyPlant& other) noexcept {
    place(other.state_.q);
    frames_ = other.frames_;
  }

  void step(double seconds) noexcept;

  [[nodiscard]] std::array<std::uint32_t, kinematics::kMaxJoints> encoder_counts()
      const noexcept;  // raw registers, with their widths
  [[nodiscard]] Vector3d tip_m() const noexcept;
  [[nodiscard]] Vector3d force_point_m() const noexcept;  // where hand and specimen are
  [[nodiscard]] Vector3d tip_velocity_m_s() const noexcept;
  [[nodiscard]] ByJoint force_jacobian() const noexcept;  // of the force point, world frame
  [[nodiscard]] Vector3d hand_force_N() const noexcept { return hand_force_N_; }
  [[nodiscard]] Eigen::Index axes() const noexcept { return state_.q.size(); }
  [[nodiscard]] const JointVector& joints_rad() const noexcept { return state_.q; }
  [[nodiscard]] const JointVector& joint_speeds_rad_s() const noexcept { return state_.qd; }
  [[nodiscard]] const JointVector& rotors_rad() const noexcept { return state_.phi; }
  [[nodiscard]] const JointVector& rotor_speeds_rad_s() const noexcept { return state_.phid; }
  [[nodiscard]] const JointVector& motor_torques_N_m() const noexcept { return motor_torque_; }
  [[nodiscard]] const std::array<Motor, kinematics::kMaxJoints>& motors() const noexcept { return motors_; }
  [[nodiscard]] double motor_voltage_V(std::size_t axis) const noexcept { return voltage_V_.at(axis); }
  [[nodiscard]] double time_s() const noexcept { return time_s_; }
  [[nodiscard]] const AnyPlantParameters& parameters() const noexcept { return parameters_; }
  [[nodiscard]] bool closed() const noexcept { return closed_; }  // at every step so far
  [[nodiscard]] double energy_J() const noexcept;          // as Plant::energy_J(), with the grip's springs
  [[nodiscard]] JointMatrix mass_matrix() const noexcept;  // of the links without rotors and hand

 private:
  struct State {
    JointVector q, qd, phi, phid;
  };
  struct Rates {
    JointVector qdd, phidd;
  };
  enum class Coulomb : std::uint8_t { kStuck, kForward, kBackward };

  [[nodiscard]] static AnyPlantParameters in_world(AnyPlantParameters p);
  [[nodiscard]] ArmTerms terms_at(const JointVector& q, const JointVector& qd) const noexcept;
  [[nodiscard]] Rates rates(const State& s) noexcept;
  [[nodiscard]] JointVector cable_torque(const State& s) const noexcept;
  [[nodiscard]] JointVector stop_torques(const State& s) const noexcept;
  [[nodiscard]] JointVector loop_torques(const State& s) noexcept;
  void step_motor(std::size_t axis, double cable, double h) noexcept;
  void substep(double h) noexcept;
  [[nodiscard]] static State moved(const State& s, double h, const State& by, const Rates& rates);

  AnyPlantParameters parameters_;
  ArmDynamics dynamics_;
  Eigen::Matrix3d rotation_;  // of the base frame in the world
  Vector3d home_tip_m_ = Vector3d::Zero(), home_m_ = Vector3d::Zero();
  mutable ArmFrames frames_;
  mutable ArmTerms last_;
  mutable bool closed_ = true, meets_ = true;  // at every step so far; now
  JointVector loop_slope_;                     // of the spread by the axes, where it was last too small
  Hand hand_;
  State state_;
  JointVector stiffness_, damping_, rotor_, grip_target_, grip_speed_, grip_stiffness_, grip_damping_;
  std::array<Motor, kinematics::kMaxJoints> motors_{};
  std::array<Coulomb, kinematics::kMaxJoints> coulomb_{};
  std::array<bool, kinematics::kMaxJoints> open_{};
  std::array<double, kinematics::kMaxJoints> voltage_V_{};
  JointVector motor_torque_, command_A_, torque_;
  bool enable_ = false;
  double supply_ = 1;
  Vector3d hand_target_m_ = Vector3d::Zero(), hand_target_velocity_m_s_ = Vector3d::Zero();
  Vector3d push_N_ = Vector3d::Zero();
  std::shared_ptr<const Specimen> specimen_;
  SpecimenGrip touch_;
  Vector3d hand_force_N_ = Vector3d::Zero();
  std::array<double, kinematics::kMaxJoints> counter_offset_{};  // in counts
  double time_s_ = 0;
};

}  // namespace thimble::board
