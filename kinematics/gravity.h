// Torques that hold the weight of an arm's bodies: tau = sum m J_c^T (0, 0, g), with J_c the Jacobian of a body's centre of mass. It is the gradient of
// the potential energy by the axes, for any orientation of the base. For a two-link arm kinematics/dynamics.h has the same from its coefficients.
#pragma once

#include "kinematics/mechanism.h"

namespace thimble::kinematics {

// Bounded by kMaxBodies x kMaxJoints. Axes without a motor get their torque, too: it says what they would need. pose: of these axes.
template <typename S>
[[nodiscard]] AxisVector<S> gravity_torques(const Mechanism<S>& arm, const AxisVector<S>& axes,
                                            const MechanismPose<S>& pose) noexcept;

// Twice the kinetic energy of the bodies, as if the mass of each was at its centre, J; for speeds per metre of the tip it is their mass there.
template <typename S>
[[nodiscard]] S moving_mass(const Mechanism<S>& arm, const AxisVector<S>& axes, const MechanismPose<S>& pose,
                            const AxisVector<S>& axis_speeds) noexcept;

extern template AxisVector<float> gravity_torques(const Mechanism<float>&, const AxisVector<float>&,
                                                  const MechanismPose<float>&) noexcept;
extern template AxisVector<double> gravity_torques(const Mechanism<double>&, const AxisVector<double>&,
                                                   const MechanismPose<double>&) noexcept;
extern template float moving_mass(const Mechanism<float>&, const AxisVector<float>&,
                                  const MechanismPose<float>&, const AxisVector<float>&) noexcept;
extern template double moving_mass(const Mechanism<double>&, const AxisVector<double>&,
                                   const MechanismPose<double>&, const AxisVector<double>&) noexcept;

}  // namespace thimble::kinematics
