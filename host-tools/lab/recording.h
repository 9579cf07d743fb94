// Recordings of a device's ticks (docs/recording.md): written message by message, read as a whole.
//
// A file is kRecordingMagic and then messages (recording.fbs), each after its length and its CRC-32; so a truncated file can be read up
// to the last whole message. The first message is the header. Without an end message the recording was cut off.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"

namespace thimble::host {

namespace link = firmware::link;

inline constexpr std::string_view kRecordingMagic = "THIMREC\n";
inline constexpr std::uint16_t kRecordingFormat = 3;
inline constexpr std::size_t kRecordedCounts = link::kClassicCounts;  // an arm and tick

struct RecordingHeader {
  std::string tool;
  std::string firmware;
  std::string board;
  std::string serial;
  std::vector<std::string> models;
  std::uint8_t node = 1;
  std::int64_t began = 0;
  std::string scene_name;
  std::vector<std::byte> scene;
  std::uint32_t scene_crc = 0;
  link::RecordingStart start;
  std::vector<link::RecordingArm> arms;
  std::vector<std::pair<std::uint16_t, std::uint32_t>> parameters;
};

struct RecordedTicks {
  std::uint64_t first = 0;  // unwrapped: not below the recording's start
  std::vector<std::uint16_t> counts;
};

struct RecordedCheck {
  std::uint64_t tick = 0;
  std::uint32_t crc = 0;
  link::Mode mode = link::Mode::kDisarmed;
  link::RecordedCommand command = link::RecordedCommand::kNone;
  bool last = false;
  link::Levels levels;
};

// A write of `event` or `trial`, and the tick that took it.
struct RecordedMark {
  std::uint64_t tick = 0;
  link::MarkKind what = link::MarkKind::kEvent;
  std::uint16_t value = 0;
  std::uint16_t before = 0;  // the parameter's value until then
};

struct RecordedFrame {
  std::uint32_t time_us = 0;
  link::CanFrame frame;
};

struct RecordingEnd {
  std::string reason;
  std::uint8_t fault = 0;
  std::uint32_t ticks = 0;
  std::uint32_t dropped = 0;
  std::uint32_t missing = 0;
  std::uint32_t marks_missing = 0;  // that are not in the file
};

struct Recording {
  RecordingHeader header;
  std::vector<RecordedTicks> ticks;  // in order; joined where they follow each other
  std::vector<RecordedCheck> checks;
  std::vector<RecordedMark> marks;
  std::vector<RecordedFrame> frames;
  std::optional<RecordingEnd> end;  // none: cut off
  std::uint64_t cut_bytes = 0;      // behind the last whole message
  [[nodiscard]] std::uint64_t tick_count() const;
  // The parameter `trial` as the recording began; 0 for firmware that has none.
  [[nodiscard]] std::uint8_t first_trial() const;
};

// Each writes a message.
void write_header(std::ostream& out, const RecordingHeader& header);
void write_ticks(std::ostream& out, const RecordedTicks& ticks);
void write_checks(std::ostream& out, std::span<const RecordedCheck> checks);
void write_marks(std::ostream& out, std::span<const RecordedMark> marks);
void write_frames(std::ostream& out, std::span<const RecordedFrame> frames);
void write_end(std::ostream& out, const RecordingEnd& end);

[[nodiscard]] bool is_recording(const std::filesystem::path& file);

// Error kBadInput: `not-a-recording`, `broken-recording` (with the place); kVersion: of a later format.
[[nodiscard]] Recording parse_recording(std::span<const std::byte> bytes, const std::string& name);
[[nodiscard]] Recording read_recording(const std::filesystem::path& file);

}  // namespace thimble::host
