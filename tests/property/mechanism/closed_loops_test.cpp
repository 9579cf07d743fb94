// The five-bar and the delta over their workspaces: closure, the inverse, finite differences, symmetry. mujoco_test.cpp has an independent peer.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "kinematics/mechanism.h"
#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::kinematics {
namespace {

double slope_error(const Mechanism<double>& arm, const AxisVector<double>& axes,
                   const MechanismPose<double>& pose) {
  constexpr double kStep = 1e-6;
  double worst = 0;
  for (int j = 0; j < arm.axes(); ++j) {
    AxisVector<double> ahead = axes, behind = axes;
    ahead[j] += kStep;
    behind[j] -= kStep;
    MechanismPose<double> after = pose, before = pose;
    if (!arm.at(ahead, after) || !arm.at(behind, before)) continue;
    const Vector3d slope = (after.tip_m - before.tip_m) / (2 * kStep);
    const double scale = std::max(pose.jacobian.topRows(3).norm(), 0.01);
    worst = std::max(worst, (slope - pose.jacobian.col(j).head<3>()).norm() / scale);
  }
  return worst;
}

TEST(FiveBar, TheInverseAndTheForwardMapAgree) {
  Random random(1);
  double closure_m = 0, back_m = 0, slope = 0, rounding_m = 0, mirror_m = 0;
  int cases = 0;
  for (int i = 0; i < 20000; ++i) {
    Case one;
    if (!some_five_bar_case(random, one)) continue;
    const auto& bars = std::get<FiveBarGeometry>(one.geometry.platform);
    Plate<double, 2> plate;
    const Vector2d q = one.axes;
    if (!five_bar<double>(bars, q, plate)) continue;  // its elbows point the other way
    const Vector3d tip_m = plate.position_m;
    for (int leg = 0; leg < 2; ++leg) {
      const auto at = static_cast<std::size_t>(leg);
      const double inner = static_cast<double>(bars.inner_m.at(at));
      const Vector3d elbow_m(
          (leg == 0 ? 0.0 : static_cast<double>(bars.base_distance_m)) + inner * std::cos(q[leg]),
          inner * std::sin(q[leg]), 0);
      closure_m =
          std::max(closure_m, std::abs((tip_m - elbow_m).norm() - static_cast<double>(bars.outer_m.at(at))));
    }
    Vector2d again;
    ASSERT_TRUE(five_bar_inverse<double>(bars, tip_m.head<2>(), again));
    if ((again - q).norm() > 1e-3) continue;  // the same tip with other elbows
    ++cases;
    back_m = std::max(back_m, (again - q).norm());
    const Mechanism<double> arm(one.geometry);
    MechanismPose<double> pose = arm.home_pose();
    ASSERT_TRUE(arm.at(one.axes, pose));
    if (pose.jacobian.topRows(3).norm() < 1.0) slope = std::max(slope, slope_error(arm, one.axes, pose));

    const Mechanism<float> tick(one.geometry);
    MechanismPose<float> rounded = tick.home_pose();
    const Mechanism<double> exact(one.geometry);
    if (tick.at(one.axes.cast<float>(), rounded) && exact.at(one.axes.cast<float>().cast<double>(), pose) &&
        pose.jacobian.topRows(3).norm() < 0.5)
      rounding_m = std::max(rounding_m, (rounded.plate_m.cast<double>() - pose.plate_m).norm());

    // The mirror image exchanges the legs, which here are alike only in three of four.
    FiveBarGeometry mirrored = bars;
    std::swap(mirrored.inner_m[0], mirrored.inner_m[1]);
    std::swap(mirrored.outer_m[0], mirrored.outer_m[1]);
    Plate<double, 2> image;
    ASSERT_TRUE(five_bar<double>(mirrored, Vector2d(pi - q[1], pi - q[0]), image));
    const Vector3d expected(static_cast<double>(bars.base_distance_m) - tip_m.x(), tip_m.y(), 0);
    mirror_m = std::max(mirror_m, (image.position_m - expected).norm());
  }
  test::figure("five-bar: cases", cases, "> 5000");
  test::figure("five-bar: links that do not meet, m", closure_m, "1e-9");
  test::figure("five-bar: Jacobian against differences, relative", slope, "1e-6");
  test::figure("five-bar: float, m", rounding_m, "1e-6");
  EXPECT_GT(cases, 5000);
  EXPECT_LT(closure_m, 1e-9);
  EXPECT_LT(back_m, 1e-6);
  EXPECT_LT(slope, 1e-6);
  EXPECT_LT(rounding_m, 1e-6);
  EXPECT_LT(mirror_m, 1e-9);
}

TEST(Delta, TheForwardMapFindsThePlaceOfTheInverse) {
  Random random(2);
  double from_home_m = 0, slope = 0, rounding_m = 0, symmetry_m = 0;
  for (int i = 0; i < 5000; ++i) {
    Vector3d place_m;
    const Case one = some_delta_case(random, place_m);
    const auto& geometry = std::get<DeltaGeometry>(one.geometry.platform);
    const Mechanism<double> arm(one.geometry);
    MechanismPose<double> pose = arm.home_pose();
    ASSERT_TRUE(arm.closes_at_home());
    ASSERT_TRUE(arm.at(one.axes, pose)) << place_m.transpose();
    from_home_m = std::max(from_home_m, (pose.plate_m - place_m).norm());
    slope = std::max(slope, slope_error(arm, one.axes, pose));

    const Mechanism<float> tick(one.geometry);
    MechanismPose<float> rounded = tick.home_pose();
    ASSERT_TRUE(tick.at(one.axes.cast<float>(), rounded));
    ASSERT_TRUE(arm.at(one.axes.cast<float>().cast<double>(), pose));
    rounding_m = std::max(rounding_m, (rounded.plate_m.cast<double>() - pose.plate_m).norm());

    // Legs that each take the angle of the next one turn the plate by their difference.
    const double turn = static_cast<double>(geometry.leg_angle_rad[1] - geometry.leg_angle_rad[0]);
    MechanismPose<double> turned = arm.home_pose();
    ASSERT_TRUE(arm.at(AxisVector<double>(Vector3d(one.axes[2], one.axes[0], one.axes[1])), turned));
    ASSERT_TRUE(arm.at(one.axes, pose));
    symmetry_m = std::max(
        symmetry_m, (turned.plate_m - Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * pose.plate_m).norm());
  }
  test::figure("delta: forward from home against the inverse, m", from_home_m, "1e-9");
  test::figure("delta: Jacobian against differences, relative", slope, "1e-6");
  test::figure("delta: float, m", rounding_m, "1e-6");
  test::figure("delta: threefold symmetry, m", symmetry_m, "1e-7, the rounding of the legs' angles");
  EXPECT_LT(from_home_m, 1e-9);
  EXPECT_LT(slope, 1e-6);
  EXPECT_LT(rounding_m, 1e-6);
  EXPECT_LT(symmetry_m, 1e-7);
}

// A wrist on a delta: the twist of the tip is that of the plate and that of the wrist.
TEST(Delta, AWristFollowsThePlate) {
  Random random(3);
  double slope = 0;
  for (int i = 0; i < 500; ++i) {
    Vector3d place_m;
    Case one = some_delta_case(random, place_m);
    ChainGeometry& wrist = one.geometry.chain;
    wrist.count = 3;
    wrist.force_joint = static_cast<int>(random.below(4));
    for (std::size_t k = 0; k < 3; ++k)
      wrist.joint.at(k) = {.origin_m = (0.02 * random.in_box(Vector3d::Ones())).cast<float>(),
                           .axis = random.direction().cast<float>()};
    wrist.tip_m = {0, 0, 0.03F};
    AxisVector<double> axes(6);
    axes << one.axes, random.in_box(Vector3d::Ones());
    const Mechanism<double> arm(one.geometry);
    MechanismPose<double> pose = arm.home_pose();
    ASSERT_TRUE(arm.at(axes, pose));
    slope = std::max(slope, slope_error(arm, axes, pose));
    // No motor at the wrist: none of its torques.
    const AxisVector<double> torques = arm.torques(pose, {1, 2, 3});
    EXPECT_EQ(torques.tail(3).norm(), 0);
    if (wrist.force_joint == 0) {
      EXPECT_LT((pose.force_jacobian.rightCols(3)).norm(), 1e-12);
    }
  }
  EXPECT_LT(slope, 1e-6);
}

}  // namespace
}  // namespace thimble::kinematics
