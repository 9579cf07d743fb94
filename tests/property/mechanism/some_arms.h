// Closed mechanisms with published lengths and at random, in places of their workspaces.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "kinematics/mechanism.h"
#include "tests/support/random.h"

namespace thimble::kinematics {

using test::Random;
using Vector2d = Eigen::Vector2d;
using Vector3d = Eigen::Vector3d;
using std::numbers::pi;

// Lengths of the Haply 2diy, of its second hardware with the base joints on one axis, of the Pantograph, and at random.
inline FiveBarGeometry some_five_bar(Random& random) {
  switch (random.below(4)) {
    case 0:
      return {.base_distance_m = 0.038F, .inner_m = {0.07F, 0.07F}, .outer_m = {0.09F, 0.09F}, .up = true};
    case 1:
      return {.base_distance_m = 0.0F, .inner_m = {0.07F, 0.07F}, .outer_m = {0.09F, 0.09F}, .up = true};
    case 2:
      return {
          .base_distance_m = 0.025F, .inner_m = {0.063F, 0.063F}, .outer_m = {0.075F, 0.075F}, .up = true};
    default: {
      const auto length = [&](double least, double most) {
        return static_cast<float>(random.uniform(least, most));
      };
      return {.base_distance_m = length(0, 0.06),
              .inner_m = {length(0.05, 0.08), length(0.05, 0.08)},
              .outer_m = {length(0.08, 0.1), length(0.08, 0.1)},
              .up = random.below(2) == 0};
    }
  }
}

// Of the Falcon: libnifalcon's and Martin and Hillier's.
inline DeltaGeometry some_delta(Random& random) {
  constexpr auto kDegree = static_cast<float>(pi / 180);
  DeltaGeometry delta{.thigh_m = 0.06F,
                      .shin_m = 0.1025F,
                      .plate_u_m = 0.01443F,
                      .plate_v_m = -0.025F,
                      .shin_end_m = 0.01125F,
                      .knee_end_m = 0.01125F,
                      .base_u_m = 0.04F,
                      .base_v_m = -0.02309F,
                      .leg_angle_rad = {105 * kDegree, -15 * kDegree, -135 * kDegree},
                      .minus = true,
                      .home_axis_m = 0.11F};
  if (random.below(2) == 0) {
    delta.plate_u_m = 0.0157F;
    delta.plate_v_m = 0.0262F;
    delta.shin_end_m = delta.knee_end_m = 0.0115F;
    delta.base_u_m = 0.0366F;
    delta.base_v_m = 0.0272F;
    delta.leg_angle_rad = {15 * kDegree, 255 * kDegree, 135 * kDegree};
  }
  return delta;
}

struct Case {
  Geometry geometry;
  AxisVector<double> axes;
};

// A place in the workspace: the tip of a five-bar in front of its base, in the plane, or the plate of a delta in a ball of 40 mm.
inline bool some_five_bar_case(Random& random, Case& found) {
  const FiveBarGeometry bars = some_five_bar(random);
  const double side = bars.up ? 1.0 : -1.0;
  const Vector2d tip_m(random.uniform(-0.07, 0.1), side * random.uniform(0.05, 0.14));
  Vector2d q;
  if (!five_bar_inverse<double>(bars, tip_m, q)) return false;
  found.geometry = {};
  found.geometry.platform = bars;
  found.geometry.home.head<2>() = q.cast<float>();
  found.geometry.driven = {true, true};
  found.axes = q;
  return true;
}
inline Vector3d some_place(Random& random) {
  return Vector3d(0, 0, 0.115) + 0.04 * std::cbrt(random.uniform(0, 1)) * random.direction();
}
inline Case some_delta_case(Random& random, Vector3d& place_m) {
  Case found;
  const DeltaGeometry geometry = some_delta(random);
  found.geometry.platform = geometry;
  found.geometry.driven = {true, true, true};
  const Delta<double> delta(geometry);
  Vector3d home, q;
  EXPECT_TRUE(delta.inverse({0, 0, static_cast<double>(geometry.home_axis_m)}, home));
  found.geometry.home.head<3>() = home.cast<float>();
  do {
    place_m = some_place(random);
  } while (!delta.inverse(place_m, q));
  found.axes = q;
  return found;
}

}  // namespace thimble::kinematics
