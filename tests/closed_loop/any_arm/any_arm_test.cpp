// The controller on every arm that comes with Thimble: it homes, arms, and renders a wall that a hand presses against, on the simulated arm, whose
// mechanics are not the controller's. The oracle is the wall's own law at the true position of the tip.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>

#include "board/sim/sim_board.h"
#include "kinematics/directions.h"
#include "tests/closed_loop/any_arm/arms.h"
#include "tests/support/figure.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::SimBoard;
using board::Vector3d;
using firmware::Mode;

// Where the arm pushes best at home, in the world.
Vector3d best_way(const kinematics::ArmData& data) {
  const kinematics::Arm<float> arm(data);
  return kinematics::directions_of(arm.driven_jacobian(arm.home_posture())).along.col(0).cast<double>();
}

bool until(SimBoard& board, Mode mode, double seconds) {
  for (double left_s = seconds; left_s > 0; left_s -= 1 / board.options().rate_Hz) {
    if (board.controller().mode() == mode &&
        board.controller().telemetry().ramp >= (mode == Mode::kArmed ? 1 : 0))
      return true;
    board.controller().keep_alive();
    board.tick();
  }
  return false;
}

void run(SimBoard& board, double seconds) {
  for (double left_s = seconds; left_s > 0; left_s -= 1 / board.options().rate_Hz) {
    board.controller().keep_alive();
    board.tick();
  }
}

class AnyArm : public testing::TestWithParam<const char*> {
 protected:
  static constexpr float kStiffness_N_m = 300;

  void start(const kinematics::ArmData& data) {
    board::SimBoardOptions options;
    options.arm = data;
    options.hand = {0.05, 300, 5};
    board_ = std::make_unique<SimBoard>(options);
    home_m_ = board_->arm(0).tip_m();
    normal_ = best_way(data);
    SceneBuilder scene;
    scene.plane(normal_, normal_.dot(home_m_) - kFree_m, {.stiffness_N_m = kStiffness_N_m});
    ASSERT_EQ(board_->controller().load_scene(scene.bytes()), firmware::StoreStatus::kOk);
    run(*board_, 0.01);
    ASSERT_EQ(board_->controller().request(firmware::Command::kHome), 0U);
    ASSERT_TRUE(until(*board_, Mode::kReady, 2));
    ASSERT_EQ(board_->controller().request(firmware::Command::kArm), 0U);
    ASSERT_TRUE(until(*board_, Mode::kArmed, 2));
  }
  [[nodiscard]] const firmware::ArmTelemetry& shown() const {
    return board_->controller().telemetry().arm[0];
  }

  static constexpr double kFree_m = 0.002;
  std::unique_ptr<SimBoard> board_;
  Vector3d home_m_, normal_;
};

TEST_P(AnyArm, PressesAgainstAWall) {
  const kinematics::ArmData data = arm_named(GetParam());
  start(data);
  if (HasFatalFailure()) return;
  EXPECT_LT(shown().force_N.norm(), 1e-3F) << "nothing is touched";
  for (double way_m = 0; way_m < 0.008; way_m += 0.05 / 4000) {
    board_->hold(0, home_m_ - way_m * normal_);
    run(*board_, 1.0 / 4000);
  }
  run(*board_, 1);
  ASSERT_EQ(board_->controller().mode(), Mode::kArmed)
      << "fault " << static_cast<int>(board_->controller().fault());
  const Vector3d tip_m = board_->arm(0).tip_m();
  const double depth_m = normal_.dot(home_m_ - tip_m) - kFree_m;
  const Vector3d force_N = shown().force_N.cast<double>();
  const double wall_N = static_cast<double>(kStiffness_N_m) * depth_m;
  figure("true depth in the wall, mm", 1e3 * depth_m, "about 3");
  figure("force, N", force_N.dot(normal_), std::to_string(wall_N));
  EXPECT_GT(depth_m, 0.001);
  // The encoders are at the motors: the cables stretch by up to a third of the depth, which the controller does not see. A probe of the encoders
  // takes a little of the force away, and turns it to where the axes push.
  const double most_N = std::min(wall_N, static_cast<double>(data.max_force_N));
  EXPECT_GT(force_N.dot(normal_), 0.7 * most_N);
  EXPECT_LT(force_N.dot(normal_), 1.02 * most_N);
  EXPECT_LT((force_N - force_N.dot(normal_) * normal_).norm(), 0.1 * most_N)
      << "a plane has no friction here";
  // The hand feels it, but for the friction of the arm and what the file does not know of its weight.
  const double felt_N = board_->arm(0).hand_force_N().dot(normal_);
  figure("what the hand feels, N", felt_N, std::to_string(force_N.dot(normal_)));
  EXPECT_NEAR(felt_N, force_N.dot(normal_), 0.6);
}

// Counts of all axes agree with the plant's true angles, whatever their signs and ratios.
TEST_P(AnyArm, KnowsWhereItIs) {
  start(arm_named(GetParam()));
  if (HasFatalFailure()) return;
  double worst_m = 0;
  for (int i = 0; i < 200; ++i) {
    const double angle = 0.3 * i;
    board_->hold(0, home_m_ + 0.004 * std::sin(angle) * normal_ +
                        0.003 * Vector3d(0, std::cos(angle), std::sin(angle)));
    run(*board_, 0.01);
    worst_m = std::max(worst_m, (shown().tip_m.cast<double>() - board_->sampled_tip_m(0)).norm());
  }
  figure("tip of the controller beside the true one, mm", 1e3 * worst_m, "1");
  EXPECT_LT(worst_m, 1e-3);
  EXPECT_EQ(board_->controller().mode(), Mode::kArmed);
}

INSTANTIATE_TEST_SUITE_P(Files, AnyArm,
                         testing::Values("premium-1.5", "wooden", "touch", "falcon", "pantograph", "paddle",
                                         "chain-7"),
                         test_name);

}  // namespace
}  // namespace thimble::test
