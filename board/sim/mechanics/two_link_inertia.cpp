#include "board/sim/mechanics/two_link_inertia.h"

#include "kinematics/trig.h"

namespace thimble::board {

void add_two_link_inertia(const kinematics::InertiaModel& inertia, const JointVector& q,
                          const JointVector& qd, ArmTerms& terms) {
  const auto of = [](float value) { return static_cast<double>(value); };
  const kinematics::SinCos<double> a = kinematics::sin_cos(q[1]), b = kinematics::sin_cos(q[2]);
  const double m23 = of(inertia.m23), by2 = of(inertia.m11_cos_2q2), by3 = of(inertia.m11_cos_2q3);
  const double sin_2q2 = 2 * a.sin * a.cos, sin_2q3 = 2 * b.sin * b.cos;
  terms.mass(0, 0) += of(inertia.m11) + by2 * (1 - 2 * a.sin * a.sin) + by3 * (1 - 2 * b.sin * b.sin) +
                      2 * m23 * a.cos * b.sin;
  terms.mass(1, 1) += of(inertia.m22);
  terms.mass(2, 2) += of(inertia.m33);
  const double sine = a.sin * b.cos - a.cos * b.sin, cosine = a.cos * b.cos + a.sin * b.sin;
  terms.mass(1, 2) -= m23 * sine;
  terms.mass(2, 1) -= m23 * sine;
  // Lagrange: h_i = sum_jk (dM_ij/dq_k - dM_jk/dq_i / 2) qd_j qd_k
  const double by_q2 = -2 * by2 * sin_2q2 - 2 * m23 * a.sin * b.sin;  // dM11/dq2
  const double by_q3 = -2 * by3 * sin_2q3 + 2 * m23 * a.cos * b.cos;  // dM11/dq3
  terms.bias[0] += (by_q2 * qd[1] + by_q3 * qd[2]) * qd[0];
  terms.bias[1] += -.5 * by_q2 * qd[0] * qd[0] + m23 * cosine * qd[2] * qd[2];
  terms.bias[2] += -.5 * by_q3 * qd[0] * qd[0] - m23 * cosine * qd[1] * qd[1];
  terms.bias[1] += of(inertia.g2) * a.cos;
  terms.bias[2] += of(inertia.g3) * b.sin;
  terms.potential_J += of(inertia.g2) * a.sin - of(inertia.g3) * b.cos;
}

}  // namespace thimble::board
