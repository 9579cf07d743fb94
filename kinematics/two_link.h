// Yaw, upper link and forearm, both links driven from the base, so joints 2 and 3 are absolute angles in the vertical plane. With x in the
// direction in which the arm points and z up:
//
//   x = c1 (l1 c2 + l2 s3)    y = s1 (l1 c2 + l2 s3)    z = l0 + l1 s2 - l2 c3
//
// At q = 0 the upper link is horizontal and the forearm points down. Singular where the links are in line, q2 - q3 = +-90 degrees, and where
// the tip is on the axis of yaw.
#pragma once

#include <Eigen/Core>

#include "kinematics/geometry.h"
#include "kinematics/platform.h"
#include "kinematics/trig.h"

namespace thimble::kinematics {

template <typename S>
void two_link(const TwoLinkGeometry& links, const SinCos<S>& q1, const SinCos<S>& q2, const SinCos<S>& q3,
              Plate<S, 3>& plate) noexcept {
  const S l0 = S(links.base_height_m), l1 = S(links.upper_link_m), l2 = S(links.forearm_m);
  const S reach = l1 * q2.cos + l2 * q3.sin;
  plate.position_m << q1.cos * reach, q1.sin * reach, l0 + l1 * q2.sin - l2 * q3.cos;
  plate.jacobian << -q1.sin * reach, -q1.cos * l1 * q2.sin, q1.cos * l2 * q3.cos,  //
      q1.cos * reach, -q1.sin * l1 * q2.sin, q1.sin * l2 * q3.cos,                 //
      0, l1 * q2.cos, l2 * q3.sin;
}

}  // namespace thimble::kinematics
