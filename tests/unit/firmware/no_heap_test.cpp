// The tick uses no heap: armed and in contact, through a scene swap, a trip, damping and a clear, and while a recording runs, with two
// arms.
#include <gtest/gtest.h>

#include <cstdio>
#include <vector>

#include "tests/support/no_heap_guard.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

TEST(NoHeapDeathTest, TheGuardBites) {
  EXPECT_DEATH(
      {
        const NoHeapGuard guard;
        std::vector<int>* volatile leak = new std::vector<int>(100);
        (void)leak;
      },
      "heap was used");
}

TEST(NoHeap, InTheTick) {
  firmware::Config config;
  config.arm_count = 2;
  Bench bench(config);
  bench.start();
  bench.move({0, 0, 0.002}, 100, 0);
  bench.move({0, 0, 0.002}, 100, 1);
  int contacts = 0, modes = 0;
  const std::vector<std::byte> other = plane_image(2000.0F, 0.001F);
  for (int i = 0; i < 20000; ++i) {
    bench.place({0.005 * std::sin(i * 1e-3), 0, -0.003 * std::sin(i * 2e-3)}, 0);
    bench.place({0, 0.005 * std::sin(i * 1e-3), 0.002 * std::sin(i * 3e-3)}, 1);
    if (i == 5000) {
      ASSERT_EQ(bench.controller->load_scene(other), firmware::StoreStatus::kOk);
    }
    if (i == 12000) (void)bench.controller->request(Command::kStop);
    if (i == 14000) (void)bench.controller->request(Command::kClear);
    if (i == 14005) (void)bench.controller->request(Command::kRecord);
    if (i == 14010) (void)bench.controller->request(Command::kArm);
    {
      const NoHeapGuard guard;
      bench.tick();
    }
    contacts += bench.shown().arm[0].contacts + bench.shown().arm[1].contacts;
    modes |= 1 << static_cast<int>(bench.mode());
  }
  std::printf("20000 ticks under the guard, %d contacts, modes seen 0x%x\n", contacts,
              static_cast<unsigned>(modes));
  EXPECT_GT(contacts, 5000);
  EXPECT_EQ(bench.controller->recording_state().ticks, 20000U - 14006U) << "the recording ran to the end";
  EXPECT_EQ(modes, 1 << static_cast<int>(Mode::kArmed) | 1 << static_cast<int>(Mode::kDamping) |
                       1 << static_cast<int>(Mode::kFaulted) | 1 << static_cast<int>(Mode::kReady));
}

// An order for the axes that follows a place and gives a tone, and the hold after it.
TEST(NoHeap, WhereAHostDrivesTheAxes) {
  Bench bench;
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("allow_moves")->id, 1),
            firmware::ParamStatus::kOk);
  bench.load(1000.0F, -0.01F);
  bench.home();
  bench.arm();
  bench.ticks(900);
  firmware::link::AxisOrder order;
  order.hold = true;
  order.driven_s = 0.2F;
  order.move_s = 0.1F;
  order.amplitude_N_m = 0.02F;
  order.frequency_Hz = 100.0F;
  order.most_energy_J = 1.0F;
  order.stiffness_N_m_rad.fill(0.1F);
  order.damping_N_m_s_rad.fill(0.01F);
  order.most_torque_N_m.fill(0.1F);
  order.most_way_rad.fill(1.0F);
  order.most_speed_rad_s.fill(10.0F);
  for (std::size_t j = 0; j < 3; ++j)
    order.to_rad[j] = bench.shown().arm[0].joint_rad[static_cast<int>(j)] + 0.05F;
  int currents = 0;
  for (int i = 0; i < 2000; ++i) {
    const NoHeapGuard guard;
    if (i == 0) {
      ASSERT_EQ(bench.controller->request_axes(order), 0);
    }
    bench.tick();
    if (any_current(bench.outputs)) ++currents;
  }
  EXPECT_EQ(currents, 2000);
  EXPECT_EQ(bench.controller->axis_state().phase, firmware::link::AxisPhase::kHolding);
}

TEST(NoHeap, WhereTheHostRenders) {
  Bench bench;
  ASSERT_EQ(bench.controller->write_param(firmware::find_param("host_forces")->id, 1),
            firmware::ParamStatus::kOk);
  bench.home();
  bench.arm();
  std::uint8_t sequence = 0;
  for (int i = 0; i < 4000; ++i) {
    const NoHeapGuard guard;
    if (i % 500 < 300) {
      firmware::link::ForceOrder order;
      order.z_N = 1.0F;
      order.sequence = ++sequence;
      bench.controller->on_frame(firmware::link::to_frame(order, 1), bench.inputs.time_us);
    }
    bench.tick();
  }
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

}  // namespace
}  // namespace thimble::test
