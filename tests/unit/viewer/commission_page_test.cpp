// The picture of a commissioning, and which answers of a page count.
#include "host-tools/viewer/commission_page.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host-tools/lab/arm_choice.h"

namespace thimble::host {
namespace {

const std::vector<std::string> kNames{"yaw", "upper", "fore"};

Eigen::Vector3d vector_of(const Json& numbers) {
  return {numbers.at(0).get<double>(), numbers.at(1).get<double>(), numbers.at(2).get<double>()};
}

CommissionPicture picture_of(const std::vector<double>& axes, const std::optional<CommissionPrompt>& prompt,
                             std::optional<std::size_t> moves = {}) {
  const kinematics::ArmData arm = chosen_arm("premium-1.5").data;
  ArmPose pose(arm);
  CommissionShown shown;
  shown.axes = axes;
  shown.axis = moves;
  return commission_picture(shown, prompt, arm, pose, kNames);
}

TEST(CommissionPicture, TheArmStandsAtHomeUntilItsCountsAreKnown) {
  const CommissionPicture unknown = picture_of({}, {});
  EXPECT_FALSE(unknown.marks.at("is_live").get<bool>());
  EXPECT_EQ(unknown.arm.at("tip_m"), Json({0.0, 0.0, 0.0}));
  for (const char* mark : {"axis", "turn", "way", "goal_m"})
    EXPECT_FALSE(unknown.marks.contains(mark)) << mark;
  const CommissionPicture turned = picture_of({.3, 0, 0}, {});
  EXPECT_TRUE(turned.marks.at("is_live").get<bool>());
  EXPECT_GT(vector_of(turned.arm.at("tip_m")).norm(), .02);
  EXPECT_NE(turned.arm.at("links_m"), unknown.arm.at("links_m"));
}

// The links of the page itself tell where a small positive turn takes the end of the link.
TEST(CommissionPicture, TheAxisInQuestionTurnsItsLinkAsTheArrowSays) {
  constexpr double kTurn = .2;
  CommissionPrompt prompt;
  for (std::size_t axis = 0; axis < kNames.size(); ++axis) {
    prompt.axis = axis;
    std::vector<double> after(3, 0.0), before(3, 0.0);
    after[axis] = kTurn;
    before[axis] = -kTurn;
    const CommissionPicture now = picture_of(std::vector<double>(3, 0.0), prompt);
    const Json& mark = now.marks.at("axis");
    EXPECT_EQ(mark.at("name"), kNames[axis]);
    const Eigen::Vector3d at_m = vector_of(mark.at("at_m")), direction = vector_of(mark.at("direction"));
    const Eigen::Vector3d moved_m = vector_of(picture_of(after, prompt).arm.at("links_m").at(0).back()) -
                                    vector_of(picture_of(before, prompt).arm.at("links_m").at(0).back());
    // Both links are driven from the base: with the upper link alone the forearm is shifted as far as the elbow.
    const Json& line = now.arm.at("links_m").at(0);
    const Eigen::Vector3d on_link_m =
        axis == 1 ? vector_of(line.at(line.size() - 2)) : vector_of(line.back());
    const Eigen::Vector3d by_arrow_m = direction.cross(on_link_m - at_m);
    EXPECT_GT(moved_m.normalized().dot(by_arrow_m.normalized()), .999) << axis;
    EXPECT_NEAR(moved_m.norm(), 2 * std::sin(kTurn) * by_arrow_m.norm(), 1e-3) << axis;
  }
  // While nothing is asked: the axis that the motor moves.
  EXPECT_EQ(picture_of({}, {}, 2).marks.at("axis").at("name"), "fore");
}

TEST(CommissionPicture, WhatThePromptAsksForIsMarked) {
  CommissionPrompt prompt;
  prompt.axis = 0;
  prompt.turn = -1;
  prompt.way = -Eigen::Vector3d::UnitX();
  prompt.goal = std::vector<double>{.1, .2, .3};
  const CommissionPicture asked = picture_of({}, prompt);
  EXPECT_EQ(asked.marks.at("turn"), -1.0);
  EXPECT_EQ(asked.marks.at("way"), Json({-1.0, 0.0, 0.0}));
  EXPECT_EQ(asked.marks.at("goal_m"), picture_of(*prompt.goal, {}).arm.at("links_m"));
}

}  // namespace
}  // namespace thimble::host
