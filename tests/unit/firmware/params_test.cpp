// The parameter table: unique, within its own bounds, and kept within them.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <limits>
#include <set>

#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"

namespace thimble::test {
namespace {

using firmware::Access;
using firmware::kParamTable;
using firmware::ParamRow;
using firmware::Params;
using firmware::ParamStatus;
using firmware::ParamType;

std::uint32_t bits(const ParamRow& row, float value) {
  return row.type == ParamType::kFloat ? std::bit_cast<std::uint32_t>(value)
                                       : static_cast<std::uint32_t>(value);
}

TEST(Params, TableIsSound) {
  std::set<std::uint16_t> ids;
  std::set<std::string> names;
  for (const ParamRow& row : kParamTable) {
    EXPECT_TRUE(ids.insert(row.id).second) << row.name;
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_LT(row.min, row.max) << row.name;
    EXPECT_GE(row.initial, row.min) << row.name;
    EXPECT_LE(row.initial, row.max) << row.name;
    EXPECT_LE(row.max, 16777216.0F) << row.name << ": whole numbers must fit a float";
    EXPECT_EQ(firmware::find_param(row.id), &row);
    EXPECT_EQ(firmware::find_param(row.name), &row);
  }
  EXPECT_EQ(firmware::find_param(std::uint16_t{0xFFFF}), nullptr);
  std::printf("%zu parameters\n", kParamTable.size());
}

TEST(Params, BoundsAndAccess) {
  Params params;
  for (const ParamRow& row : kParamTable) {
    std::uint32_t value = 0;
    ASSERT_EQ(params.read(row.id, value), ParamStatus::kOk);
    EXPECT_EQ(value, bits(row, row.initial)) << row.name;
    EXPECT_EQ(params.write(row.id, bits(row, row.min), true), ParamStatus::kOk) << row.name;
    EXPECT_EQ(params.write(row.id, bits(row, row.max), true), ParamStatus::kOk) << row.name;
    if (row.type == ParamType::kFloat) {
      for (const float bad :
           {std::nextafter(row.max, 1e30F), std::nextafter(row.min, -1e30F),
            std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        EXPECT_EQ(params.write(row.id, bits(row, bad), true), ParamStatus::kOutOfRange)
            << row.name << " " << bad;
    } else {
      EXPECT_EQ(params.write(row.id, static_cast<std::uint32_t>(row.max) + 1, true), ParamStatus::kOutOfRange)
          << row.name;
      EXPECT_EQ(params.write(row.id, 0xFFFFFFFFU, true), ParamStatus::kOutOfRange) << row.name;
    }
    EXPECT_EQ(params.write(row.id, bits(row, row.initial), false),
              row.access == Access::kAlways ? ParamStatus::kOk : ParamStatus::kNotWhileArmed)
        << row.name;
    ASSERT_EQ(params.read(row.id, value), ParamStatus::kOk);
    EXPECT_EQ(value, bits(row, row.access == Access::kAlways ? row.initial : row.max)) << row.name;
  }
  std::uint32_t value = 0;
  EXPECT_EQ(params.read(0xFFFF, value), ParamStatus::kUnknown);
  EXPECT_EQ(params.write(0xFFFF, 0, true), ParamStatus::kUnknown);
}

TEST(Params, AreLockedWhileTheMotorsAreOn) {
  Bench bench;
  bench.start();
  const ParamRow& damping = *firmware::find_param("stop_damping");
  const ParamRow& force = *firmware::find_param("max_force");
  EXPECT_EQ(bench.controller->write_param(damping.id, bits(damping, 1.0F)), ParamStatus::kNotWhileArmed);
  EXPECT_EQ(bench.controller->write_param(force.id, bits(force, 1.0F)), ParamStatus::kOk);
  EXPECT_EQ(bench.controller->request(Command::kDisarm), 0);
  bench.ticks(1100);
  ASSERT_EQ(bench.mode(), Mode::kReady);
  EXPECT_EQ(bench.controller->request(Command::kArm), 0);
  EXPECT_EQ(bench.controller->write_param(damping.id, bits(damping, 1.0F)), ParamStatus::kNotWhileArmed)
      << "an arming is on its way";
}

// Each value from one that every loop tolerates: accepted if the stop path then waits for 5 ms at most, and refused with the reason else.
TEST(Params, LostTicksThatAskForALaterStopAreRefused) {
  const std::uint16_t id = firmware::row_of(firmware::Param::lost_ticks).id;
  for (const float rate_Hz : {1000.0F, 3000.0F, 4000.0F, 20000.0F}) {
    Bench bench({.period_s = 1.0F / rate_Hz});
    Tester tester(bench);
    ASSERT_TRUE(tester.ok({0x10, 0x03}));
    const auto write = [&](unsigned value) {
      return tester.refused({0x2E, static_cast<std::uint8_t>(id >> 8U), static_cast<std::uint8_t>(id),
                             static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value >> 8U), 0, 0});
    };
    for (unsigned value = 1; value <= 120; ++value) {
      ASSERT_EQ(write(1), link::Nrc::kOk);
      const bool allowed = static_cast<float>(value + 1) <= 5e-3F * rate_Hz * 1.00001F;
      EXPECT_EQ(write(value), allowed ? link::Nrc::kOk : link::Nrc::kConditionsNotCorrect)
          << value << " at " << rate_Hz << " Hz";
      if (allowed) continue;
      EXPECT_EQ(tester.text(link::kDidRefusal), "lost_ticks_above_5_ms");
    }
  }
  // A board that is too slow for any: what makes it no worse is taken.
  Bench slow({.period_s = 0.02F});
  Tester tester(slow);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  const auto head = static_cast<std::uint8_t>(id >> 8U);
  const auto low = static_cast<std::uint8_t>(id);
  EXPECT_EQ(tester.refused({0x2E, head, low, 5, 0, 0, 0}), link::Nrc::kConditionsNotCorrect);
  EXPECT_EQ(tester.refused({0x2E, head, low, 4, 0, 0, 0}), link::Nrc::kOk);
  EXPECT_EQ(tester.refused({0x2E, head, low, 2, 0, 0, 0}), link::Nrc::kOk);
}

}  // namespace
}  // namespace thimble::test
