// The logic of board/zynqmp/fabric, verilated, behind the firmware's own driver (board/cortex/fabric.cpp): every access of the driver to a
// register is a transfer on the AXI4-Lite bus of the model.
#include "board/cortex/fabric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <set>
#include <vector>

#include "board/common/ad5754.h"
#include "board/common/quadrature.h"
#include "tests/hardware/fabric/rig.h"

namespace thimble::tests {
namespace {

constexpr std::uint32_t kLatch = 0x08, kLines = 0x0C, kWatchdog = 0x14, kDiagnostics = 0x100;
constexpr std::uint32_t kFilter = 16;
constexpr std::uint32_t kApart = kFilter + 2;  // clocks between edges, at least
constexpr std::uint32_t kTrip_us = 2000;
constexpr std::uint32_t kSet = 1000;  // clocks in which two sets of frames are sent

struct DriverRig : testing::Test {
  Rig rig;
  TrappedPage page{rig};
  board::Fabric fabric{page.address(), kArms};
  firmware::Inputs inputs;
  firmware::Outputs outputs;

  ~DriverRig() override {
    EXPECT_EQ(rig.bus_errors, 0U);
    for (const Converter& converter : rig.converter) EXPECT_EQ(converter.violations, 0U);
  }
  void commit(bool enable) {
    for (firmware::ArmOutputs& arm : outputs.arm) arm.enable = enable;
    fabric.commit(outputs);
  }
  [[nodiscard]] bool enabled(std::size_t arm) const { return (rig.out.enable >> arm & 1) != 0; }
};

TEST_F(DriverRig, EveryAccessReachesTheBus) {
  EXPECT_TRUE(fabric.present());
  rig.reads = rig.writes = 0;
  fabric.latch(inputs);
  EXPECT_EQ(rig.writes, 1U);
  EXPECT_EQ(rig.reads, 1 + kArms * 4);
  commit(false);
  EXPECT_EQ(rig.writes, 1 + kArms * 4 + 1);
  EXPECT_EQ(rig.reads, 1 + kArms * 4);
}

TEST_F(DriverRig, LinesAreFilteredAndLatched) {
  const auto latch = [&] {
    rig.run(kFilter + 4);
    fabric.latch(inputs);
  };
  latch();
  EXPECT_FALSE(inputs.e_stop);
  EXPECT_TRUE(inputs.dead_man);
  for (const firmware::ArmInputs& arm : inputs.arm) EXPECT_FALSE(arm.drive_fault || arm.index);
  rig.in.e_stop_released = rig.in.dead_man_held = 0;
  rig.run(kFilter - 1);
  rig.in.e_stop_released = rig.in.dead_man_held = 1;  // too short
  latch();
  EXPECT_FALSE(inputs.e_stop);
  EXPECT_TRUE(inputs.dead_man);
  rig.in.e_stop_released = 0;
  rig.in.index = 2;
  latch();
  EXPECT_TRUE(inputs.e_stop);
  EXPECT_TRUE(inputs.dead_man);
  EXPECT_FALSE(inputs.arm[0].index);
  EXPECT_TRUE(inputs.arm[1].index);
  rig.in.e_stop_released = 1;
  rig.in.dead_man_held = 0;
  rig.in.drives_good = 1;
  rig.run(100);
  EXPECT_EQ(rig.read(kLines), board::kLineDeadManHeld);  // nothing moves until the next latch
  latch();
  EXPECT_FALSE(inputs.e_stop);
  EXPECT_FALSE(inputs.dead_man);
  EXPECT_FALSE(inputs.arm[0].drive_fault);
  EXPECT_TRUE(inputs.arm[1].drive_fault);
}

TEST_F(DriverRig, OtherWordsReadZeroAndPartsOfWordsAreRefused) {
  const std::set<std::uint32_t> known{0x00, 0x04, 0x0C, 0x2C, 0x4C, 0x11C, 0x13C};
  for (std::uint32_t offset = 0; offset < 0x1000; offset += 4) {
    if (known.count(offset) == 0) {
      EXPECT_EQ(rig.read(offset), 0U) << offset;
    }
    if (offset > 0x60) rig.write(offset, 0xFFFFFFFF);
  }
  EXPECT_TRUE(fabric.present());
  rig.in.e_stop_released = 0;
  rig.run(100);
  for (std::uint8_t strobes = 0; strobes < 15; ++strobes) EXPECT_EQ(rig.write(kLatch, 1, strobes), 2U);
  EXPECT_NE(rig.read(kLines) & board::kLineEStopReleased, 1U) << "no latch since the reset";
  rig.in.e_stop_released = 1;
  rig.run(100);
  EXPECT_EQ(rig.write(kLatch, 1, 15), 0U);
  EXPECT_EQ(rig.read(kLines) & board::kLineEStopReleased, 1U);
}

// Six encoders that go to and fro at the highest rate, read by the driver at any time. The reference is the decoder of board/common.
struct Encoders {
  explicit Encoders(Rig& the_rig) : rig(the_rig) {
    for (std::uint32_t& wait : waits) wait = 100 + rig.roll(100);
  }

