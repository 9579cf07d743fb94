// The lines of an arm as the page gets them.
#include "host-tools/viewer/arm_drawing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host-tools/lab/arm_choice.h"

namespace thimble::host {
namespace {

double distance_m(const Json& a, const Json& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) sum += std::pow(a.at(i).get<double>() - b.at(i).get<double>(), 2);
  return std::sqrt(sum);
}

TEST(ArmDrawing, TheLastLinkEndsAtTheTipAndTheBaseStaysWhereItIs) {
  ArmDrawing drawing(chosen_arm("premium-1.5").data);
  ASSERT_EQ(drawing.axes(), 3U);
  const std::vector<double> home(3, 0.0), turned{0.3, 0.0, 0.0};
  ArmPose pose(chosen_arm("premium-1.5").data);
  ASSERT_TRUE(pose.move_to(turned));
  // The base has been moved by a mounting: what the device calls the tip is there, too.
  const Eigen::Vector3d tip_m = pose.tip_m() + Eigen::Vector3d(0.1, 0, 0.02);
  const Json first = drawing.lines(home, {0.1, 0, 0.02});
  const Json then = drawing.lines(turned, {tip_m.x(), tip_m.y(), tip_m.z()});
  ASSERT_EQ(first.size(), 1U);
  ASSERT_EQ(then.size(), 1U);
  constexpr double kRounding_m = 2e-4;
  EXPECT_LT(distance_m(first[0].back(), Json({0.1, 0, 0.02})), kRounding_m);
  EXPECT_LT(distance_m(then[0].back(), Json({tip_m.x(), tip_m.y(), tip_m.z()})), kRounding_m);
  EXPECT_LT(distance_m(first[0].front(), then[0].front()), kRounding_m) << "the base";
  EXPECT_GT(distance_m(first[0].back(), then[0].back()), 0.02);
  const std::size_t elbow = first[0].size() - 2;
  EXPECT_NEAR(distance_m(first[0][elbow], first[0].back()), distance_m(then[0][elbow], then[0].back()),
              kRounding_m);
}

TEST(ArmDrawing, NothingIsDrawnOfAxesThatAreNone) {
  ArmDrawing drawing(chosen_arm("wooden").data);
  EXPECT_TRUE(drawing.lines({0, 0}, {}).is_null());
  EXPECT_TRUE(drawing.lines({0, 0, std::numeric_limits<double>::quiet_NaN()}, {}).is_null());
}

}  // namespace
}  // namespace thimble::host
