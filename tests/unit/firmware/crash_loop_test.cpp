// Crashes set a scene or parameters aside, and damage in the store is said.
#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <memory>
#include <string>

#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

std::unique_ptr<Bench> with_scene() {
  auto bench = std::make_unique<Bench>(firmware::Config{.period_s = 1e-3F});
  bench->load(4000);
  bench->ticks(2);
  return bench;
}

std::string set_aside(Bench& bench) { return Tester(bench).text(link::kDidSetAside); }

bool runs_scene(Bench& bench) {
  bench.ticks(3);
  return (bench.controller->unmet() & firmware::kNoScene) == 0;
}

void write_param(Bench& bench, firmware::Param param, float value) {
  ASSERT_EQ(bench.controller->write_param(firmware::row_of(param).id, std::bit_cast<std::uint32_t>(value)),
            firmware::ParamStatus::kOk);
}
float param(const Bench& bench, firmware::Param param) {
  std::uint32_t bits = 0;
  EXPECT_EQ(bench.controller->read_param(firmware::row_of(param).id, bits), firmware::ParamStatus::kOk);
  return std::bit_cast<float>(bits);
}

TEST(CrashLoop, AfterThreeCrashesTheFourthStartIsWithoutTheScene) {
  for (const char* reason : {"crash", "watchdog"}) {
    const auto bench = with_scene();
    for (int i = 0; i < 2; ++i) {
      bench->restart(reason);
      EXPECT_TRUE(runs_scene(*bench)) << i;
      EXPECT_EQ(bench->controller->fault(), Fault::watchdog_reset);
      EXPECT_EQ(set_aside(*bench), "");
    }
    bench->restart(reason);
    EXPECT_FALSE(runs_scene(*bench));
    EXPECT_EQ(bench->controller->fault(), Fault::set_aside);
    EXPECT_EQ(set_aside(*bench), "scene");
    EXPECT_EQ(Tester(*bench).text(link::kDidSceneName), "");
    // It stays so, until a scene is uploaded.
    bench->restart("power_on");
    EXPECT_FALSE(runs_scene(*bench));
    EXPECT_EQ(bench->controller->fault(), Fault::set_aside);
    bench->load(4000);
    EXPECT_TRUE(runs_scene(*bench));
    EXPECT_EQ(set_aside(*bench), "");
    bench->restart("power_on");
    EXPECT_TRUE(runs_scene(*bench));
    EXPECT_EQ(bench->controller->fault(), Fault::kNone);
  }
}

TEST(CrashLoop, TwoCrashesAndACleanHourDoNotCount) {
  const auto bench = with_scene();
  for (int round = 0; round < 3; ++round) {
    bench->restart("crash");
    bench->ticks(1000);
    bench->restart("crash");
    bench->ticks(3600 * 1000);
    ASSERT_TRUE(runs_scene(*bench)) << round;
  }
  // A crash after the hour is the first one.
  for (int i = 0; i < 3; ++i) {
    bench->restart("crash");
    ASSERT_TRUE(runs_scene(*bench)) << i;
  }
  bench->restart("crash");
  EXPECT_FALSE(runs_scene(*bench));
}

TEST(CrashLoop, AnOrdinaryStartEndsTheRow) {
  const auto bench = with_scene();
  for (int i = 0; i < 6; ++i) {
    bench->restart(i % 3 == 2 ? "power_on" : "crash");
    EXPECT_TRUE(runs_scene(*bench)) << i;
  }
}

TEST(CrashLoop, AnotherSceneStartsTheCountAnew) {
  const auto bench = with_scene();
  bench->restart("crash");
  bench->restart("crash");
  bench->ticks(3);
  bench->load(3000);
  bench->ticks(3);
  for (int i = 0; i < 2; ++i) {
    bench->restart("crash");
    EXPECT_TRUE(runs_scene(*bench)) << i;
  }
  bench->restart("crash");
  EXPECT_FALSE(runs_scene(*bench));
}

