// The commissioning of an arm on drives on CAN, which are late, have to be switched on, and tell their currents rarely. With THIMBLE_COMMISSION_ARMS
// it goes to the end, with other true figures of the arm and other drives, too.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/drives/emulated_odrive.h"
#include "host-tools/commission/link_bench.h"
#include "host-tools/commission/planted.h"
#include "host-tools/commission/procedure.h"
#include "tests/closed_loop/commission/driven_bench.h"

namespace thimble::test {
namespace {

using host::ArmFault;

std::string example(const std::string& file) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "docs/examples/five-bar" / file);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Of the example, with two drives of another kind.
std::string board_with(const std::string& kind) {
  const std::string mit =
      R"("damping_N_m_s_rad": 0.0005, "reply_id": 16, "ranges": { "position_rad": 12.5, "torque_N_m": 1, "velocity_rad_s": )";
  const std::map<std::string, std::string> rest{
      {"odrive_0.6", R"("watchdog_ms": 15, "current_limit_A": 10, "estimates_ms": 1, "configuration": [
        { "name": "axis0.config.enable_watchdog", "number": 100, "integer": true, "value": 1 },
        { "name": "axis0.config.watchdog_timeout", "number": 101, "value": 0.015 }] })"},
      {"moteus", R"("watchdog_ms": 15, "damping_N_m_s_rad": 0.0005, "kd_N_m_s_turn": 0.25 })"},
      {"damiao", R"("watchdog_ms": 15, )" + mit + "30 } }"},
      {"mini_cheetah", R"("watchdog_ms": 25, "watchdog_proven": true, )" + mit + "65 } }"}};
  std::string drives;
  for (int id = 1; id <= 2; ++id) {
    std::string one = fmt::format(
        R"({{ "can": "can1", "kind": "{}", "id": {}, "peak_torque_N_m": 0.32, "top_speed_rad_s": {}, {})",
        kind, id, kind == "damiao" ? 28 : 60, rest.at(kind));
    if (const std::size_t reply = one.find("\"reply_id\": 16"); reply != std::string::npos)
      one.replace(reply, 14, fmt::format("\"reply_id\": {}", 16 + id));
    drives += (id == 2 ? ", " : "") + one;
  }
  std::string board = example("board.json");
  const std::size_t begin = board.find('[', board.find("\"drives\"")) + 1;
  return board.replace(begin, board.find("\n      ]", begin) - begin, drives);
}

// Steps up to `last`; a fault that is named is mended. Each step has a connection of its own.
void commission(std::uint64_t seed, int last, const std::string& board, bool wired_backwards = true) {
  const std::string text = example("five-bar-odrive.arm.json");
  const host::ArmFile arm = host::read_arm_file(text, "five-bar");
  std::vector<host::SimFault> faults;
  if (wired_backwards) faults.push_back(host::planted_fault("motor-sign@first", arm));
  DrivenBench bench(arm, std::move(faults), {.seed = seed}, board);
  host::Commission commission(text, "five-bar", "test");
  while (commission.next() <= last) {
    const int step = commission.next();
    host::LinkBench link([&] { return bench.open(); }, bench, 0, commission.arm());
    link.begin_step(step);
    const double began_s = bench.time_s();
    const host::StepResult& result = commission.run(step, link);
    std::printf("step %2d: %6.1f s, at most %.2f N and %.3f m/s\n", step, bench.time_s() - began_s,
                bench.most_tip_force_N(), bench.most_tip_speed_m_s());
    if (step < 7) {
      EXPECT_LE(bench.most_tip_force_N(), host::kTipForce_N);
      EXPECT_LE(bench.most_tip_speed_m_s(), host::kTipSpeed_m_s);
    }
    if (result.passed) continue;
    ASSERT_EQ(step, 5) << result.findings.at(0).text;
    ASSERT_EQ(bench.faults().size(), 1U) << "it is mended";
    EXPECT_EQ(result.findings.at(0).fault, ArmFault::kMotorSign);
    bench.mend(0);
  }
  EXPECT_TRUE(bench.faults().empty());
}

TEST(DrivenCommission, AFiveBarWithAMotorWiredBackwards) {
  if (std::getenv("THIMBLE_COMMISSION_ARMS") == nullptr) return commission(1, 6, example("board.json"));
  commission(1, 10, example("board.json"),
             false);  // a wall of step 10 swings so that a probe once found a dead encoder
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) commission(seed, 10, example("board.json"));
  for (const char* kind : {"odrive_0.6", "moteus", "damiao", "mini_cheetah"}) {
    SCOPED_TRACE(kind);
    commission(1, 10, board_with(kind));
  }
}

// Not as counts that are missing, which is what its end of the recording looks like.
TEST(DrivenCommission, ADriveThatStaysOffIsAFault) {
  const std::string text = example("five-bar-odrive.arm.json");
  const host::ArmFile arm = host::read_arm_file(text, "five-bar");
  DrivenBench bench(arm, {}, {}, example("board.json"));
  host::Commission commission(text, "five-bar", "test");
  host::LinkBench link([&] { return bench.open(); }, bench, 0, arm);
  link.begin_step(0);
  ASSERT_TRUE(commission.run(0, link).passed);
  dynamic_cast<board::emulated::EmulatedOdrive&>(bench.drive(1)).stays_off = true;
  link.begin_step(1);
  try {
    static_cast<void>(commission.run(1, link));
    FAIL();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "device-faulted") << error.cause;
  }
}

}  // namespace
}  // namespace thimble::test