  void clock() {
    for (std::size_t i = 0; i < kEncoders; ++i) {
      if (--waits[i] == 0) step(i);
      if (lines_late[i] && rig.roll(2) == 0)
        show(i);  // an edge near a sample is seen by this one or by the next
      if (since[i]++ > 0) show(i);
      if (glitches && waits[i] == 3 * kApart && since[i] > kApart && rig.roll(2) == 0)
        glitch[i] = 1 + rig.roll(kFilter - 1);
      const std::uint8_t bit = static_cast<std::uint8_t>(1U << i);
      const bool flip = glitch[i] > 0 && glitch[i]-- > 0;
      rig.in.encoder_a =
          static_cast<std::uint8_t>((rig.in.encoder_a & ~bit) | (shown_a[i] != flip ? bit : 0));
      rig.in.encoder_b = static_cast<std::uint8_t>((rig.in.encoder_b & ~bit) | (shown_b[i] ? bit : 0));
    }
    std::array<std::uint32_t, kEncoders> counts{};
    for (std::size_t i = 0; i < kEncoders; ++i) counts[i] = reference[i].count();
    history[rig.now] = counts;
    if (history.size() > 200) history.erase(history.begin());
  }

  void step(std::size_t i) {
    if (rig.roll(8) == 0) forwards[i] = !forwards[i];
    // Forwards 00, 10, 11, 01: A changes if the lines are equal.
    const bool of_a = (a[i] == b[i]) == forwards[i];
    (of_a ? a : b)[i] = !(of_a ? a : b)[i];
    lines_late[i] = true;
    since[i] = 0;
    waits[i] = kApart + (rig.roll(4) == 0 ? rig.roll(100) : 0);
  }

  void show(std::size_t i) {
    if (shown_a[i] != a[i]) reference[i].edge(board::QuadratureLine::kA, a[i]);
    if (shown_b[i] != b[i]) reference[i].edge(board::QuadratureLine::kB, b[i]);
    shown_a[i] = a[i];
    shown_b[i] = b[i];
    lines_late[i] = false;
  }

