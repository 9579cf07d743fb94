// The pose of an arm for pictures and programs, compared with the kinematics of the controller.
#include "host-tools/arms/arm_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"
#include "kinematics/arm.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

kinematics::ArmData data_of(const std::string& name) {
  const std::string path = THIMBLE_SOURCE_DIR "/arms/" + name + ".arm.json";
  std::ifstream in(path);
  std::stringstream text;
  text << in.rdbuf();
  return host::arm_data(host::read_arm_file(text.str(), path));
}

const std::vector<std::string> kPosedArms = {"premium-1.5", "wooden", "touch",  "falcon",
                                             "pantograph",  "paddle", "chain-7"};

// Axes a part of the way from home to their limits, each another one.
std::vector<double> axes_at(const kinematics::ArmData& arm, const std::vector<double>& home, int which) {
  std::vector<double> axes = home;
  for (std::size_t j = 0; j < axes.size(); ++j) {
    const bool up = (which + static_cast<int>(j)) % 2 == 0;
    axes[j] +=
        0.1 * which * (static_cast<double>(up ? arm.axis.at(j).upper : arm.axis.at(j).lower) - axes[j]);
  }
  return axes;
}

// Lengths of the pieces of a line.
std::vector<double> lengths(const host::ArmPose::Line& line) {
  std::vector<double> all;
  for (std::size_t i = 1; i < line.size(); ++i) all.push_back((line[i] - line[i - 1]).norm());
  return all;
}

TEST(ArmPose, TipAndJacobianAreThoseOfTheController) {
  for (const std::string& name : kPosedArms) {
    const kinematics::ArmData data = data_of(name);
    host::ArmPose pose(data);
    const kinematics::Arm<double> arm(data);
    for (int which = 0; which < 5; ++which) {
      const std::vector<double> axes = axes_at(data, pose.home(), which);
      ASSERT_TRUE(pose.move_to(axes)) << name << ' ' << which;
      kinematics::Posture<double> posture = arm.home_posture();
      kinematics::PerAxis<double> given = kinematics::PerAxis<double>::Zero();
      for (std::size_t j = 0; j < axes.size(); ++j) given[static_cast<Eigen::Index>(j)] = axes[j];
      arm.move_to(given, posture);
      EXPECT_LT((pose.tip_m() - posture.tip_m).norm(), 1e-7) << name << ' ' << which;
      EXPECT_LT((pose.jacobian() - posture.jacobian.leftCols(arm.axes())).norm(), 1e-6)
          << name << ' ' << which;
    }
  }
}

// The base stays where it is, and the links as long as they are, whatever the axes do.
TEST(ArmPose, LinksAreRigidAndBeginAtTheBase) {
  for (const std::string& name : kPosedArms) {
    const kinematics::ArmData data = data_of(name);
    host::ArmPose pose(data);
    const std::vector<host::ArmPose::Line> first = pose.links();
    double moved_m = 0;
    for (int which = 1; which < 5; ++which) {
      ASSERT_TRUE(pose.move_to(axes_at(data, pose.home(), which)));
      const std::vector<host::ArmPose::Line> now = pose.links();
      ASSERT_EQ(now.size(), first.size()) << name;
      for (std::size_t line = 0; line < now.size(); ++line) {
        const std::vector<double> was = lengths(first[line]), is = lengths(now[line]);
        ASSERT_EQ(was.size(), is.size()) << name;
        // The shins of a delta, which stand for two parallel ones that end beside the lines' corners, are only about as long.
        const bool is_delta = std::holds_alternative<kinematics::DeltaGeometry>(data.geometry.platform);
        for (std::size_t i = 0; i < was.size(); ++i)
          EXPECT_NEAR(is[i], was[i], is_delta && i == 1 ? 0.1 * was[i] : 1e-6)
              << name << ", line " << line << ", link " << i;
        const bool is_wrist = line + 1 == now.size() && first.size() > 1 && data.geometry.chain.count > 0;
        if (is_wrist) continue;
        EXPECT_LT((now[line].front() - first[line].front()).norm(), 1e-6) << name;
      }
      moved_m += (now.back().back() - first.back().back()).norm();
      if (data.geometry.chain.force_joint < data.geometry.chain.count) continue;
      EXPECT_LT((now.back().back() - pose.tip_m()).norm(), 1e-7) << name;
    }
    EXPECT_GT(moved_m, 0.01) << name;
  }
}

