// The published figures of the arms, at the pose that reproduces them (q = 0), and the world frame's signs.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cstdio>

#include "kinematics/built_in_arms.h"
#include "kinematics/dynamics.h"
#include "kinematics/two_link_arm.h"
#include "kinematics/workspace.h"

namespace thimble::kinematics {
namespace {

ArmData model(const char* name) {
  ArmData found;
  EXPECT_TRUE(built_in_arm(name, found));
  return found;
}

// What a joint's lever is at q = 0: the tip moves this far per radian, along one axis.
Eigen::Vector3d levers(const ArmData& m) {
  return TwoLinkArm<double>(m).at(Eigen::Vector3d::Zero()).jacobian.colwise().norm();
}

void expect_figure(const char* what, double measured, double published, double tolerance) {
  std::printf("%-40s %.5g, published %.5g (%+.2f %%)\n", what, measured, published,
              100 * (measured / published - 1));
  EXPECT_NEAR(measured, published, tolerance) << what;
}

TEST(ArmFigures, PremiumResolutionAndForces) {
  const ArmData m = model("premium-1.5");
  const Eigen::Vector3d lever = levers(m);
  const double resolution_mm[] = {.0248, .0294, .0233}, peak_N[] = {7.98, 6.72, 8.50},
               continuous_N[] = {1.77, 1.49, 1.88};
  for (int j = 0; j < 3; ++j) {
    expect_figure("tip resolution, mm",
                  1e3 * static_cast<double>(m.axis[static_cast<std::size_t>(j)].rad_per_count()) * lever[j],
                  resolution_mm[j], .01 * resolution_mm[j]);
    const AxisData& axis = m.axis[static_cast<std::size_t>(j)];
    const double peak = static_cast<double>(axis.torque_per_ampere() * axis.motor.peak_current_A) / lever[j];
    expect_figure("peak tip force, N", peak, peak_N[j], .01 * peak_N[j]);
    const double continuous =
        static_cast<double>(axis.drive_turns * axis.motor.continuous_torque_N_m) / lever[j];
    expect_figure("continuous tip force, N", continuous, continuous_N[j], .01 * continuous_N[j]);
  }
}

TEST(ArmFigures, PremiumApparentMass) {
  const ArmData m = model("premium-1.5");
  const TwoLinkPosture<double> p = TwoLinkArm<double>(m).at(Eigen::Vector3d::Zero());
  const Eigen::Matrix3d J_inverse = p.jacobian.inverse();
  const Eigen::Matrix3d mass = J_inverse.transpose() * mass_matrix(m.inertia, p) * J_inverse;
  // Published along the arm's own axes: out (world y), sideways (x), up (z). Two digits, so half a gram or 1
  // %.
  expect_figure("apparent mass out, kg", mass(1, 1), .032, .0005);
  expect_figure("apparent mass sideways, kg", mass(0, 0), .077, .00077);
  expect_figure("apparent mass up, kg", mass(2, 2), .052, .00052);
}

TEST(ArmFigures, PremiumCoulombAtTheTip) {
  const ArmData m = model("premium-1.5");
  const Eigen::Vector3d lever = levers(m);
  for (int j = 0; j < 3; ++j) {
    const double friction = static_cast<double>(m.axis[static_cast<std::size_t>(j)].coulomb_N_m) / lever[j];
    std::printf("Coulomb friction at the tip, joint %d: %.4f N\n", j + 1, friction);
    EXPECT_GT(friction, .0465);
    EXPECT_LT(friction, .0595);
  }
}

TEST(ArmFigures, WoodenResolutionAndForcePerAmpere) {
  const ArmData m = model("wooden");
  const Eigen::Vector3d lever = levers(m);
  const double resolution_mm[] = {.040, .054, .064}, force_N_A[] = {2.0, 1.5, 1.27};
  const double last_digit_mm[] = {.0005, .0005, .0005},
               last_digit_N_A[] = {.05, .05, .005};  // as published: half of it
  for (int j = 0; j < 3; ++j) {
    expect_figure("tip resolution, mm",
                  1e3 * static_cast<double>(m.axis[static_cast<std::size_t>(j)].rad_per_count()) * lever[j],
                  resolution_mm[j], last_digit_mm[j]);
    expect_figure("force per ampere, N/A",
                  static_cast<double>(m.axis[static_cast<std::size_t>(j)].torque_per_ampere()) / lever[j],
                  force_N_A[j], last_digit_N_A[j]);
  }
}

TEST(ArmFigures, WoodenHomeIsThePublishedOrigin) {
  // (.22, 0, .08) m in its base frame; the base's x is the world's -y.
  const ArmData m = model("wooden");
  const TwoLinkArm<double> arm(m);
  const TwoLinkGeometry& links = std::get<TwoLinkGeometry>(m.geometry.platform);
  const Eigen::Vector3d p_WB = -arm.at({0, 0, 0}).tip_m;  // minus (tip at q = 0)
  const Eigen::Vector3d base =
      -(p_WB + Eigen::Vector3f(0, -links.upper_link_m, links.base_height_m - links.forearm_m).cast<double>());
  EXPECT_LT((base - Eigen::Vector3d(0, .22, -.08)).norm(), 1e-6);
}

TEST(ArmFigures, AnUnknownNameIsNone) {
  ArmData arm;
  EXPECT_FALSE(built_in_arm("premium-1.6", arm));
}

class WorldFrame : public testing::TestWithParam<const char*> {};

TEST_P(WorldFrame, HomeIsTheOriginAndInsideTheWorkspace) {
  const TwoLinkArm<float> arm(model(GetParam()));
  EXPECT_LT(arm.at(arm.home()).tip_m.norm(), 1e-7F);
  EXPECT_EQ(workspace_limit(model(GetParam()), arm.home()), 0);
}

TEST_P(WorldFrame, JointSigns) {
  const TwoLinkArm<double> arm(model(GetParam()));
  const Eigen::Vector3d home = arm.home();
  const auto move = [&](int j) {
    Eigen::Vector3d q = home;
    q[j] += .01;
    return Eigen::Vector3d(arm.at(q).tip_m - arm.at(home).tip_m);
  };
  EXPECT_GT(move(0).x(), 1e-3);   // joint 1 swings the tip to the user's right
  EXPECT_GT(move(1).z(), 5e-4);   // joint 2 lifts it
  EXPECT_LT(move(2).y(), -1e-3);  // joint 3 brings it to the user
  const Eigen::Vector3d base = arm.at({0, static_cast<double>(kPi) / 2, 0})
                                   .tip_m;  // upper link up, forearm down: straight above the shoulder
  EXPECT_GT(base.y(), .1);                  // which stands beyond the workspace
}

TEST_P(WorldFrame, APushUpNeedsJointTwoUp) {
  const TwoLinkArm<float> arm(model(GetParam()));
  const TwoLinkPosture<float> p = arm.at(arm.home());
  EXPECT_GT((p.jacobian.transpose() * Eigen::Vector3f(0, 0, 1))[1], 0);
  EXPECT_GT((p.jacobian.transpose() * Eigen::Vector3f(1, 0, 0))[0], 0);
  EXPECT_LT((p.jacobian.transpose() * Eigen::Vector3f(0, 1, 0))[2], 0);
}

TEST_P(WorldFrame, BasePoseMovesAndTurnsTheArm) {
  BasePose base;
  base.home_m = {.1F, .2F, .3F};
  base.rotation << -1, 0, 0, 0, -1, 0, 0, 0, 1;  // half a turn: the arm reaches away from the user
  const TwoLinkArm<float> arm(model(GetParam()), base), plain(model(GetParam()));
  EXPECT_LT((arm.at(arm.home()).tip_m - base.home_m).norm(), 1e-7F);
  const Eigen::Vector3f q = arm.home() + Eigen::Vector3f(.1F, .05F, -.08F);
  const Eigen::Vector3f moved = base.home_m + base.rotation * plain.at(q).tip_m;
  EXPECT_LT((arm.at(q).tip_m - moved).norm(), 1e-6F);
}

INSTANTIATE_TEST_SUITE_P(Arms, WorldFrame, testing::Values("premium-1.5", "wooden"));

TEST(Workspace, EachLimitIsFound) {
  const ArmData m = model("premium-1.5");
  const Eigen::Vector3f home(0, 0, 0);
  const auto with = [&](int j, float value) {
    Eigen::Vector3f q = home;
    q[j] = value;
    return workspace_limit(m, q);
  };
  EXPECT_EQ(with(0, 1.6F), 1);
  EXPECT_EQ(with(1, -2.2F), 2);
  EXPECT_EQ(with(2, -.6F), 3);
  EXPECT_EQ(with(1, 1.2F), kMaxJoints + 1);
  EXPECT_EQ(with(2, 1.0F), kMaxJoints + 1);
  EXPECT_EQ(with(0, std::numeric_limits<float>::quiet_NaN()), 1);
  EXPECT_EQ(workspace_limit(m, Eigen::Vector3f(1.5F, 0, 0), .1F), 1);  // margin
  EXPECT_EQ(workspace_limit(m, Eigen::Vector3f(1.5F, 0, 0)), 0);
}

TEST(Workspace, PremiumSpansTheProductsBox) {
  // Product sheet: 381 x 267 x 191 mm (sideways, up, out).
  const ArmData premium = model("premium-1.5");
  const TwoLinkArm<double> arm(premium);
  Eigen::AlignedBox3d box;
  for (double q1 = -1.5; q1 < 1.5; q1 += .05) {
    for (double q2 = -2; q2 < 2; q2 += .05) {
      for (double q3 = -.5; q3 < 2; q3 += .05) {
        const Eigen::Vector3d q(q1, q2, q3);
        if (workspace_limit(premium, q) == 0) box.extend(arm.at(q).tip_m);
      }
    }
  }
  std::printf("workspace about home: x %.3f to %.3f, y %.3f to %.3f, z %.3f to %.3f m\n", box.min().x(),
              box.max().x(), box.min().y(), box.max().y(), box.min().z(), box.max().z());
  EXPECT_TRUE(box.contains(Eigen::Vector3d::Zero()));
  EXPECT_GE(box.sizes().x(), .381);
  EXPECT_GE(box.sizes().z(), .267);
  EXPECT_GE(box.sizes().y(), .191);
}

}  // namespace
}  // namespace thimble::kinematics
