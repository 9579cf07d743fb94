// The smallest board (board/README.md) on simulated hardware: its listing is compiled as printed.
#include <gtest/gtest.h>

#include "board/sim/plant.h"
#include "board/sim/sim_board.h"
#include "listing.h"  // NOLINT(misc-include-cleaner): made of board/README.md
#include "tests/support/scene.h"

namespace {

std::uint64_t time_us = 0;
int fed = 0, frames = 0;
board::Plant& plant() {
  static board::Plant it(board::PlantParameters::from(*board::find_plant_variant("premium-1.5")),
                         board::Hand{});
  return it;
}

}  // namespace

std::uint64_t hardware::now_us() { return time_us; }
std::uint32_t hardware::counter(std::size_t joint) { return plant().encoder_counts()[joint]; }
bool hardware::e_stop_pressed() { return false; }
bool hardware::dead_man_held() { return true; }
void hardware::set_drives(const firmware::ArmOutputs& drive) {
  plant().command_current(
      Eigen::Vector3f(drive.current_A[0], drive.current_A[1], drive.current_A[2]).cast<double>(),
      drive.enable);
}
bool hardware::receive(firmware::link::CanFrame&) { return false; }
bool hardware::send(const firmware::link::CanFrame&) { return ++frames != 0; }
void hardware::feed_watchdog() { ++fed; }
void hardware::restart() { FAIL() << "nobody asked for it"; }
firmware::Storage& hardware::storage() {
  static board::MemoryStorage it(65536);
  return it;
}

namespace {

void run(double seconds) {
  for (int tick = 0; tick < static_cast<int>(seconds / 2.5e-4); ++tick) {
    time_us += 250;
    controller.keep_alive();
    on_tick();
    background();
    plant().step(2.5e-4);
  }
}

TEST(PortingGuide, TheSmallestBoardWorks) {
  constexpr double kWall_N_m = 500;
  test::SceneBuilder wall;
  wall.plane({0, 0, 1}, 0, {.stiffness_N_m = static_cast<float>(kWall_N_m)});
  ASSERT_EQ(controller.load_scene(wall.bytes()), firmware::StoreStatus::kOk);
  run(0.01);
  ASSERT_EQ(controller.request(firmware::Command::kHome), 0U);
  run(0.01);
  plant().set_hand_target({0, 0, 0.01}, board::Vector3d::Zero());
  run(0.5);
  ASSERT_EQ(controller.request(firmware::Command::kArm), 0U);
  run(0.5);
  plant().set_hand_target({0, 0, -0.005}, board::Vector3d::Zero());
  run(0.2);  // a hand that holds still for longer feels a probe of the encoders
  const firmware::ArmTelemetry& felt = controller.telemetry().arm[0];
  ASSERT_EQ(controller.mode(), firmware::Mode::kArmed);
  EXPECT_GT(felt.force_N.z(), 0.5F);
  EXPECT_NEAR(static_cast<double>(felt.force_N.z()), -kWall_N_m * static_cast<double>(felt.tip_m.z()), 0.02);
  EXPECT_GT(fed, 1000);
  EXPECT_GT(frames, 100);
}

}  // namespace
