// The force on a hand through the firmware core and the simulated arm.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "board/sim/sim_board.h"
#include "host-tools/sweep/wall_press.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/figure.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::SimBoard;
using board::Vector3d;

// Homed and armed, in free space unless image says otherwise, the ramp done.
void arm(SimBoard& board, std::span<const std::byte> image) {
  firmware::Controller& controller = board.controller();
  ASSERT_EQ(controller.load_scene(image), firmware::StoreStatus::kOk);
  controller.keep_alive();
  board.tick();
  ASSERT_EQ(controller.request(firmware::Command::kHome), 0);
  board.step(.1);
  ASSERT_EQ(controller.mode(), firmware::Mode::kReady);
  controller.keep_alive();
  ASSERT_EQ(controller.request(firmware::Command::kArm), 0);
  board.step(.5);
  ASSERT_EQ(controller.mode(), firmware::Mode::kArmed);
}

std::vector<std::byte> free_space() {  // a floor far below the arm's reach
  SceneBuilder scene;
  scene.plane({0, 0, 1}, -1.0, {});
  return scene.bytes();
}

// A move of 60 mm at 0.1 m/s along each axis, there and back; the ends of it, where the hand accelerates,
// left out. Returns the largest force that the arm exerts on the hand.
double felt_while_moving(const char* variant) {
  double most_N = 0;
  for (const Vector3d& axis :
       {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(1, 1, 1).normalized()}) {
    SimBoard board({.variant = variant});
    arm(board, free_space());
    board.follow(0, board::HandPath({{0, -.03 * axis},
                                     {.2, -.03 * axis},
                                     {.8, .03 * axis},
                                     {1, .03 * axis},
                                     {1.6, -.03 * axis},
                                     {2, -.03 * axis}}));
    while (!board.hand_follows(0)) board.tick();
    const double begin_s = board.time_s();
    double axis_N = 0;
    while (board.time_s() < begin_s + 2) {
      board.tick();
      const double t = board.time_s() - begin_s;
      if ((t > .4 && t < .78) || (t > 1.2 && t < 1.58))
        axis_N = std::max(axis_N, board.plant(0).hand_force_N().norm());
    }
    EXPECT_EQ(board.controller().mode(), firmware::Mode::kArmed);
    std::printf("%s along (%.2f %.2f %.2f): at most %.4f N on the hand\n", variant, axis.x(), axis.y(),
                axis.z(), axis_N);
    most_N = std::max(most_N, axis_N);
  }
  return most_N;
}

TEST(Loop, AFreeMoveIsFeltBelowATenthOfANewton) {
  const double without_friction = felt_while_moving("premium-1.5-frictionless");
  const double with_friction = felt_while_moving("premium-1.5");
  figure("free move at 0.1 m/s, device friction apart, N", without_friction, "< 0.1");
  figure("the same with the device's own friction, N", with_friction, "reported");
  EXPECT_LT(without_friction, .1);
  EXPECT_LT(with_friction,
            .25);  // Coulomb and viscous of three joints at once: .016 N m each over .17 m, and the rest
}

TEST(Loop, AWallHoldsAPressAtEightyPercentOfPeak) {
  // Upwards at home the Premium gives 6.72 N at most.
  const kinematics::ArmData model = kinematics::built_in_arm("premium-1.5");
  const kinematics::AxisData& axis = model.axis[1];
  const double peak_N =
      static_cast<double>(axis.torque_per_ampere() * axis.motor.peak_current_A /
                          std::get<kinematics::TwoLinkGeometry>(model.geometry.platform).upper_link_m);
  for (const char* variant : {"premium-1.5", "premium-1.5-frictionless"}) {
    for (const board::Hand& hand : {board::Hand{}, board::Hand{.01, 150, 1}}) {
      const host::Measured r = host::measure(host::WallPress{
          .arm = variant, .force_N = .8 * peak_N, .approach_m_s = .05, .hold_s = 4, .hand = hand});
      std::printf("%s, hand of %.0f g and %.0f N/m:\n", variant, 1e3 * hand.mass_kg, hand.stiffness_N_m);
      ASSERT_TRUE(r.is_ok());
      figure("mean force over the last 2 s of a press at 80 % of peak, N", r.steady_force_N,
             std::to_string(.8 * peak_N));
      figure("tip swing, um", 1e6 * r.tip_swing_m, "<= 59, two counts");
      figure("tip speed, RMS, mm/s", 1e3 * r.tip_speed_rms_m_s, "<= 1");
      EXPECT_NEAR(r.steady_force_N, .8 * peak_N, .02 * peak_N);
      EXPECT_LE(r.tip_swing_m, 59e-6);
      EXPECT_LE(r.tip_speed_rms_m_s, 1e-3);
    }
  }
}

// The oracle of the tests above: they must be able to see a limit cycle.
TEST(Loop, ATooStiffWallSwings) {
  const host::Measured r =
      host::measure(host::WallPress{.rate_Hz = 1000, .stiffness_N_m = 10000, .damping_N_s_m = 5});
  figure("tip swing of 10 kN/m and 5 Ns/m at 1 kHz, um", 1e6 * r.tip_swing_m, "> 59");
  EXPECT_TRUE(!r.is_ok() || r.tip_swing_m > 59e-6);
}

TEST(Loop, GravityIsCarried) {
  // Armed, no hand: the arm stays where it is let go.
  SimBoard board({.variant = "premium-1.5-frictionless"});
  arm(board, free_space());
  board.plant(0).set_hand(board::kNoHand);
  const Vector3d before = board.plant(0).tip_m();
  board.step(.3);
  const double fell = (board.plant(0).tip_m() - before).norm();
  figure("a frictionless arm let go moves in 0.3 s, mm", 1e3 * fell, "< 1");
  EXPECT_LT(fell, 1e-3);
}

TEST(Loop, HomingFindsTheTipWithinACount) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SimBoard board({.variant = "premium-1.5", .seed = seed});
    arm(board, free_space());
    const double error =
        (board.sampled_tip_m(0) - board.controller().telemetry().arm[0].tip_m.cast<double>()).norm();
    // A count a joint, and the cables' stretch under the weight that friction leaves.
    EXPECT_LT(error, 1e-4) << seed;
  }
}

TEST(Loop, DisarmedMotorsAreOff) {
  SimBoard board;
  arm(board, free_space());
  ASSERT_EQ(board.controller().request(firmware::Command::kDisarm), 0);
  board.step(1.0);
  EXPECT_EQ(board.controller().mode(), firmware::Mode::kReady);
  for (const board::Motor& motor : board.plant(0).motors()) EXPECT_EQ(motor.current_A, 0);
}

TEST(Loop, EStopStopsTheSimulatedArm) {
  SimBoard board;
  arm(board, free_space());
  board.set_e_stop(true);
  board.step(1.0);
  EXPECT_EQ(board.controller().fault(), firmware::Fault::e_stop);
  for (const board::Motor& motor : board.plant(0).motors()) EXPECT_EQ(motor.current_A, 0);
}

TEST(Loop, ALoopedPathBeginsAgain) {
  SimBoard board;
  arm(board, free_space());
  board.follow(0, board::HandPath({{0, {0, 0, 0}}, {.2, {.02, 0, 0}}}), true);
  int begun = 0;
  bool before = false;
  for (int k = 0; k < 4 * 4000; ++k) {
    board.tick();
    begun += board.hand_follows(0) && !before ? 1 : 0;
    before = board.hand_follows(0);
  }
  EXPECT_GE(begun, 4);
}

}  // namespace
}  // namespace thimble::test
