// The commissioning of a simulated arm whose motors obey a controller, over the link: the same steps and findings as on the bench without one.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "host-tools/commission/link_bench.h"
#include "host-tools/commission/planted.h"
#include "host-tools/commission/procedure.h"
#include "tests/closed_loop/commission/linked_bench.h"

namespace thimble::test {
namespace {

std::string text_of(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return {std::istreambuf_iterator<char>(in), {}};
}

struct Rig {
  explicit Rig(const std::string& name, const std::vector<std::string>& faults = {},
               host::SimBenchOptions options = {})
      : text(text_of(name)),
        arm(host::read_arm_file(text, name)),
        bench(arm, planted(faults, arm), options),
        commission(text, name, "test") {}

  static std::vector<host::SimFault> planted(const std::vector<std::string>& faults,
                                             const host::ArmFile& arm) {
    std::vector<host::SimFault> all;
    for (const std::string& fault : faults) all.push_back(host::planted_fault(fault, arm));
    return all;
  }
  // The first step that does not pass; 11: none.
  int go(int last = 10) {
    host::LinkBench link([this] { return bench.open(); }, bench, 0);
    for (int step = 0; step <= last; ++step) {
      link.begin_step(step);
      const double began_s = bench.time_s();
      const host::StepResult& result = commission.run(step, link);
      std::printf("step %2d: %6.1f s of the board, most %.2f N, %.3f m/s\n", step, bench.time_s() - began_s,
                  bench.most_tip_force_N(), bench.most_tip_speed_m_s());
      for (const host::ArmFinding& found : result.findings) std::printf("  %s\n", found.text.c_str());
      for (const std::string& note : result.notes) std::printf("  %s\n", note.c_str());
      if (!result.passed) return step;
    }
    return last + 1;
  }

  std::string text;
  host::ArmFile arm;
  LinkedBench bench;
  host::Commission commission;
};

TEST(LinkCommission, APaddlePasses) {
  Rig rig("paddle");
  EXPECT_EQ(rig.go(), 11);
}

TEST(LinkCommission, APremiumPasses) {
  Rig rig("premium-1.5");
  EXPECT_EQ(rig.go(), 11);
}

TEST(LinkCommission, AMotorThatIsWiredBackwardsIsNamed) {
  Rig rig("premium-1.5", {"motor-sign@upper"});
  EXPECT_EQ(rig.go(), 5);
  ASSERT_EQ(rig.commission.results().at(5).findings.size(), 1U);
  EXPECT_EQ(rig.commission.results().at(5).findings[0].fault, host::ArmFault::kMotorSign);
}

}  // namespace
}  // namespace thimble::test
