// The planar five-bar: two inner links turn about fixed points of the base, two outer links join their ends to the tip.
//
//   A = l1 (cos q1, sin q1)     B = (d, 0) + l2 (cos q2, sin q2)     h = B - A
//   tip = A + x h/|h| + y n,   n square to h on its left,   x = (L1^2 - L2^2 + |h|^2) / 2|h|,   y = +-sqrt(L1^2 - x^2)
//   velocity from (tip - A) . (v - dA/dt) = 0 and (tip - B) . (v - dB/dt) = 0
//
// Source: circle meets circle; Campion, Wang, Hayward 2005 (the Pantograph). Singular where an outer link is in line with its inner one (the tip
// cannot move that way), where the outer links are in line with each other (|h| = L1 + L2: it cannot resist), and where A = B.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "kinematics/geometry.h"
#include "kinematics/platform.h"
#include "kinematics/trig.h"

namespace thimble::kinematics {

// False: the links do not meet, and the plate is as it was.
template <typename S>
[[nodiscard]] bool five_bar(const FiveBarGeometry& links, const Eigen::Matrix<S, 2, 1>& q,
                            Plate<S, 2>& plate) noexcept {
  using Vector2 = Eigen::Matrix<S, 2, 1>;
  const S l1 = S(links.inner_m[0]), l2 = S(links.inner_m[1]), L1 = S(links.outer_m[0]),
          L2 = S(links.outer_m[1]);
  const SinCos<S> q1 = sin_cos(q[0]), q2 = sin_cos(q[1]);
  const Vector2 A(l1 * q1.cos, l1 * q1.sin), B(S(links.base_distance_m) + l2 * q2.cos, l2 * q2.sin);
  const Vector2 h = B - A;
  const S h2 = h.squaredNorm();
  if (!(h2 > S(1e-10))) return false;                   // 10 um: the tip may be anywhere on a circle
  const S along = (L1 * L1 - L2 * L2 + h2) / (2 * h2);  // x / |h|
  const S y2_per_h2 = L1 * L1 / h2 - along * along;
  if (!(y2_per_h2 > 0)) return false;
  const S across = (links.up ? S(1) : S(-1)) * std::sqrt(y2_per_h2);
  const Vector2 P = A + along * h + across * Vector2(-h.y(), h.x());
  // Rows: the outer links. The area that they span is what the velocity is divided by.
  const Vector2 a = P - A, b = P - B;
  const S area = a.x() * b.y() - a.y() * b.x();
  if (!(std::abs(area) > S(1e-4) * L1 * L2)) return false;
  const S by_q1 = a.dot(Vector2(-A.y(), A.x()));
  const S by_q2 = b.dot(Vector2(-l2 * q2.sin, l2 * q2.cos));
  plate.position_m << P, S(0);
  plate.jacobian << b.y() * by_q1 / area, -a.y() * by_q2 / area,  //
      -b.x() * by_q1 / area, a.x() * by_q2 / area,                //
      S(0), S(0);
  return true;
}

// Joints for a tip in the plane, by elbows that point outwards: that of the first link to the left of the way to the tip, that of the second
// one to its right. False (q unchanged): out of reach. For tests and set-up.
template <typename S>
[[nodiscard]] bool five_bar_inverse(const FiveBarGeometry& links, const Eigen::Matrix<S, 2, 1>& tip_m,
                                    Eigen::Matrix<S, 2, 1>& q) noexcept {
  Eigen::Matrix<S, 2, 1> found;
  for (int i = 0; i < 2; ++i) {
    const std::size_t leg = static_cast<std::size_t>(i);
    const S l = S(links.inner_m[leg]), L = S(links.outer_m[leg]);
    const S x = tip_m.x() - (i == 0 ? S(0) : S(links.base_distance_m)), y = tip_m.y();
    const S r2 = x * x + y * y, r = std::sqrt(r2);
    if (!(r < l + L && r > std::abs(l - L))) return false;
    const S bend = std::acos((l * l + r2 - L * L) / (2 * l * r));
    found[i] = std::atan2(y, x) + ((i == 0) == links.up ? bend : -bend);
  }
  q = found;
  return true;
}

}  // namespace thimble::kinematics
