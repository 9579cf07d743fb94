// The file of a recording: what was written is read back; a truncated file ends earlier; any other content is
// an Error, never a crash.
#include "host-tools/lab/recording.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <sstream>

#include "host-tools/client/device.h"
#include "host-tools/error.h"
#include "host-tools/lab/replay_recording.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;

using host::Error;
using host::ExitCode;
using host::Recording;

host::RecordingHeader small_header(std::uint8_t arms) {
  host::RecordingHeader header;
  header.tool = "1.2.3";
  header.firmware = "1.2.4";
  header.board = "sim";
  header.serial = "none";
  header.node = 7;
  header.began = 1700000000;
  header.scene_name = "a plane";
  SceneBuilder builder;
  builder.plane({0, 0, 1}, 0.0, {});
  header.scene = builder.bytes();
  header.scene_crc = host::crc32(header.scene);
  header.start.tick = 0xFFFFFFF0U;  // it wraps
  header.start.period_s = 1.0F / 4000.0F;
  header.start.mode = link::Mode::kReady;
  header.start.levels.dead_man = true;
  header.start.arms = arms;
  for (std::uint8_t i = 0; i < arms; ++i) {
    header.models.emplace_back("premium-1.5");
    link::RecordingArm arm;
    arm.homed = true;
    arm.raw[0] = 1000U + i;
    arm.rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    header.arms.push_back(arm);
  }
  header.parameters = {{0x0100, 0x40A00000}, {0x0170, 40}};
  return header;
}

// A recording of 40 ticks with a gap of 5, two checks, a frame and an end.
std::string small_recording(std::uint8_t arms = 1) {
  std::ostringstream out;
  host::write_header(out, small_header(arms));
  const std::uint64_t first = 0xFFFFFFF1U;
  host::RecordedTicks ticks{first, {}};
  for (int i = 0; i < 20 * 3 * arms; ++i) ticks.counts.push_back(static_cast<std::uint16_t>(1000 + i % 3));
  host::write_ticks(out, ticks);
  link::Levels held;
  held.dead_man = true;
  host::RecordedCheck check{first + 15, 1, link::Mode::kReady, link::RecordedCommand::kNone, false, held};
  host::write_checks(out, std::vector{check});
  host::write_ticks(out, {first + 20, ticks.counts});
  ticks.first = first + 45;
  host::write_ticks(out, ticks);
  host::RecordedCheck armed{first + 31, 2, link::Mode::kArmed, link::RecordedCommand::kArm, false, held};
  armed.levels.drive_fault[3] = true;
  const host::RecordedCheck last{first + 64, 3, link::Mode::kReady, link::RecordedCommand::kNone, true, held};
  host::write_checks(out, std::vector{armed, last});
  host::RecordedFrame frame;
  frame.time_us = 12345;
  frame.frame.id = 0x187;
  frame.frame.size = 8;
  for (std::size_t i = 0; i < 8; ++i) frame.frame.data[i] = static_cast<std::uint8_t>(0x80 + i);
  host::write_frames(out, std::vector<host::RecordedFrame>{frame});
  host::write_marks(out, std::vector<host::RecordedMark>{{first + 3, link::MarkKind::kEvent, 65535, 0},
                                                         {first + 30, link::MarkKind::kTrial, 2, 1}});
  host::write_end(out, {"stopped", 0, 65, 5, 5, 4});
  return out.str();
}

std::span<const std::byte> bytes_of(const std::string& text) { return std::as_bytes(std::span(text)); }

TEST(RecordingFile, WhatWasWrittenComesBack) {
  for (const std::uint8_t arms : {std::uint8_t{1}, std::uint8_t{2}}) {
    const Recording recording = host::parse_recording(bytes_of(small_recording(arms)), "file");
    const host::RecordingHeader& header = recording.header;
    const host::RecordingHeader meant = small_header(arms);
    EXPECT_EQ(header.tool, meant.tool);
    EXPECT_EQ(header.firmware, meant.firmware);
    EXPECT_EQ(header.models, meant.models);
    EXPECT_EQ(header.node, 7);
    EXPECT_EQ(header.began, 1700000000);
    EXPECT_EQ(header.scene, meant.scene);
    EXPECT_EQ(header.parameters, meant.parameters);
    EXPECT_EQ(header.start.tick, meant.start.tick);
    EXPECT_EQ(header.arms.back().raw[0], 1000U + arms - 1U);
    ASSERT_EQ(recording.ticks.size(), 2U) << "those that follow each other are one";
    EXPECT_EQ(recording.ticks[0].first, 0xFFFFFFF1U);
    EXPECT_EQ(recording.ticks[0].counts.size(), 40U * 3U * arms);
    EXPECT_EQ(recording.ticks[1].first, 0xFFFFFFF1U + 45ULL) << "beyond 32 bits";
    EXPECT_EQ(recording.tick_count(), 60U);
    ASSERT_EQ(recording.checks.size(), 3U);
    EXPECT_EQ(recording.checks[2].tick, 0xFFFFFFF1U + 64ULL);
    EXPECT_EQ(recording.checks[1].mode, link::Mode::kArmed);
    EXPECT_EQ(recording.checks[1].command, link::RecordedCommand::kArm);
    EXPECT_TRUE(recording.checks[1].levels.dead_man && recording.checks[1].levels.drive_fault[3]);
    EXPECT_FALSE(recording.checks[1].last || recording.checks[1].levels.drive_fault[0]);
    EXPECT_TRUE(recording.checks[2].last);
    ASSERT_EQ(recording.marks.size(), 2U);
    EXPECT_EQ(recording.marks[0].value, 65535U);
    EXPECT_EQ(recording.marks[1].tick, 0xFFFFFFF1U + 30ULL);
    EXPECT_EQ(recording.marks[1].what, link::MarkKind::kTrial);
    EXPECT_EQ(recording.first_trial(), 1U);
    ASSERT_EQ(recording.frames.size(), 1U);
    EXPECT_EQ(recording.frames[0].frame.data[7], 0x87);
    ASSERT_TRUE(recording.end);
    EXPECT_EQ(recording.end->reason, "stopped");
    EXPECT_EQ(recording.end->missing, 5U);
    EXPECT_EQ(recording.end->marks_missing, 4U);
    EXPECT_EQ(recording.cut_bytes, 0U);
  }
}

