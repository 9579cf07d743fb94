// How near an arm's tip comes to a place, compared with closed forms where there are some.
#include "host-tools/arms/arm_reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

kinematics::ArmData arm_named(const std::string& name) {
  const std::string path = THIMBLE_SOURCE_DIR "/arms/" + name + ".arm.json";
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return host::arm_data(host::read_arm_file(text.str(), path));
}

double away_m(const host::ArmReach& reach, const Vector3d& point_m) {
  return reach.nearest_m([&point_m](const Vector3d&) { return point_m; });
}

// Whatever the tip can be at is a place that it reaches: also near the corners of the limits.
TEST(ArmReach, EveryPostureWithinTheLimitsIsReached) {
  for (const char* name : {"premium-1.5", "wooden", "touch", "falcon", "pantograph", "paddle", "chain-7"}) {
    const kinematics::ArmData data = arm_named(name);
    const host::ArmReach reach(data);
    const kinematics::Arm<double> arm(data);
    int compared = 0;
    for (int posture_of = 0; posture_of < (3 << arm.axes()); ++posture_of) {
      const int corner = posture_of / 3;
      kinematics::PerAxis<double> axes = arm.home();
      for (int j = 0; j < arm.axes(); ++j) {
        const kinematics::AxisData& axis = data.axis.at(static_cast<std::size_t>(j));
        const auto end = static_cast<double>((corner >> j) % 2 == 0 ? axis.lower : axis.upper);
        axes[j] += 0.3 * (1 + posture_of % 3) * (end - axes[j]);
      }
      kinematics::Posture<double> posture = arm.home_posture();
      arm.move_to(axes, posture);
      if (arm.limit(axes) != 0 || !posture.tip_m.allFinite()) continue;
      EXPECT_LE(away_m(reach, posture.tip_m), host::ArmReach::kReachTolerance_m)
          << name << ", posture " << posture_of;
      ++compared;
    }
    EXPECT_GT(compared, 0) << name;
  }
}

// The tip of the paddle is on a circle about its axis, that of the pantograph in its plane.
TEST(ArmReach, TheDistanceIsThatOfTheClosedForm) {
  const kinematics::ArmData paddle = arm_named("paddle");
  const host::ArmReach of_paddle(paddle);
  const kinematics::Arm<double> arm(paddle);
  kinematics::Posture<double> posture = arm.home_posture();
  const Vector3d along = posture.jacobian.col(0).normalized();
  const double radius_m = posture.jacobian.col(0).norm();
  kinematics::PerAxis<double> turned = arm.home();
  turned[0] += 0.1;
  arm.move_to(turned, posture);
  // Towards the axis: a chord of 0.1 rad goes r (1 - cos 0.1) that way.
  const Vector3d inwards =
      (posture.tip_m - along * along.dot(posture.tip_m)) / (radius_m * (1 - std::cos(0.1)));
  EXPECT_NEAR(inwards.norm(), 1, 1e-3);
  EXPECT_NEAR(away_m(of_paddle, 0.3 * radius_m * inwards), 0.3 * radius_m, 1e-5);
  EXPECT_NEAR(away_m(of_paddle, -0.3 * radius_m * inwards), 0.3 * radius_m, 1e-5);

  const host::ArmReach of_pantograph(arm_named("pantograph"));
  for (const double height_m : {-0.04, 0.0, 0.07})
    EXPECT_NEAR(away_m(of_pantograph, {0.01, -0.01, height_m}), std::abs(height_m), 1e-5);
}

// Beyond the stretched links of a two-link arm: the nearest is at the limits, and no nearer than the way to the sphere that the links reach.
TEST(ArmReach, AFarPlaceIsNoNearerThanTheLinksAreLong) {
  const kinematics::ArmData data = arm_named("premium-1.5");
  const auto& links = std::get<kinematics::TwoLinkGeometry>(data.geometry.platform);
  const double most_m = static_cast<double>(links.upper_link_m) + static_cast<double>(links.forearm_m);
  const host::ArmReach reach(data);
  for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0, 0, -1)}) {
    const double found_m = away_m(reach, 2 * way);
    EXPECT_GT(found_m, 2 - 2 * most_m);
    EXPECT_LT(found_m, 2);
  }
}

}  // namespace
}  // namespace thimble::test