// A scene that crashes the board in its first tick: no poll comes.
TEST(CrashLoop, CountsStartsWithoutATick) {
  const auto bench = with_scene();
  for (int i = 0; i < 3; ++i) bench->restart("crash");
  EXPECT_FALSE(runs_scene(*bench));
}

// The scene has run well for long; the parameters were saved a moment ago.
TEST(CrashLoop, LeavesOutWhatIsNew) {
  const auto bench = with_scene();
  write_param(*bench, firmware::Param::stop_time, 0.2F);
  ASSERT_EQ(bench->controller->save_params(), firmware::StoreStatus::kOk);
  bench->ticks(601 * 1000);
  write_param(*bench, firmware::Param::stop_time, 0.1F);
  ASSERT_EQ(bench->controller->save_params(), firmware::StoreStatus::kOk);
  bench->ticks(3);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(param(*bench, firmware::Param::stop_time), 0.1F);
    bench->restart("watchdog");
  }
  EXPECT_TRUE(runs_scene(*bench));
  EXPECT_EQ(param(*bench, firmware::Param::stop_time), 0.25F);
  EXPECT_EQ(set_aside(*bench), "parameters");
  // Saved again, they are taken into use.
  write_param(*bench, firmware::Param::stop_time, 0.15F);
  ASSERT_EQ(bench->controller->save_params(), firmware::StoreStatus::kOk);
  bench->ticks(3);
  EXPECT_EQ(set_aside(*bench), "");
  bench->restart("power_on");
  EXPECT_EQ(param(*bench, firmware::Param::stop_time), 0.15F);
}

// Nothing is new: the scene first, then the parameters.
TEST(CrashLoop, LeavesOutTheSceneBeforeTheParametersWhereBothHaveRunForLong) {
  const auto bench = with_scene();
  write_param(*bench, firmware::Param::stop_time, 0.2F);
  ASSERT_EQ(bench->controller->save_params(), firmware::StoreStatus::kOk);
  bench->ticks(601 * 1000);
  bench->restart("power_on");
  for (int i = 0; i < 3; ++i) bench->restart("crash");
  EXPECT_EQ(set_aside(*bench), "scene");
  EXPECT_EQ(param(*bench, firmware::Param::stop_time), 0.2F);
  for (int i = 0; i < 3; ++i) bench->restart("crash");
  EXPECT_EQ(set_aside(*bench), "scene,parameters");
  EXPECT_EQ(param(*bench, firmware::Param::stop_time), 0.25F);
  bench->restart("crash");
  EXPECT_EQ(set_aside(*bench), "scene,parameters");
}

// --- Damage

TEST(StoreCorrupt, IsSaidOfTheNewestContentsAndNotOfAnInterruptedSave) {
  for (const unsigned slot : {0U, 2U}) {
    const auto bench = with_scene();
    ASSERT_EQ(bench->controller->save_params(), firmware::StoreStatus::kOk);
    bench->restart("power_on");
    EXPECT_EQ(bench->controller->fault(), Fault::kNone);
    bench->storage.at(slot, 8) ^= std::byte{4};  // in the header
    bench->restart("power_on");
    EXPECT_EQ(bench->controller->fault(), Fault::store_corrupt) << slot;
  }
  // Power fails in an upload, and in the erase before it.
  for (const std::size_t power : {std::size_t{100}, std::size_t{300}, std::size_t{500}, std::size_t{900}}) {
    const auto bench = with_scene();
    bench->load(3000);
    bench->storage.power_left = power;
    EXPECT_NE(bench->controller->load_scene(plane_image(2000)), firmware::StoreStatus::kOk);
    bench->storage.power_left = std::numeric_limits<std::size_t>::max();
    bench->restart("power_on");
    EXPECT_EQ(bench->controller->fault(), Fault::kNone) << power;
    EXPECT_TRUE(runs_scene(*bench));
  }
}

}  // namespace
}  // namespace thimble::test
