// The encoders of one arm, as the servo reads them once a tick. Implementations: counters of the kernel's counter
// subsystem (counter_encoder.h), and decoding by GPIO edges for boards without any (gpio_encoder.h).
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace thimble::board {

struct EncoderSample {
  std::array<std::uint32_t, 3> counts{};  // counter registers as they are
  std::uint64_t time_ns = 0;              // CLOCK_MONOTONIC when they were latched
};

class EncoderReader {
 public:
  virtual ~EncoderReader() = default;
  // Nothing: no sample since the last call, or the device failed; the controller sees the last one grow old. Never waits.
  [[nodiscard]] virtual std::optional<EncoderSample> read(std::uint64_t now_ns) noexcept = 0;
};

}  // namespace thimble::board
