// How far the tip stands from where the encoders see it: they sit at the motors, and the cables and links between
// give way to the load. The firmware's guarded move measures with it. Source of the figure: the arm model's
// structural stiffness (tip against locked motors, at q = 0), split over the joints as springs of their own.
// Units: N m/rad, N m, m. Cannot fail.
#pragma once

#include "kinematics/arm.h"

namespace thimble::kinematics {

template <typename S>
[[nodiscard]] Vector3<S> joint_stiffness(const Arm<S>& arm) noexcept {
  const Matrix3<S> J = arm.at(Vector3<S>::Zero()).jacobian;
  return S(arm.model().structural_stiffness_N_m) * J.colwise().squaredNorm().transpose();
}

// p_tip - p_encoders at rest under these joint torques, as the cables carry them (the weight of the links
// included, the motors' friction not). World frame.
template <typename S>
[[nodiscard]] Vector3<S> tip_stretch(const Posture<S>& posture, const Vector3<S>& stiffness_N_m_rad,
                                     const Vector3<S>& torque_N_m) noexcept {
  return -(posture.jacobian * torque_N_m.cwiseQuotient(stiffness_N_m_rad));
}

}  // namespace thimble::kinematics