TEST(ArmPose, LinksAreAsLongAsTheFileSays) {
  const auto lengths_of = [](const std::string& name, std::size_t line) {
    return lengths(host::ArmPose(data_of(name)).links().at(line));
  };
  const auto premium = std::get<kinematics::TwoLinkGeometry>(data_of("premium-1.5").geometry.platform);
  const std::vector<double> two = lengths_of("premium-1.5", 0);
  ASSERT_GE(two.size(), 2U);
  EXPECT_NEAR(two[two.size() - 2], static_cast<double>(premium.upper_link_m), 1e-6);
  EXPECT_NEAR(two.back(), static_cast<double>(premium.forearm_m), 1e-6);
  const auto bars = std::get<kinematics::FiveBarGeometry>(data_of("pantograph").geometry.platform);
  for (std::size_t leg = 0; leg < 2; ++leg) {
    const std::vector<double> of_leg = lengths_of("pantograph", leg);
    ASSERT_EQ(of_leg.size(), 2U);
    EXPECT_NEAR(of_leg[0], static_cast<double>(bars.inner_m.at(leg)), 1e-6);
    EXPECT_NEAR(of_leg[1], static_cast<double>(bars.outer_m.at(leg)), 1e-6);
  }
  EXPECT_NEAR(
      lengths_of("falcon", 0).front(),
      static_cast<double>(std::get<kinematics::DeltaGeometry>(data_of("falcon").geometry.platform).thigh_m),
      1e-6);
}

TEST(ArmPose, WhatDoesNotCloseLeavesItWhereItWas) {
  const kinematics::ArmData data = data_of("pantograph");
  host::ArmPose pose(data);
  const Vector3d before = pose.tip_m();
  EXPECT_FALSE(pose.move_to(std::vector<double>{0.0}));
  EXPECT_FALSE(pose.move_to(std::vector<double>{std::nan(""), 0.0}));
  // The inner links meet over the middle of the base: the tip may be anywhere on a circle.
  const auto& bars = std::get<kinematics::FiveBarGeometry>(data.geometry.platform);
  const double q = std::acos(0.5 * static_cast<double>(bars.base_distance_m / bars.inner_m[0]));
  EXPECT_FALSE(pose.move_to(std::vector<double>{q, std::numbers::pi - q}));
  EXPECT_EQ(pose.tip_m(), before);
}

// A chain whose axes move its joints backwards, two joints at once, and along a rail.
kinematics::ArmData coupled_chain() {
  kinematics::ArmData data = data_of("paddle");
  kinematics::ChainGeometry& chain = data.geometry.chain;
  chain.count = 3;
  chain.joint[0].axis = Eigen::Vector3f::UnitY();
  chain.joint[1] = chain.joint[2] = chain.joint[0];
  chain.joint[1].origin_m = chain.joint[2].origin_m = {0, 0, .1F};
  chain.joint[2].kind = kinematics::JointKind::kPrismatic;
  chain.joint[2].axis = Eigen::Vector3f::UnitX();
  chain.force_joint = chain.count;
  data.geometry.joints_per_axis.topLeftCorner<3, 3>() << -1, 0, 0, 1, 1, 0, 0, 0, -2;
  data.geometry.home.setZero();
  return data;
}

