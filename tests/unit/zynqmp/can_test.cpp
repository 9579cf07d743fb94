#include "board/zynqmp/can.h"

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "board/zynqmp/can_timing.h"
#include "firmware/link/can_frame.h"

namespace thimble::board {
namespace {

using firmware::link::CanFrame;

constexpr std::uint32_t kClock_Hz = 100'000'000;
// As the registers have them.
constexpr std::uint32_t kInReset = 1, kOn = 2;
constexpr std::uint32_t kOverflowBit = 1U << 6U, kFrameBit = 1U << 7U, kErrorBit = 1U << 8U,
                        kBusOffBit = 1U << 9U;

struct Bench {
  CanRegisters registers{};
  Can can{registers, *can_timing(kClock_Hz, 1'000'000), 1'000'000, 5};
};

TEST(CanTiming, IsExactAtEveryUsualBitrateAndSamplesNear80Percent) {
  for (const std::uint32_t clock_Hz : {24'000'000U, 40'000'000U, 80'000'000U, 100'000'000U}) {
    for (const std::uint32_t bitrate : {125'000U, 250'000U, 500'000U, 1'000'000U}) {
      const std::optional<CanTiming> timing = can_timing(clock_Hz, bitrate);
      ASSERT_TRUE(timing) << clock_Hz << ' ' << bitrate;
      const std::uint32_t quanta = 1 + timing->segment_1 + timing->segment_2;
      EXPECT_EQ(timing->prescaler * quanta * bitrate, clock_Hz);
      EXPECT_LE(timing->segment_1, 16U);
      EXPECT_LE(timing->segment_2, 8U);
      EXPECT_LE(timing->jump, timing->segment_2);
      EXPECT_NEAR(static_cast<double>(1 + timing->segment_1) / quanta, .8, .05) << clock_Hz << ' ' << bitrate;
    }
  }
}

TEST(CanTiming, RefusesWhatTheClockCannotGive) {
  EXPECT_FALSE(can_timing(kClock_Hz, 0));
  EXPECT_FALSE(can_timing(kClock_Hz, 300'000));     // no whole number of clocks
  EXPECT_FALSE(can_timing(kClock_Hz, 20'000'000));  // five clocks, less than eight quanta
  EXPECT_FALSE(can_timing(kClock_Hz, 5'000));       // a prescaler above 256
}

TEST(Can, StartsInNormalModeWithItsBitTimingAndFilters) {
  const Bench bench;
  EXPECT_EQ(bench.registers.srr, kOn);
  EXPECT_EQ(bench.registers.msr, 0U);
  EXPECT_EQ(bench.registers.brpr, 4U);  // 20 quanta of 5 clocks
  EXPECT_EQ(bench.registers.btr, 3U << 7U | 3U << 4U | 14U);
  EXPECT_EQ(bench.registers.afr, 0b1111U);
  // A request to node 5 as Linux sends it: id 0x18DA05F1, extended.
  const std::uint32_t request = (0x18DA05F1U >> 18U) << 21U | 3U << 19U | (0x18DA05F1U & 0x3FFFFU) << 1U;
  const auto passes = [&bench](std::uint32_t id) {
    for (const std::size_t i : {0U, 1U, 2U, 3U})
      if (((id ^ bench.registers.filter[i].id) & bench.registers.filter[i].mask) == 0) return true;
    return false;
  };
  EXPECT_TRUE(passes(request));
  EXPECT_FALSE(passes(request ^ 1U << 9U));     // node 4's
  EXPECT_TRUE(passes(request ^ 0xCU << 1U));    // host 0xFD's request
  EXPECT_FALSE(passes(request ^ 0x20U << 1U));  // of no host
  const auto extended = [](std::uint32_t id) {
    return (id >> 18U) << 21U | 3U << 19U | (id & 0x3FFFFU) << 1U;
  };
  for (const std::uint32_t salt : {0U, 0x1234U, 0xFFFFU}) {
    EXPECT_TRUE(passes(extended(0x1C000005U | salt << 8U)));   // a host that claims an address
    EXPECT_FALSE(passes(extended(0x1C000004U | salt << 8U)));  // of node 4
  }
  EXPECT_FALSE(passes(extended(0x1D000005U)));     // its own grant
  EXPECT_TRUE(passes(0x001U << 21U));              // the e-stop
  EXPECT_TRUE(passes(0x001U << 21U | 1U << 20U));  // as a remote frame too
  EXPECT_FALSE(passes(0x181U << 21U));             // another node's pose
  EXPECT_TRUE(passes(0x105U << 21U));              // a force that a host orders of node 5
  EXPECT_FALSE(passes(0x104U << 21U));             // of node 4
  EXPECT_FALSE(passes(0x185U << 21U));             // its own pose
}

TEST(Can, FramesKeepIdSizeAndDataBothWays) {
  Bench bench;
  for (const bool extended : {false, true}) {
    CanFrame sent;
    sent.extended = extended;
    sent.id = extended ? 0x18DA05F1 : 0x285;
    sent.size = 8;
    for (std::uint8_t i = 0; i < 8; ++i) sent.data[i] = static_cast<std::uint8_t>(0x11 * (i + 1));
    bench.can.send(sent, 0);
    bench.registers.rxfifo = bench.registers.txfifo;
    bench.registers.isr = kFrameBit;
    CanFrame received;
    ASSERT_TRUE(bench.can.receive(received));
    EXPECT_TRUE(received == sent);
  }
  bench.registers.isr = 0;
  CanFrame none;
  EXPECT_FALSE(bench.can.receive(none));
}

TEST(Can, SendsNoFasterThanTheBusCarries) {
  Bench bench;
  CanFrame frame;
  frame.size = 8;  // 111 bits
  int sent = 0;
  for (firmware::link::Micros now = 1000; now < 2000; ++now) {
    if (!bench.can.can_send(now)) continue;
    bench.can.send(frame, now);
    ++sent;
  }
  EXPECT_GE(sent, 9);
  EXPECT_LE(sent, 10);
  bench.registers.sr = 1U << 10U;  // full
  EXPECT_FALSE(bench.can.can_send(10'000));
}

TEST(Can, CountsOverflowsAndBusErrorsOnce) {
  Bench bench;
  bench.registers.isr = kOverflowBit | kErrorBit;
  bench.can.supervise(0);
  EXPECT_EQ(bench.registers.icr & (kOverflowBit | kErrorBit), kErrorBit);  // written one after the other
  bench.registers.isr = 0;
  bench.can.supervise(1);
  EXPECT_EQ(bench.can.counters().overflows, 1U);
  EXPECT_EQ(bench.can.counters().errors, 1U);
  EXPECT_EQ(bench.can.counters().bus_offs, 0U);
}

TEST(Can, LeavesTheBusWhenItIsOffAndComesBackAfterAWhile) {
  Bench bench;
  constexpr firmware::link::Micros kAt = 5'000;
  bench.registers.isr = kBusOffBit | kErrorBit;
  bench.can.supervise(kAt);
  EXPECT_EQ(bench.can.counters().bus_offs, 1U);
  EXPECT_EQ(bench.registers.srr, kInReset);
  EXPECT_FALSE(bench.can.can_send(kAt + 1));
  CanFrame frame;
  bench.registers.isr = kFrameBit;
  EXPECT_FALSE(bench.can.receive(frame));
  bench.registers.isr = 0;
  bench.can.supervise(kAt + Can::kOffBus_us - 1);
  EXPECT_EQ(bench.registers.srr, kInReset);
  bench.can.supervise(kAt + Can::kOffBus_us);
  EXPECT_EQ(bench.registers.srr, kOn);
  EXPECT_EQ(bench.registers.afr, 0b1111U);
  EXPECT_EQ(bench.can.counters().restarts, 1U);
  EXPECT_TRUE(bench.can.can_send(kAt + Can::kOffBus_us));
}

TEST(Can, ComesBackFromConfigurationMode) {
  Bench bench;
  bench.registers.sr = 1;
  bench.can.supervise(0);
  bench.registers.sr = 0;
  bench.can.supervise(Can::kOffBus_us);
  EXPECT_EQ(bench.can.counters().bus_offs, 0U);
  EXPECT_EQ(bench.can.counters().restarts, 1U);
  EXPECT_EQ(bench.registers.srr, kOn);
}

}  // namespace
}  // namespace thimble::board
