// What telemetry and recordings cost a bus: never more than with protocol 1 for what it had, and the table of docs/link.md.
#include "firmware/link/bus_cost.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "tests/support/generated_docs.h"

namespace thimble::firmware::link {
namespace {

struct Cost {
  const char* content;
  std::vector<std::size_t> frames;  // the bytes of each
  double checks = 0;                // frames of 8 bytes besides
  std::vector<std::size_t> before;  // with protocol 1; empty: it had no such content
};

template <class... Message>
std::vector<std::size_t> of() {
  return {wire_size<Message>()...};
}

double bits(const std::vector<std::size_t>& frames, double checks) {
  double sum = checks * classic_bits(8);
  for (const std::size_t bytes : frames) sum += classic_bits(bytes);
  return sum;
}

// Of one arm and record, or one arm and tick.
std::vector<Cost> costs() {
  constexpr double kChecks = 1.0 / 16;
  return {
      {"record of an arm in free space: Pose, Force", of<Pose, Force>(), 0, {8, 8}},
      {"record of an arm in contact: Pose, Force, GodObject", of<Pose, Force, GodObject>(), 0, {8, 8, 8}},
      {"opt-in: Torque", of<Torque>(), 0, {}},
      {"opt-in: Orientation", of<Orientation>(), 0, {}},
      {"opt-in: JointAngles, 3 joints", of<JointAngles>(), 0, {}},
      {"opt-in: JointAngles, 7 joints", of<JointAngles, JointAngles, JointAngles>(), 0, {}},
      {"opt-in: MotorCurrents, 3 joints", of<MotorCurrents>(), 0, {}},
      {"opt-in: MotorCurrents, 7 joints", of<MotorCurrents, MotorCurrents, MotorCurrents>(), 0, {}},
      {"opt-in: Temperatures, 3 joints", of<Temperatures>(), 0, {}},
      {"opt-in: Temperatures, 7 joints", of<Temperatures, Temperatures>(), 0, {}},
      {"tick of a recording, arm of 3 joints", of<RecordingCounts>(), kChecks, {8}},
      {"tick of a recording, arm of 7 joints",
       of<RecordingCounts, RecordingCounts3, RecordingCounts6>(),
       kChecks,
       {}},
  };
}

std::string cost_table() {
  std::ostringstream out;
  out << "| of one arm | frames | bits | with protocol 1 | |\n|---|---|---|---|---|\n";
  out.precision(6);
  for (const Cost& cost : costs()) {
    out << "| " << cost.content << " | " << static_cast<double>(cost.frames.size()) + cost.checks << " | "
        << bits(cost.frames, cost.checks) << " | ";
    if (cost.before.empty()) {
      out << "-";
    } else {
      out << bits(cost.before, cost.checks);
    }
    out << " | ";
    if (cost.checks != 0) {
      for (const float rate_Hz : {1000.0F, 4000.0F}) {
        const double rate = bits(cost.frames, cost.checks) * static_cast<double>(rate_Hz);
        out << (rate_Hz == 1000.0F ? "" : ", ") << static_cast<int>(rate_Hz / 1000)
            << " kHz: " << static_cast<int>(rate / 1e3) << " kbit/s";
      }
    }
    out << " |\n";
  }
  out << "| ArmRecord, in CAN FD: " << least_size<ArmRecord>() << " bytes, or "
      << static_cast<unsigned>(fd_size(wire_size<ArmRecord>())) << " with opt-in content | 1 | | - | |\n";
  out << "| RecordingAllCounts, in CAN FD: "
      << static_cast<unsigned>(fd_size(wire_size<RecordingAllCounts>())) << " bytes | 1 | | - | |\n";
  return out.str();
}

TEST(BusCost, WhatProtocolOneHadCostsNoMore) {
  for (const Cost& cost : costs()) {
    if (cost.before.empty()) continue;
    EXPECT_LE(cost.frames.size(), cost.before.size()) << cost.content;
    EXPECT_LE(bits(cost.frames, cost.checks), bits(cost.before, cost.checks)) << cost.content;
  }
}

// No frame of the scene's picture is longer than 8 bytes, and as many go out after a record as before.
TEST(BusCost, FramesOfTheSceneAreClassic) {
  for (const std::size_t size :
       of<ContactPlane, BodyPosition, BodyRotation, ControlElementState, TissueState, NeedleState>())
    EXPECT_LE(size, kClassicDataBytes);
}

TEST(BusCost, AFrameByTheStandard) {
  EXPECT_EQ(classic_bits(8), 135U);  // 111 and 24 stuff bits
  EXPECT_EQ(classic_bits(0), 55U);
}

TEST(BusCost, RecordingsThatABusCarries) {
  EXPECT_TRUE(recording_fits(1, 3, 4000, 1'000'000));
  EXPECT_FALSE(recording_fits(2, 3, 4000, 1'000'000));
  EXPECT_TRUE(recording_fits(2, 3, 3000, 1'000'000));
  EXPECT_FALSE(recording_fits(1, 7, 4000, 1'000'000)) << "needs CAN FD or a lower rate";
  EXPECT_TRUE(recording_fits(1, 7, 2000, 1'000'000));
  EXPECT_FALSE(recording_fits(1, 3, 4000, 500'000));
  EXPECT_TRUE(recording_fits(4, 7, 10'000, 0)) << "not known";
}

TEST(BusCost, DocsAreGenerated) { test::expect_generated("docs/link.md", "bus costs", "\n" + cost_table()); }

}  // namespace
}  // namespace thimble::firmware::link
