// The rigid-body model of an arm of any family:  M(a) add + h(a, ad) = torques, with the axes a of the arm, its bodies and rotors, and gravity.
// The simulated arm integrates it. It shares the numbers of kinematics/geometry.h with the controller and none of its code. Units: SI; vectors
// in the frame of the arm's base.
#pragma once

#include <array>

#include "board/sim/mechanics/arm_frames.h"

namespace thimble::board {

// What the geometry does not have. About the centre of mass of each body, along the axes of its link; of the rotors, seen at the axes.
struct ArmInertia {
  std::array<Eigen::Vector3d, kinematics::kMaxBodies> body_kg_m2{};
  JointVector rotor_kg_m2;
};

struct ArmTerms {
  JointMatrix mass;         // M
  JointVector bias;         // h: Coriolis, centrifugal and weight
  MovingPoint tip;          // by the axes
  MovingPoint force_point;  // the same
  double potential_J = 0;   // of the weight
};

class ArmDynamics {
 public:
  ArmDynamics(const kinematics::Geometry& geometry, const ArmInertia& inertia);

  // False: the links do not meet there; the terms are not to be used. frames: of the step before, or frames_at_rest().
  [[nodiscard]] bool at(const JointVector& axes, const JointVector& speeds, ArmFrames& frames,
                        ArmTerms& terms) const;

  // Of the loop (ArmFrames::spread); 0: the links do not meet there.
  [[nodiscard]] double spread(const JointVector& axes, ArmFrames& frames) const;

  // Frames for a place far from the step before: a delta finds its plate only from near by, so it is led there from home on a straight way.
  [[nodiscard]] ArmFrames frames_near(const JointVector& axes) const;

  [[nodiscard]] const kinematics::Geometry& geometry() const noexcept { return geometry_; }

 private:
  void add_body(const MovingFrame& frame, std::size_t body, const JointVector& qd, ArmTerms& terms) const;

  kinematics::Geometry geometry_;
  ArmInertia inertia_;
  JointMatrix joints_per_axis_;
  Eigen::Vector3d up_;  // in the base frame
};

}  // namespace thimble::board