// How fast the first point of the links that moves does so, by differences of the links themselves.
struct FirstMove {
  Vector3d at_m = Vector3d::Zero(), speed = Vector3d::Zero();  // m, by the speed of the axis
};
std::optional<FirstMove> first_move(const kinematics::ArmData& data, std::vector<double> axes,
                                    std::size_t axis) {
  constexpr double kStep = 1e-4, kStill_m = 1e-3;
  host::ArmPose pose(data);
  EXPECT_TRUE(pose.move_to(axes));
  const std::vector<host::ArmPose::Line> at = pose.links();
  axes[axis] += kStep;
  EXPECT_TRUE(pose.move_to(axes));
  const std::vector<host::ArmPose::Line> after = pose.links();
  axes[axis] -= 2 * kStep;
  EXPECT_TRUE(pose.move_to(axes));
  const std::vector<host::ArmPose::Line> before = pose.links();
  std::optional<FirstMove> first;
  std::size_t first_point = 0;
  for (std::size_t line = 0; line < at.size(); ++line)
    for (std::size_t i = 0; i < at[line].size(); ++i) {
      const Vector3d speed = (after[line][i] - before[line][i]) / (2 * kStep);
      if (speed.norm() < kStill_m || (first && i >= first_point)) continue;
      first = FirstMove{at[line][i], speed};
      first_point = i;
    }
  return first;
}

// Of an axis along whose line all points lie that it turns.
Vector3d turning_of_the_tip(const kinematics::ArmData& data, const std::vector<double>& axes,
                            std::size_t axis) {
  constexpr double kStep = 1e-4;
  const kinematics::Mechanism<double> mechanism(data.geometry);
  std::array<Eigen::Matrix3d, 2> turn;
  for (const int way : {0, 1}) {
    kinematics::AxisVector<double> q =
        Eigen::Map<const Eigen::VectorXd>(axes.data(), static_cast<Eigen::Index>(axes.size()));
    q[static_cast<Eigen::Index>(axis)] += way == 0 ? -kStep : kStep;
    kinematics::MechanismPose<double> pose = mechanism.home_pose();
    EXPECT_TRUE(mechanism.at(q, pose));
    turn.at(static_cast<std::size_t>(way)) = pose.rotation;
  }
  const Eigen::AngleAxisd made(Eigen::Matrix3d(turn[1] * turn[0].transpose()));
  return made.angle() / (2 * kStep) * made.axis();
}

TEST(ArmPose, LinesOfTheAxesAreThoseAboutWhichTheLinksTurn) {
  std::vector<std::pair<std::string, kinematics::ArmData>> arms{{"coupled", coupled_chain()}};
  for (const std::string& name : kPosedArms) arms.emplace_back(name, data_of(name));
  arms.emplace_back("five-bar", data_of("../docs/examples/five-bar/five-bar-odrive"));
  for (const auto& [name, data] : arms) {
    host::ArmPose pose(data);
    for (int which = 0; which < 4; ++which) {
      const std::vector<double> axes = name == "coupled"
                                           ? std::vector<double>{.3 * which, -.2 * which, .01 * which}
                                           : axes_at(data, pose.home(), which);
      ASSERT_TRUE(pose.move_to(axes)) << name << ' ' << which;
      for (std::size_t j = 0; j < axes.size(); ++j) {
        const host::ArmPose::AxisLine line = pose.axis_line(j);
        const std::string where = name + ", axis " + std::to_string(j) + ", place " + std::to_string(which);
        EXPECT_NEAR(line.direction.norm(), 1, 1e-6) << where;
        EXPECT_EQ(line.slides, name == "coupled" && j == 2) << where;
        const std::optional<FirstMove> moved = first_move(data, axes, j);
        if (!moved) {
          EXPECT_LT((line.direction - turning_of_the_tip(data, axes, j)).norm(), 1e-5) << where;
          continue;
        }
        Vector3d speed = line.direction.cross(moved->at_m - line.at_m);
        if (line.slides) speed = 2 * line.direction;  // its joint goes twice as far
        EXPECT_LT((speed - moved->speed).norm(), 1e-5) << where;
      }
    }
  }
}

}  // namespace
}  // namespace thimble::test
