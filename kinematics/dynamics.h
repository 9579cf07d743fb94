// The rigid-body model of a two-link arm:  M(q) qdd + C(q, qd) qd + G(q) = torque.  The firmware uses gravity_torques() to
// compensate the weight of the arm; the simulated arm integrates the complete equation; tests instantiate it
// for double. Rotors are not included, see arm_data.h. Units: kg m2, N m, rad. Cannot fail: NaN input gives
// NaN output.
#pragma once

#include "kinematics/two_link_arm.h"

namespace thimble::kinematics {

template <typename S>
struct PlaneAngles {  // of joints 2 and 3; the inertia depends on no other joint
  S s2, c2, s3, c3;
  explicit PlaneAngles(const TwoLinkAngles<S>& p) noexcept
      : s2(p.q2.sin), c2(p.q2.cos), s3(p.q3.sin), c3(p.q3.cos) {}
};

template <typename S>
[[nodiscard]] Matrix3<S> mass_matrix(const InertiaModel& m, const TwoLinkAngles<S>& posture) noexcept {
  const PlaneAngles<S> a(posture);
  const S m23 = -S(m.m23) * (a.s2 * a.c3 - a.c2 * a.s3);
  Matrix3<S> M;
  M << S(m.m11) + S(m.m11_cos_2q2) * (1 - 2 * a.s2 * a.s2) + S(m.m11_cos_2q3) * (1 - 2 * a.s3 * a.s3) +
           2 * S(m.m23) * a.c2 * a.s3,
      0, 0,              //
      0, S(m.m22), m23,  //
      0, m23, S(m.m33);
  return M;
}

// C from the Christoffel symbols of M:  C_ij = sum_k (dM_ij/dq_k + dM_ik/dq_j - dM_jk/dq_i) qd_k / 2,  so
// Mdot - 2C is skew-symmetric.
template <typename S>
[[nodiscard]] Matrix3<S> coriolis_matrix(const InertiaModel& m, const TwoLinkAngles<S>& posture,
                                         const Vector3<S>& qd) noexcept {
  const PlaneAngles<S> a(posture);
  const S h2 = -2 * S(m.m11_cos_2q2) * a.s2 * a.c2 - S(m.m23) * a.s2 * a.s3;  // half of dM11/dq2
  const S h3 = -2 * S(m.m11_cos_2q3) * a.s3 * a.c3 + S(m.m23) * a.c2 * a.c3;  // half of dM11/dq3
  const S d = -S(m.m23) * (a.c2 * a.c3 + a.s2 * a.s3);                        // dM23/dq2 = -dM23/dq3
  Matrix3<S> C;
  C << h2 * qd[1] + h3 * qd[2], h2 * qd[0], h3 * qd[0],  //
      -h2 * qd[0], 0, -d * qd[2],                        //
      -h3 * qd[0], d * qd[1], 0;
  return C;
}

template <typename S>
[[nodiscard]] Vector3<S> gravity_torques(const InertiaModel& m, const TwoLinkAngles<S>& posture) noexcept {
  return {S(0), S(m.g2) * posture.q2.cos, S(m.g3) * posture.q3.sin};
}

// Potential energy in J; its gradient is gravity_torques().
template <typename S>
[[nodiscard]] S gravity_energy(const InertiaModel& m, const TwoLinkAngles<S>& posture) noexcept {
  return S(m.g2) * posture.q2.sin - S(m.g3) * posture.q3.cos;
}

}  // namespace thimble::kinematics
