// What is asked of the kernel beyond priority and locked memory, against folders that look like a system's; and the budget of a tick.
#include "board/linux/realtime.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "board/linux/rate_budget.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/drive_configs.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using board::KernelLatency;

TEST(KernelLatency, IsAskedForHeldAndReported) {
  const TemporaryFolder folder;
  const std::filesystem::path root = folder.path();
  std::filesystem::create_directories(root / "sys/kernel");
  std::filesystem::create_directories(root / "dev");
  {
    const KernelLatency stock(root);
    EXPECT_FALSE(stock.preempt_rt() || stock.awake());
    ASSERT_EQ(stock.report().size(), 2U);
    EXPECT_THAT(stock.report()[0], testing::HasSubstr("no PREEMPT_RT"));
    EXPECT_THAT(stock.report()[1], testing::HasSubstr("cpu_dma_latency: No such file"));
  }
  std::ofstream(root / "sys/kernel/realtime") << "1\n";
  std::ofstream(root / "dev/cpu_dma_latency") << "";
  const KernelLatency realtime(root);
  EXPECT_TRUE(realtime.preempt_rt() && realtime.awake());
  EXPECT_EQ(realtime.report()[0], "the kernel has PREEMPT_RT");
  EXPECT_EQ(realtime.report()[1], "cpu_dma_latency is held at 0 us");
  std::ifstream written(root / "dev/cpu_dma_latency", std::ios::binary);
  EXPECT_EQ(std::string((std::istreambuf_iterator<char>(written)), {}), std::string(4, '\0'));
  std::ofstream(root / "sys/kernel/realtime") << "0\n";
  EXPECT_FALSE(KernelLatency(root).preempt_rt());
}

TEST(RateBudget, AddsUpTheParts) {
  board::BoardConfig config;
  config.rate_Hz = 1000;
  config.work_units = 4000;
  board::ArmWiring arm;
  arm.model = "premium-1.5";
  arm.arm = kinematics::built_in_arm(arm.model);
  arm.dac = board::DacConfig{"/dev/spidev0.0", 1'000'000, {}};
  for (std::size_t j = 0; j < 3; ++j) arm.dac->channels[j].emplace();
  config.arms.push_back(arm);
  board::RateBudget budget = board::rate_budget(config, 30, 50);
  EXPECT_DOUBLE_EQ(budget.rendering_us, 200);  // 4000 units of 50 ns
  EXPECT_DOUBLE_EQ(budget.spi_us, 96);         // four frames of 24 bits
  EXPECT_EQ(budget.bus_us, 0);
  EXPECT_DOUBLE_EQ(budget.sum_us(), 326);
  EXPECT_EQ(budget.lines().size(), 5U);
  EXPECT_EQ(budget.lines().back(), "     326 us  33 %  in all");

  for (std::size_t j = 0; j < 3; ++j)
    config.arms[0].drives[j] =
        board::DriveWiring{"can" + std::to_string(j / 2), config_of(Kind::kOdrive05, 1), {}, 1};
  budget = board::rate_budget(config, 30, std::nullopt);
  EXPECT_DOUBLE_EQ(budget.rendering_us, 250);
  EXPECT_EQ(budget.bus, "can0");
  EXPECT_NEAR(budget.bus_us, 2 * 2 * 135,
              .1);  // two drives, two classic frames of 8 bytes with the most stuff bits
  config.rate_Hz = 2000;
  budget = board::rate_budget(config, 30, std::nullopt);
  EXPECT_THAT(budget.lines().back(), testing::HasSubstr("does not fit: lower the rate"));
}

}  // namespace
}  // namespace thimble::test
