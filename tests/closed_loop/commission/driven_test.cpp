// The commissioning of an arm on drives on CAN, which are late, have to be switched on, and tell their currents rarely. With THIMBLE_COMMISSION_ARMS
// it goes to the end, with other true figures of the arm, too.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

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

// Steps up to `last`; a fault that is named is mended. Each step has a connection of its own.
void commission(std::uint64_t seed, int last) {
  const std::string text = example("five-bar-odrive.arm.json");
  const host::ArmFile arm = host::read_arm_file(text, "five-bar");
  DrivenBench bench(arm, {host::planted_fault("motor-sign@first", arm)}, {.seed = seed},
                    example("board.json"));
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

TEST(DrivenCommission, AFiveBarOnOdrivesWithAMotorWiredBackwards) {
  if (std::getenv("THIMBLE_COMMISSION_ARMS") == nullptr) return commission(1, 6);
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) commission(seed, 10);
}

}  // namespace
}  // namespace thimble::test
