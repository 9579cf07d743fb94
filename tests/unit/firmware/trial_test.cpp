// The parameter `trial`: the force fields of the scene switch in the next tick, while the arm is armed.
#include <gtest/gtest.h>

#include <bit>

#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/trials_scene.h"

namespace thimble::test {
namespace {

void set_param(Bench& bench, const char* name, std::uint32_t bits) {
  ASSERT_EQ(bench.controller->write_param(firmware::find_param(name)->id, bits), firmware::ParamStatus::kOk)
      << name;
}

TEST(Trial, ChangesTheForceInTheNextTickWhileArmed) {
  Bench bench;
  ASSERT_EQ(bench.controller->load_scene(trials_image()), firmware::StoreStatus::kOk);
  bench.home();
  set_param(bench, "allow_uncommissioned", 1);
  bench.arm();
  bench.ticks(8000);  // the ramp
  const auto force_after_a_tick = [&](std::uint32_t trial) {
    set_param(bench, "trial", trial);
    bench.tick();
    return bench.shown().arm[0].force_N;
  };
  constexpr float kExact = 1e-5F;
  for (int round = 0; round < 50; ++round) {
    EXPECT_TRUE(force_after_a_tick(1).isApprox(Vec3(2, 0, 1), kExact))
        << bench.shown().arm[0].force_N.transpose();
    EXPECT_TRUE(force_after_a_tick(0).isApprox(Vec3(0, 0, 1), kExact));
    EXPECT_TRUE(force_after_a_tick(2).isApprox(Vec3(0, -2, 1), kExact));
    EXPECT_TRUE(force_after_a_tick(200).isApprox(Vec3(0, 0, 1), kExact));
  }
  // A step of 5 N is more than force_slew lets through in a tick by default, and less than it can be set to.
  EXPECT_FALSE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  bench.tick();
  EXPECT_TRUE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  EXPECT_TRUE(force_after_a_tick(0).isApprox(Vec3(0, 0, 1), kExact));
  set_param(bench, "force_slew", std::bit_cast<std::uint32_t>(firmware::find_param("force_slew")->max));
  EXPECT_TRUE(force_after_a_tick(3).isApprox(Vec3(0, 0, 6), kExact));
  EXPECT_EQ(bench.mode(), Mode::kArmed);
}

}  // namespace
}  // namespace thimble::test
