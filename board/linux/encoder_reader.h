// The encoders of one arm, which the servo reads once per tick. Implementations: the kernel's counter
// subsystem (counter_encoder.h), and decoding of GPIO edges for boards without counters (gpio_encoder.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "board/linux/drive_wiring.h"

namespace thimble::board {

struct EncoderSample {
  std::array<std::uint32_t, kArmJoints>
      counts{};               // raw counter registers; of joints that it does not read: 0
  std::uint64_t time_ns = 0;  // CLOCK_MONOTONIC when they were latched
};

class EncoderReader {
 public:
  virtual ~EncoderReader() = default;
  // Empty if there is no new sample since the last call, or the device failed; the controller then detects
  // the old sample by its age. Never waits.
  [[nodiscard]] virtual std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept = 0;
};

}  // namespace thimble::board
