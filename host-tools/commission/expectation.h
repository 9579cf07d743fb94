// What an arm file says that the commissioning will see: levers, weights, inertias, ways between the stops, and what may be asked of a motor.
#pragma once

#include <optional>
#include <vector>

#include "board/sim/any_plant.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/commission/bench.h"

namespace thimble::host {

using board::JointMatrix;
using board::JointVector;

// Of a closed loop (board::ArmFrames): where it is measured at least, and where the stops of a simulated one are.
inline constexpr double kLeastSpread = .2, kLoopStop = .1;

// m of an axis that slides for a radian of one that turns: what a hand and a step take of it, about the lever of a small arm.
[[nodiscard]] inline double per_radian(const ArmAxis& axis) { return axis.is_prismatic ? .1 : 1; }

class Expectation {
 public:
  explicit Expectation(const ArmFile& arm);

  [[nodiscard]] std::size_t axes() const { return arm_->axes.size(); }
  [[nodiscard]] const ArmFile& arm() const { return *arm_; }
  [[nodiscard]] const ArmAxis& axis(std::size_t j) const { return arm_->axes[j]; }
  [[nodiscard]] bool driven(std::size_t j) const { return arm_->axes[j].drive.has_value(); }
  [[nodiscard]] JointVector home() const;
  [[nodiscard]] bool has_loop() const { return arm_->family == "five_bar" || arm_->family == "delta"; }

  // Whether the file has the weight and inertia of the links.
  [[nodiscard]] bool knows_inertia() const { return knows_inertia_; }
  // Links and rotors; gravity's torques on the axes; velocity of the force point by the axes, world frame.
  [[nodiscard]] JointMatrix mass(const JointVector& at) const;
  [[nodiscard]] JointVector weight(const JointVector& at) const;
  // Of axis j with the others held, its rotor included; where the file has no weights with the same guess at the tip as the simulation's.
  [[nodiscard]] double inertia(std::size_t j, const JointVector& at) const;
  [[nodiscard]] board::ByJoint jacobian(const JointVector& at) const;
  [[nodiscard]] Eigen::Vector3d tip_m(const JointVector& at) const;  // from home, world frame

  [[nodiscard]] double stiffness(std::size_t j) const { return numbers_.axis[j].stiffness_N_m_rad; }

  // Way of axis j between its stops with the others at home.
  struct Span {
    double lower, upper;
  };
  [[nodiscard]] Span span(std::size_t j, const JointVector& others) const;
  [[nodiscard]] double counts(std::size_t j, double way) const;  // of the encoder, signed
  // Where the world sees axis j turn, at home: the tip's way for a positive motion; the axis itself where the tip does not move.
  [[nodiscard]] Eigen::Vector3d direction(std::size_t j) const;

  // Whether the links of a closed loop stay well apart from where they part or fold, on the way of axis j with the others there.
  [[nodiscard]] double spread(const JointVector& at) const;  // board::ArmFrames
  [[nodiscard]] bool stays_closed(std::size_t j, const JointVector& others) const;

  // What the weight turns axis j with, N m: by the file, or as a guess by 50 g at the force point.
  [[nodiscard]] double turning(std::size_t j, const JointVector& at) const;
  [[nodiscard]] bool gravity_turns(
      std::size_t j) const;  // at home or beside it, more than a fraction of its friction

  // A place within the limits at which the weight turns axis j least: below its friction where that is possible.
  [[nodiscard]] const JointVector& balanced(std::size_t j) const;

 private:
  [[nodiscard]] board::ArmTerms terms(const JointVector& at) const;
  [[nodiscard]] bool within_limits(const JointVector& at, double part) const;
  [[nodiscard]] JointVector find_balanced(std::size_t j) const;
  [[nodiscard]] JointVector balanced_within(std::size_t j, double margin) const;
  [[nodiscard]] double turning_about(std::size_t j, const JointVector& at, Eigen::Index first,
                                     Eigen::Index count) const;
  void nearer(std::size_t j, JointVector& best, Eigen::Index first, Eigen::Index count, double margin) const;

  const ArmFile* arm_;
  kinematics::ArmData data_;
  board::AnyPlantParameters numbers_;
  board::ArmDynamics dynamics_;
  bool knows_inertia_ = false;
  mutable PerAxis<std::optional<JointVector>> balanced_{};  // that were looked for
};

// Before step 7 nothing may push or move the tip more than this, and the procedure asks for half of it.
inline constexpr double kTorqueShare = .05;  // of the peak
// Where that does not overcome friction: so many times the file's, and that share of the peak at most.
inline constexpr double kOverFriction = 5, kFrictionShare = .2;
inline constexpr double kTipForce_N = 1;
inline constexpr double kTipSpeed_m_s = .1;
inline constexpr double kPulse_s = .04;
inline constexpr double kPulseEnergy_J = 5e-3;

// The largest current that may be asked of axis j before step 7, whichever joint the drive may turn in truth; and where a motion ends.
[[nodiscard]] double gentle_current_A(const Expectation& arm, std::size_t j);
[[nodiscard]] EndsAt gentle_ends(const Expectation& arm);
// Throws std::logic_error for a program beyond them: a defect of the procedure.
void demand_gentle(const Expectation& arm, const AxisProgram& program);

}  // namespace thimble::host
