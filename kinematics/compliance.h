// Elastic deflection of the tip relative to the encoders, which are at the motors: cables and links deflect
// under load. The firmware uses it to correct the tip position of a guarded move. Source: the structural
// stiffness of the arm model (tip against locked motors, at q = 0), distributed over the joints as one spring
// each. Units: N m/rad, N m, m. Cannot fail.
#pragma once

#include "kinematics/arm.h"

namespace thimble::kinematics {

template <typename S>
[[nodiscard]] Vector3<S> joint_stiffness(const Arm<S>& arm) noexcept {
  const Matrix3<S> J = arm.at(Vector3<S>::Zero()).jacobian;
  return S(arm.model().structural_stiffness_N_m) * J.colwise().squaredNorm().transpose();
}

// p_tip - p_encoders at rest under the joint torques that the cables transmit (including the weight of the
// links, without the friction of the motors). World frame.
template <typename S>
[[nodiscard]] Vector3<S> tip_stretch(const Posture<S>& posture, const Vector3<S>& stiffness_N_m_rad,
                                     const Vector3<S>& torque_N_m) noexcept {
  return -(posture.jacobian * torque_N_m.cwiseQuotient(stiffness_N_m_rad));
}

}  // namespace thimble::kinematics