TEST(RecordingFile, CutAnywhereItEndsEarlier) {
  const std::string whole = small_recording();
  const std::uint64_t ticks = host::parse_recording(bytes_of(whole), "file").tick_count();
  std::uint64_t most = 0;
  std::size_t refused = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    try {
      const Recording cut = host::parse_recording(bytes_of(whole.substr(0, size)), "file");
      EXPECT_FALSE(cut.end) << size;
      EXPECT_GE(cut.tick_count(), most) << "more bytes, more ticks";
      most = cut.tick_count();
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ExitCode::kBadInput);
      EXPECT_EQ(most, 0U) << "only within the header is nothing left";
      ++refused;
    }
  }
  EXPECT_EQ(most, ticks);
  figure("bytes of a recording", static_cast<double>(whole.size()), "reported");
  figure("cuts that leave nothing", static_cast<double>(refused), "those within the header");
}

TEST(RecordingFile, EveryFlippedBitIsSeen) {
  const std::string whole = small_recording();
  std::size_t refused = 0;
  std::size_t earlier = 0;
  for (std::size_t bit = 0; bit < whole.size() * 8; ++bit) {
    std::string flipped = whole;
    flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
    try {
      EXPECT_FALSE(host::parse_recording(bytes_of(flipped), "file").end) << "bit " << bit;
      ++earlier;
    } catch (const Error& error) {
      EXPECT_EQ(error.code, ExitCode::kBadInput);
      ++refused;
    }
  }
  figure("flipped bits that are refused", static_cast<double>(refused), "reported");
  figure("flipped bits that end it earlier: those of a length", static_cast<double>(earlier), "reported");
  EXPECT_LT(earlier, whole.size() * 8 / 10);
}

// Bytes of anybody: the CRC is right, and what it stands for is nonsense.
TEST(RecordingFile, NonsenseWithAGoodCrcIsRefusedOrLivedWith) {
  const std::string whole = small_recording(2);
  Random random(20);
  std::size_t read = 0;
  std::size_t replayed = 0;
  constexpr int kMutants = 4000;
  for (int mutant = 0; mutant < kMutants; ++mutant) {
    std::string bytes = whole;
    // One message is changed in a few places, and gets its CRC anew.
    std::size_t at = host::kRecordingMagic.size();
    std::vector<std::pair<std::size_t, std::size_t>> messages;
    const auto u32 = [&](std::size_t from) {
      std::uint32_t value = 0;
      std::memcpy(&value, bytes.data() + from, 4);
      return value;
    };
    while (at + 8 <= bytes.size()) {
      messages.emplace_back(at + 8, u32(at));
      at += 8 + u32(at);
    }
    const auto [from, size] = messages[random.below(messages.size())];
    for (std::uint64_t i = random.below(4) + 1; i > 0; --i)
      bytes[from + random.below(size)] =
          static_cast<char>(random.below(2) == 0 ? random.bits() : 0xFF * random.below(2));
    const std::uint32_t crc = host::crc32(bytes_of(bytes).subspan(from, size));
    std::memcpy(bytes.data() + from - 4, &crc, 4);
    try {
      const Recording recording = host::parse_recording(bytes_of(bytes), "file");
      ++read;
      static_cast<void>(host::replay_recording(recording));
      ++replayed;
    } catch (const Error& error) {
      EXPECT_TRUE(error.code == ExitCode::kBadInput || error.code == ExitCode::kVersion) << error.cause;
    }
  }
  figure("mutants, of 4000, that could be read", static_cast<double>(read), "reported");
  figure("and replayed", static_cast<double>(replayed), "reported");
  EXPECT_GT(read, kMutants / 20U);
  EXPECT_LT(read, kMutants * 1U);
}

TEST(RecordingFile, OfAnotherFormat) {
  std::ostringstream out;
  host::write_header(out, small_header(1));
  const std::string bytes = out.str();
  for (const int other : {host::kRecordingFormat - 1, host::kRecordingFormat + 1}) {
    // The format is the header's one field with its value in two bytes that makes it so when changed.
    std::size_t seen = 0;
    for (std::size_t at = 16; at + 1 < bytes.size(); ++at) {
      if (bytes[at] != host::kRecordingFormat || bytes[at + 1] != 0) continue;
      std::string changed = bytes;
      changed[at] = static_cast<char>(other);
      const std::uint32_t crc = host::crc32(bytes_of(changed).subspan(16));
      std::memcpy(changed.data() + 12, &crc, 4);
      try {
        static_cast<void>(host::parse_recording(bytes_of(changed), "file"));
      } catch (const Error& error) {
        if (error.code == ExitCode::kVersion) {
          EXPECT_EQ(error.name, "version-mismatch");
          EXPECT_NE(error.remedy.find("1.2.3"), std::string::npos) << "the thimble that wrote it";
          ++seen;
        }
      }
    }
    EXPECT_EQ(seen, 1U);
  }
}

}  // namespace
}  // namespace thimble::test
