// The time of the frames of a tick, against the published bit counts and the table for three to seven drives.
#include "board/linux/drives/bus_time.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace thimble::test {
namespace {

using namespace board::drives;

TEST(BusTime, BitsOfAFrame) {
  const std::array<std::array<int, 2>, 5> classic = {{{0, 55}, {4, 95}, {6, 115}, {7, 125}, {8, 135}}};
  for (const auto& [size, bits] : classic) {
    EXPECT_NEAR(frame_time_us(static_cast<std::uint8_t>(size), false, false), bits, 1e-3);
    EXPECT_NEAR(frame_time_us(static_cast<std::uint8_t>(size), false, false, {}, Stuffing::kNone),
                47 + 8 * size, 1e-3);
  }
  const std::array<std::array<int, 2>, 7> fd = {
      {{8, 113}, {12, 153}, {16, 193}, {20, 238}, {24, 278}, {32, 358}, {48, 518}}};
  for (const auto& [size, bits] : fd) {
    EXPECT_NEAR(frame_time_us(static_cast<std::uint8_t>(size), true, false), 34 + bits / 5.0, 1e-3);
    EXPECT_NEAR(frame_time_us(static_cast<std::uint8_t>(size), true, true), 57 + bits / 5.0, 1e-3);
  }
}

struct Row {
  Exchange exchange;
  int one, three, four, six, seven;  // us
};
constexpr std::array<Row, 7> kTable = {{
    {Exchange::kMoteusAll, 234, 703, 937, 1405, 1639},
    {Exchange::kMoteusMotion, 177, 532, 709, 1063, 1241},
    {Exchange::kOdriveCyclic, 230, 690, 920, 1380, 1610},
    {Exchange::kOdriveRequested, 325, 975, 1300, 1950, 2275},
    {Exchange::kMiniCheetah, 260, 780, 1040, 1560, 1820},
    {Exchange::kEightBytes, 270, 810, 1080, 1620, 1890},
    {Exchange::kEightBytesFd, 113, 340, 453, 679, 792},
}};

TEST(BusTime, EveryEntryOfTheTable) {
  for (const Row& row : kTable) {
    const auto us = [&row](unsigned drives) { return std::lround(bus_time_us(row.exchange, drives)); };
    EXPECT_EQ(us(1), row.one);
    EXPECT_EQ(us(3), row.three);
    EXPECT_EQ(us(4), row.four);
    // Of 1063.2 and 1240.4 the table rounds the second up.
    EXPECT_EQ(us(6), row.six);
    EXPECT_NEAR(bus_time_us(row.exchange, 7), row.seven, .61);
  }
  EXPECT_EQ(std::lround(exchange_time_us(Exchange::kMoteusAll, Stuffing::kNone)), 196);
}

unsigned most_drives(Exchange exchange, float rate_Hz) {
  std::vector<Exchange> drives;
  while (drives.size() < 20) {
    drives.push_back(exchange);
    if (!bus_load("can0", drives, rate_Hz).fits) break;
  }
  return static_cast<unsigned>(drives.size()) - 1;
}

// The table of docs/drives.md: at 1, 2 and 4 kHz.
TEST(BusTime, DrivesOfABus) {
  const auto at = [](Exchange exchange) {
    return std::array{most_drives(exchange, 1000), most_drives(exchange, 2000), most_drives(exchange, 4000)};
  };
  using Counts = std::array<unsigned, 3>;
  EXPECT_EQ(at(Exchange::kMoteusAll), (Counts{3, 1, 0}));
  EXPECT_EQ(at(Exchange::kMoteusMotion), (Counts{4, 2, 1}));
  EXPECT_EQ(at(Exchange::kOdriveCyclic), (Counts{3, 1, 0}));
  EXPECT_EQ(at(Exchange::kOdriveRequested), (Counts{2, 1, 0}));
  EXPECT_EQ(at(Exchange::kMiniCheetah), (Counts{3, 1, 0}));
  EXPECT_EQ(at(Exchange::kEightBytes), (Counts{2, 1, 0}));  // three take 810 us: just over
  EXPECT_EQ(at(Exchange::kEightBytesFd), (Counts{7, 3, 1}));
}

TEST(BusTime, ARefusalSaysWhatIsAskedForAndWhatToDo) {
  const std::vector<Exchange> three(3, Exchange::kOdriveCyclic);
  const BusLoad fits = bus_load("can0", three, 1000);
  EXPECT_TRUE(fits.fits);
  EXPECT_EQ(fits.sentence(), "three ODrives at 1 kHz need 69 % of can0");
  const BusLoad not_kept = bus_load("can1", three, 2000);
  EXPECT_FALSE(not_kept.fits);
  EXPECT_EQ(not_kept.sentence(),
            "three ODrives at 2 kHz need 138 % of can1, of which 80 % may be used: move drives to another "
            "bus, or lower the rate");
  const std::vector<Exchange> mixed = {Exchange::kMoteusMotion, Exchange::kEightBytesFd,
                                       Exchange::kMoteusMotion};
  EXPECT_EQ(bus_load("can0", mixed, 1000).sentence(),
            "two moteus and one Damiao FD drive at 1 kHz need 47 % of can0");
  EXPECT_EQ(bus_load("can0", std::vector(1, Exchange::kEightBytesFd), 4000).sentence(),
            "one Damiao FD drive at 4 kHz needs 46 % of can0");
}

}  // namespace
}  // namespace thimble::test
