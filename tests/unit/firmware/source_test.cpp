// A force source that exists in this test only: a spring that pulls each tip to a point. It comes in as a row of Config::sources, and
// everything behind a source is as for the others: arming, ramp, clamp, slew limit, motor limits, telemetry, supervision.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <limits>
#include <memory>

#include "firmware/sources/force_source.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

// The whole of a new source.
class PointSpring final : public firmware::ForceSource {
 public:
  explicit PointSpring(bool needs_host = false) noexcept
      : ForceSource(
            {.name = "point_spring", .host = needs_host, .host_timeout_s = needs_host ? 0.1F : 0.0F}) {}

  bool wanted(const firmware::Params&) const noexcept override { return on; }
  void start(const firmware::SourceTick&) noexcept override { ++starts; }
  void forces(const firmware::SourceTick& tick, firmware::SourceForces& out) noexcept override {
    for (std::size_t i = 0; i < tick.arms.size(); ++i)
      out.arms[i] = {stiffness_N_m * (point_m - tick.arms[i].posture.tip_m), point_m, 0};
  }

  bool on = true;
  Vec3 point_m = Vec3::Zero();
  float stiffness_N_m = 200.0F;
  int starts = 0;
};

struct Rig {
  explicit Rig(bool needs_host = false) : spring(needs_host), row{&spring} {
    firmware::Config config;
    config.sources = row;
    bench = std::make_unique<Bench>(config);
  }
  PointSpring spring;
  std::array<firmware::ForceSource*, 1> row;
  std::unique_ptr<Bench> bench;
};

void write(Bench& bench, const char* name, float value) {
  const firmware::ParamRow* row = firmware::find_param(name);
  ASSERT_NE(row, nullptr) << name;
  ASSERT_EQ(bench.controller->write_param(row->id, std::bit_cast<std::uint32_t>(value)),
            firmware::ParamStatus::kOk);
}

TEST(OwnSource, ArmsWithoutASceneAndPullsToItsPoint) {
  Rig rig;
  Bench& bench = *rig.bench;
  bench.home();
  EXPECT_EQ(bench.controller->unmet(), 0U) << "a source that needs no scene arms without one";
  bench.move({0.01, 0, 0}, 100);
  bench.arm();
  EXPECT_EQ(rig.spring.starts, 1);
  EXPECT_LT(bench.force_N(), 0.01F) << "the ramp begins at zero";
  bench.ticks(400);  // half of 0.2 s
  EXPECT_NEAR(bench.shown().arm[0].force_N.x(), -1.0F, 0.02F);
  bench.ticks(500);
  const auto& arm = bench.shown().arm[0];
  EXPECT_NEAR(arm.force_N.x(), -2.0F, 0.02F);
  EXPECT_EQ(arm.rendered_N, arm.force_N) << "telemetry shows what the source asked for";
  EXPECT_EQ(arm.god_object_m, rig.spring.point_m) << "and the point that it shows";
  EXPECT_EQ(arm.limiters, 0);
  EXPECT_TRUE(any_current(bench.outputs));
}

TEST(OwnSource, IsClampedAndSlewLimitedAsAnyOther) {
  Rig rig;
  Bench& bench = *rig.bench;
  write(bench, "max_force", 3.0F);
  write(bench, "force_slew", 1000.0F);  // 0.25 N a tick
  bench.home();
  bench.arm();
  bench.ticks(1000);
  rig.spring.point_m = {0, 0.1F, 0};  // 20 N from one tick to the next
  float worst_step_N = 0, highest_N = 0;
  unsigned limiters = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3 last_N = bench.shown().arm[0].force_N;
    bench.tick();
    const auto& arm = bench.shown().arm[0];
    worst_step_N = std::max(worst_step_N, (arm.force_N - last_N).norm());
    highest_N = std::max(highest_N, arm.force_N.norm());
    limiters |= arm.limiters;
  }
  std::printf("steps of at most %.4f N, at most %.4f N\n", static_cast<double>(worst_step_N),
              static_cast<double>(highest_N));
  EXPECT_NEAR(worst_step_N, 0.25F, 1e-4F);
  EXPECT_NEAR(highest_N, 3.0F, 1e-4F);
  EXPECT_NE(limiters & firmware::kLimitClamp, 0U);
  EXPECT_NE(limiters & firmware::kLimitSlew, 0U);
}

TEST(OwnSource, AForceThatIsNotFiniteTrips) {
  Rig rig;
  Bench& bench = *rig.bench;
  bench.home();
  bench.arm();
  bench.ticks(100);
  rig.spring.stiffness_N_m = std::numeric_limits<float>::infinity();
  bench.tick();
  EXPECT_EQ(bench.controller->fault(), Fault::force_not_finite);
  EXPECT_EQ(bench.mode(), Mode::kDamping);
}

TEST(OwnSource, GivesWayToTheSceneAtTheNextArming) {
  Rig rig;
  Bench& bench = *rig.bench;
  bench.load(1000.0F, -1.0F);
  bench.home();
  bench.arm();
  rig.spring.on = false;
  rig.spring.point_m = {0, 0, 0.005F};
  bench.ticks(900);
  EXPECT_NEAR(bench.force_N(), 1.0F, 0.02F) << "what was chosen at arming stays";
  EXPECT_EQ(bench.controller->request(Command::kDisarm), 0U);
  bench.ticks(1100);
  bench.arm();
  bench.ticks(900);
  EXPECT_EQ(bench.force_N(), 0.0F) << "now it is the scene, and nothing touches";
}

TEST(OwnSource, MayNeedALiveHostOfItsOwn) {
  Rig rig(true);
  Bench& bench = *rig.bench;
  bench.home();
  bench.arm();
  bench.ticks(1000);
  ASSERT_EQ(bench.mode(), Mode::kArmed);
  bench.alive = false;
  int ticks = 0;
  while (bench.controller->fault() == Fault::kNone && ticks < 4000) {
    bench.tick();
    ++ticks;
  }
  EXPECT_EQ(bench.controller->fault(), Fault::host_lost);
  EXPECT_NEAR(ticks, 401, 1) << "0.1 s";
}

// A second arm has the same source.
TEST(OwnSource, LeadsEveryArm) {
  PointSpring spring;
  const std::array<firmware::ForceSource*, 1> row = {&spring};
  firmware::Config config;
  config.arm_count = 2;
  config.arm[1].base.home_m = {0.3F, 0, 0};
  config.sources = row;
  Bench bench(config);
  spring.point_m = {0.15F, 0, 0};
  spring.stiffness_N_m = 10.0F;
  bench.home();
  bench.arm();
  bench.ticks(1000);
  EXPECT_NEAR(bench.shown().arm[0].force_N.x(), 1.5F, 0.02F);
  EXPECT_NEAR(bench.shown().arm[1].force_N.x(), -1.5F, 0.02F);
}

}  // namespace
}  // namespace thimble::test
