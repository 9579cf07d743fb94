// Viscous damping along a contact normal (paper, section 3.4). Used by both paths of the renderer and by the
// volumes.
#pragma once

#include <algorithm>

namespace thimble::control {

// The damping force along the normal, N. It is never larger than the spring's push: spring and damping
// together do not pull the tip into the surface. normal_velocity_m_s: the tip's velocity against the surface,
// positive outwards.
[[nodiscard]] inline float damping_force_N(float push_N, float damping_N_s_m,
                                           float normal_velocity_m_s) noexcept {
  return std::max(-damping_N_s_m * normal_velocity_m_s, -push_N);
}

}  // namespace thimble::control
