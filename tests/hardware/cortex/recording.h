// A recorded run: a scene, and the encoder counts of every tick from power-on. record_run makes it, replay() feeds it to a
// controller. Little-endian, as it lies in memory:
//
//   RecordingHeader, the scene image, padding to a multiple of 8, arms x 3 counts for each tick
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

namespace thimble::test {

struct RecordingHeader {
  std::uint32_t magic;
  std::uint32_t ticks;
  std::uint32_t arms;
  float period_s;
  std::uint32_t image_bytes;
  std::uint32_t home_before;  // the tick before which the command came
  std::uint32_t arm_before;
  std::array<std::array<float, 3>, 2> home_m;  // of each arm's base
  std::array<char, 28> model;                  // of the arms, with its end
};
static_assert(sizeof(RecordingHeader) == 80 && sizeof(RecordingHeader) % 8 == 0);
inline constexpr std::uint32_t kRecordingMagic = 0x52494854;  // "THIR"

struct Recording {
  RecordingHeader header{};
  std::span<const std::byte> image;
  std::span<const std::byte> counts;

  [[nodiscard]] std::uint32_t count(std::uint32_t tick, std::size_t arm, std::size_t joint) const noexcept {
    std::uint32_t value = 0;
    std::memcpy(&value, counts.data() + (((tick * header.arms) + arm) * 3 + joint) * sizeof(value),
                sizeof(value));
    return value;
  }
};

[[nodiscard]] inline std::size_t padded(std::size_t bytes) noexcept { return (bytes + 7) / 8 * 8; }

// False: not a recording, or cut off.
[[nodiscard]] inline bool open_recording(std::span<const std::byte> bytes, Recording& recording) noexcept {
  if (bytes.size() < sizeof(RecordingHeader)) return false;
  RecordingHeader& header = recording.header;
  std::memcpy(&header, bytes.data(), sizeof(header));
  if (header.magic != kRecordingMagic || header.arms < 1 || header.arms > 2) return false;
  const std::size_t image_end = sizeof(header) + padded(header.image_bytes);
  const std::size_t counts = std::size_t{header.ticks} * header.arms * 3 * sizeof(std::uint32_t);
  if (bytes.size() < image_end || bytes.size() - image_end < counts) return false;
  recording.image = bytes.subspan(sizeof(header), header.image_bytes);
  recording.counts = bytes.subspan(image_end, counts);
  return true;
}

}  // namespace thimble::test