  Rig& rig;
  bool glitches = false;
  std::array<std::uint32_t, kEncoders> waits{}, glitch{}, since{};
  std::array<bool, kEncoders> a{}, b{}, shown_a{}, shown_b{}, forwards{}, lines_late{};
  std::array<board::Quadrature, kEncoders> reference;
  std::map<std::uint64_t, std::array<std::uint32_t, kEncoders>> history;
};

TEST_F(DriverRig, CountsEveryEdgeAndLatchesAllInOneClock) {
  Encoders encoders(rig);
  rig.on_clock = [&] { encoders.clock(); };
  constexpr std::uint64_t kLag = kFilter + 3;  // clocks from a sample to the count
  std::uint32_t most = 0;
  rig.run(100);
  for (int latch = 0; latch < 20000; ++latch) {
    encoders.glitches = latch >= 10000;
    rig.run(rig.roll(60));
    rig.write(kLatch, 1);
    const std::array<std::uint32_t, kEncoders> expected = encoders.history.at(rig.taken - kLag);
    for (std::uint32_t i = 0; i < kEncoders; ++i) {
      const std::uint32_t count = rig.read(0x20 + 0x20 * (i / 3) + 4 * (i % 3));
      ASSERT_EQ(count, expected[i]) << "encoder " << i << ", latch " << latch;
      most = std::max(most, static_cast<std::uint32_t>(std::abs(static_cast<std::int32_t>(count))));
    }
  }
  EXPECT_GT(most, 20U);
  for (std::size_t i = 0; i < kEncoders; ++i) EXPECT_FALSE(encoders.reference[i].lost());
  for (std::uint32_t arm = 0; arm < kArms; ++arm)
    for (std::uint32_t joint = 0; joint < 3; ++joint)
      EXPECT_EQ(rig.read(kDiagnostics + 0x20 * arm + 4 * joint), 0U);
  rig.on_clock = nullptr;
  rig.run(3 * kApart);
  inputs.tick = 7;
  fabric.latch(inputs);  // the driver's own view of the same
  for (std::uint32_t i = 0; i < kEncoders; ++i) {
    EXPECT_EQ(inputs.arm[i / 3].counts[i % 3], encoders.reference[i].count());
    EXPECT_EQ(inputs.arm[i / 3].sample_tick, 7U);
  }
}

TEST_F(DriverRig, DiagnosticsShowLostEdgesAndTheIndex) {
  const auto step = [&](std::uint8_t a, std::uint8_t b) {
    rig.in.encoder_a = a, rig.in.encoder_b = b;
    rig.run(40);
  };
  step(0x10, 0x10);  // both lines at once: encoder 1 of arm 1
  step(0x00, 0x00);
  step(0x20, 0x00);
  step(0x20, 0x20);
  EXPECT_EQ(rig.read(kDiagnostics + 0x24), 2U);
  EXPECT_EQ(rig.read(kDiagnostics + 0x28), 0U);
  EXPECT_EQ(rig.read(kDiagnostics), 0U);
  rig.in.index = 2;
  rig.in.encoder_a = 0x00;  // in the clock of the index
  rig.run(40);
  step(0x00, 0x00);
  EXPECT_EQ(rig.read(kDiagnostics + 0x2C), 1U);
  EXPECT_EQ(rig.read(kDiagnostics + 0x38), 2U) << "the counter of this clock, before its edge";
  EXPECT_EQ(rig.read(kDiagnostics + 0x0C), 0U);
  fabric.latch(inputs);
  EXPECT_EQ(inputs.arm[1].counts[2], 4U);
}

TEST_F(DriverRig, ResetEnablesNothing) {
  const auto refused = [&] {
    commit(true);
    rig.run(10);
    EXPECT_EQ(rig.out.enable, 0);
    EXPECT_EQ(rig.out.enable_pulse, 0);
    fabric.latch(inputs);
    EXPECT_TRUE(inputs.arm[0].drive_fault && inputs.arm[1].drive_fault);
  };
  commit(true);
  rig.run(10);
  EXPECT_EQ(rig.out.enable, 3);
  rig.reset();
  EXPECT_EQ(rig.out.enable, 0);
  refused();
  commit(false);
  commit(true);
  rig.run(10);
  EXPECT_EQ(rig.out.enable, 3);
  rig.run((kTrip_us + 1) * kClocks_us);  // 2 ms without being told
  refused();
}

TEST_F(DriverRig, TheWatchdogClearsEnablesUntilACommitWithoutThem) {
  for (const std::uint32_t timeout_us : {2000U, 2500U, 5000U}) {
    fabric.start_watchdog(timeout_us);
    commit(false);
    for (int tick = 0; tick < 20; ++tick) {
      outputs.arm[0].current_A[0] = 1.5F;
      commit(true);
      rig.run((timeout_us - 100) * kClocks_us);
      ASSERT_EQ(rig.out.enable, 3) << tick;
    }
    commit(true);
    const std::uint64_t committed = rig.taken;
    std::uint64_t pulses = 0, was = 0;
    while (rig.out.enable != 0 && rig.now < committed + 10000 * kClocks_us) {
      rig.run(1);
      pulses += rig.out.enable_pulse != was ? 1 : 0;
      was = rig.out.enable_pulse;
    }
    EXPECT_LE(rig.now - 1 - committed, timeout_us * kClocks_us);
    EXPECT_GE(rig.now - 1 - committed, (timeout_us - 1) * kClocks_us);
    EXPECT_EQ(rig.out.enable_pulse, 0);
    EXPECT_NEAR(static_cast<double>(pulses), timeout_us / 5.0, 3);  // 100 kHz
    rig.run(kSet);
    EXPECT_EQ(rig.converter[0].output[0], 0) << "no current either";
    fabric.latch(inputs);
    EXPECT_TRUE(inputs.arm[0].drive_fault && inputs.arm[1].drive_fault);
    for (firmware::ArmOutputs& arm : outputs.arm) arm.enable = false;
    outputs.arm[1].enable = true;  // one of two is not none
    fabric.commit(outputs);
    rig.run(100);
    EXPECT_EQ(rig.out.enable, 0);
    commit(false);
    fabric.latch(inputs);
    EXPECT_FALSE(inputs.arm[0].drive_fault || inputs.arm[1].drive_fault);
  }
  rig.write(kWatchdog, 0);
  commit(true);
  rig.run(20000 * kClocks_us);
  EXPECT_EQ(rig.out.enable, 3) << "0: never";
  rig.write(kWatchdog, 2000);  // and the time since the commit counts
  rig.run(10);
  EXPECT_EQ(rig.out.enable, 0);
  commit(false);
  commit(true);
  fabric.off();
  rig.run(1);
  EXPECT_EQ(rig.out.enable, 0);
}

TEST_F(DriverRig, ConvertersAreSetUpAndShowTheCurrentsOfOneCommit) {
  rig.run(5 * kSet);  // the driver's constructor committed
  const auto word = [](const board::Ad5754::Frame& frame) {
    return static_cast<std::uint32_t>(frame[0] << 16 | frame[1] << 8 | frame[2]);
  };
  using Dac = board::Ad5754;
  const char* const scale = std::getenv("THIMBLE_FABRIC_VOLTS_PER_AMPERE");
  const Dac::Channel channel{.volts_per_ampere = scale == nullptr ? 1.0F : std::strtof(scale, nullptr)};
  std::vector<std::uint32_t> wanted{word(Dac::set_range())};
  for (int set = 0; set < 2; ++set) {
    for (std::uint8_t output = 0; output < 3; ++output) wanted.push_back(word(Dac::voltage(output, 0)));
    wanted.push_back(word(Dac::load()));
    if (set == 0) wanted.push_back(word(Dac::power_up()));
  }
  for (Converter& converter : rig.converter) {
    // The commit may interrupt the first set, which begins again.
    std::vector<std::uint32_t> got = converter.frames;
    if (got.size() > wanted.size()) got.erase(got.begin() + 1);
    EXPECT_EQ(got, wanted);
    converter.frames.clear();
  }
  fabric.start_watchdog(0);
  std::uniform_real_distribution<float> current_A(-11, 11);
  for (int tick = 0; tick < 300; ++tick) {
    for (firmware::ArmOutputs& arm : outputs.arm)
      for (float& current : arm.current_A) current = current_A(rig.random);
    if (tick == 0) outputs.arm[0].current_A = {1000.0F, -1000.0F, 10.0F};
    const std::uint32_t loads = rig.converter[0].loads;
    commit(true);
    rig.run(kSet);
    EXPECT_EQ(rig.converter[0].loads, loads + 1);
    for (std::size_t arm = 0; arm < kArms; ++arm)
      for (std::size_t joint = 0; joint < 3; ++joint)
        ASSERT_NEAR(rig.converter[arm].output[joint],
                    Dac::word(channel, outputs.arm[arm].current_A[joint]).value, 1);
  }
  // Commits at any time: what a converter shows is of one of them, and the last one comes.
  for (firmware::ArmOutputs& arm : outputs.arm) arm.current_A.fill(1.0F);
  commit(true);
  rig.run(kSet);
  for (int tick = 0; tick < 300; ++tick) {
    for (firmware::ArmOutputs& arm : outputs.arm) arm.current_A.fill(current_A(rig.random));
    commit(true);
    for (std::uint64_t clocks = rig.roll(600); clocks > 0; --clocks) {
      rig.run(1);
      for (const Converter& converter : rig.converter)
        ASSERT_TRUE(converter.output[0] == converter.output[1] && converter.output[1] == converter.output[2]);
    }
  }
  rig.run(2 * kSet);
  for (std::size_t arm = 0; arm < kArms; ++arm)
    EXPECT_NEAR(rig.converter[arm].output[1], Dac::word(channel, outputs.arm[arm].current_A[1]).value, 1);
  // An arm without an enable gets no current.
  outputs.arm[1].enable = false;
  fabric.commit(outputs);
  rig.run(kSet);
  EXPECT_NE(rig.converter[0].output[0], 0);
  EXPECT_EQ(rig.converter[1].output[0], 0);
  for (const Converter& converter : rig.converter)
    EXPECT_TRUE(converter.range == 4 && converter.power == 0x1F);
}

}  // namespace
}  // namespace thimble::tests
