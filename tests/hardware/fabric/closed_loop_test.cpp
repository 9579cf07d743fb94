// The whole board but its processor: the controller, the driver, the bus, the logic, the converters, the amplifiers, the simulated arm and
// the pins of its encoders.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>

#include "board/cortex/fabric.h"
#include "board/cortex/tick.h"
#include "board/sim/plant.h"
#include "board/sim/sim_board.h"
#include "firmware/controller.h"
#include "tests/hardware/fabric/rig.h"
#include "tests/support/scene.h"

namespace thimble::tests {
namespace {

constexpr std::uint64_t kPeriod_us = 250, kPlantStep_us = 25;

// The arm 0 at the pins. Each step of the plant is shown to the encoders' lines in the next one, its counts evenly.
class Arm {
 public:
  explicit Arm(Rig& rig)
      : plant(board::PlantParameters::from(*board::find_plant_variant("premium-1.5")), board::Hand{}),
        rig_(rig) {
    target_ = shown_ = start_ = plant.encoder_counts();
  }

  void clock() {
    const std::uint64_t phase = rig_.now % (kPlantStep_us * kClocks_us);
    if (phase == 0) step();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t all = distance(target_[i], from_[i]);
      const std::int32_t done = static_cast<std::int32_t>(
          (phase + 1) * static_cast<std::uint64_t>(std::abs(all)) / (kPlantStep_us * kClocks_us));
      const std::uint32_t now = from_[i] + static_cast<std::uint32_t>(all < 0 ? -done : done);
      shown_[i] = now & 0xFFFFU;
      const std::uint32_t state = (now - start_[i]) & 3U;  // 00, 10, 11, 01
      const std::uint8_t bit = static_cast<std::uint8_t>(1U << i);
      const bool a = state == 1 || state == 2, b = state >= 2;
      rig_.in.encoder_a = static_cast<std::uint8_t>((rig_.in.encoder_a & ~bit) | (a ? bit : 0));
      rig_.in.encoder_b = static_cast<std::uint8_t>((rig_.in.encoder_b & ~bit) | (b ? bit : 0));
    }
  }

  [[nodiscard]] std::int32_t moved(std::size_t i) const { return distance(shown_[i], start_[i]); }
  [[nodiscard]] bool enabled() const { return (rig_.out.enable & 1) != 0; }
  [[nodiscard]] static std::int32_t distance(std::uint32_t to, std::uint32_t from) {
    return static_cast<std::int16_t>(to - from);
  }

  board::Plant plant;

 private:
  void step() {
    const std::array<std::int16_t, 4>& output = rig_.converter[0].output;
    board::Vector3d current_A(output[0], output[1], output[2]);
    current_A *= 10.0 / 32768;  // 1 V/A
    plant.command_current(current_A, enabled() && rig_.converter[0].power == 0x1F);
    plant.step(kPlantStep_us * 1e-6);
    from_ = target_;
    target_ = plant.encoder_counts();
  }

  Rig& rig_;
  std::array<std::uint32_t, 3> start_{}, from_{}, target_{}, shown_{};
};

TEST(FabricLoop, AWallIsFeltAndAHangTakesTheMotorsOff) {
  Rig rig;
  TrappedPage page(rig);
  const board::Fabric fabric(page.address(), 1);
  Arm arm(rig);
  rig.on_clock = [&] { arm.clock(); };
  board::MemoryStorage storage(65536);
  firmware::Controller controller({.period_s = kPeriod_us * 1e-6F, .board = "fabric"}, storage);
  rig.run(10000 * kClocks_us);  // the start took longer than the watchdog
  fabric.start_watchdog(2000);

  std::uint64_t tick = 0;
  std::int32_t worst = 0;
  const auto run = [&](double seconds) {
    for (const std::uint64_t end = tick + static_cast<std::uint64_t>(seconds * 1e6 / kPeriod_us);
         tick < end;) {
      ++tick;
      controller.keep_alive();
      board::run_tick(fabric, controller, {.tick = tick, .time_us = tick * kPeriod_us}, 0);
      controller.poll(tick * kPeriod_us);
      while (rig.now < tick * kPeriod_us * kClocks_us) rig.run(1);
      rig.write(0x08, 1);
      for (std::uint32_t i = 0; i < 3; ++i)
        worst = std::max(worst, std::abs(Arm::distance(rig.read(0x20 + 4 * i), 0) - arm.moved(i)));
    }
  };

  constexpr double kWall_N_m = 500;
  test::SceneBuilder wall;
  wall.plane({0, 0, 1}, 0, {.stiffness_N_m = static_cast<float>(kWall_N_m)});
  ASSERT_EQ(controller.load_scene(wall.bytes()), firmware::StoreStatus::kOk);
  run(0.01);
  ASSERT_EQ(controller.request(firmware::Command::kHome), 0U);
  run(0.01);
  arm.plant.set_hand_target({0, 0, 0.01}, board::Vector3d::Zero());
  run(0.3);
  ASSERT_EQ(controller.request(firmware::Command::kArm), 0U);
  run(0.25);
  arm.plant.set_hand_target({0, 0, -0.005}, board::Vector3d::Zero());
  run(0.2);
  const firmware::ArmTelemetry& felt = controller.telemetry().arm[0];
  ASSERT_EQ(controller.mode(), firmware::Mode::kArmed);
  ASSERT_TRUE(arm.enabled());
  EXPECT_GT(felt.force_N.z(), 0.5F);
  EXPECT_NEAR(static_cast<double>(felt.force_N.z()), -kWall_N_m * static_cast<double>(felt.tip_m.z()), 0.02);
  // What the hand feels is what was commanded: force of the arm on the hand, in equilibrium.
  EXPECT_NEAR(arm.plant.hand_force_N().z(), static_cast<double>(felt.force_N.z()), 0.15);
  EXPECT_LE(worst, 1) << "counts on their way through the filter";

  rig.run(2000 * kClocks_us);  // the tick hangs
  EXPECT_FALSE(arm.enabled());
  rig.run(1000 * kClocks_us);
  for (const board::Motor& motor : arm.plant.motors()) EXPECT_NEAR(motor.current_A, 0, 1e-3);
  tick += 12;
  run(0.001);
  EXPECT_EQ(controller.mode(), firmware::Mode::kFaulted);
  EXPECT_FALSE(arm.enabled());
  EXPECT_EQ(rig.bus_errors, 0U);
  EXPECT_EQ(rig.converter[0].violations, 0U);
}

}  // namespace
}  // namespace thimble::tests
