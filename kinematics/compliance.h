// Elastic deflection of the tip relative to the encoders, which are at the motors: cables and links deflect
// under load. The firmware uses it to correct the tip position of a guarded move. Source: the structural
// stiffness of the arm (tip against locked motors; of a two-link arm at q = 0, of others at home), distributed over the axes as one spring
// each, or the stiffness of an axis where it is known. Units: N m/rad, N m, m. Cannot fail.
#pragma once

#include "kinematics/arm.h"

namespace thimble::kinematics {

// p_tip - p_encoders at rest under the torques that the cables transmit (including the weight of the
// links, without the friction of the motors). World frame.
template <typename S>
[[nodiscard]] Vector3<S> tip_stretch(const Posture<S>& posture, const PerAxis<S>& stiffness_N_m_rad,
                                     const PerAxis<S>& torque_N_m, int axes) noexcept {
  PerAxis<S> stretch = PerAxis<S>::Zero();
  for (int j = 0; j < axes; ++j)
    if (stiffness_N_m_rad[j] > 0) stretch[j] = torque_N_m[j] / stiffness_N_m_rad[j];
  return -velocity(posture.jacobian, stretch, axes);
}

}  // namespace thimble::kinematics
