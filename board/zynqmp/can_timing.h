// The bit timing of a Zynq CAN controller (UG1085 chapter 20): one bit is 1 + TS1 + TS2 quanta of `prescaler`
// clocks.
#pragma once

#include <cstdint>
#include <optional>

namespace thimble::board {

struct CanTiming {
  std::uint32_t prescaler = 0;  // 1 to 256
  std::uint32_t segment_1 = 0;  // 1 to 16 quanta, up to the sample point
  std::uint32_t segment_2 = 0;  // 1 to 8 quanta, after the sample point
  std::uint32_t jump = 0;       // 1 to 4, resynchronisation

  [[nodiscard]] constexpr std::uint32_t brpr() const noexcept { return prescaler - 1; }
  [[nodiscard]] constexpr std::uint32_t btr() const noexcept {
    return (jump - 1) << 7U | (segment_2 - 1) << 4U | (segment_1 - 1);
  }
};

// Timing for the exact bit rate, with the sample point as close to 80 % as possible; of several solutions the
// one with the most quanta. Empty: the clock cannot be divided to this bit rate.
[[nodiscard]] constexpr std::optional<CanTiming> can_timing(std::uint32_t clock_Hz,
                                                            std::uint32_t bitrate) noexcept {
  constexpr std::uint32_t kMostQuanta = 25, kFewestQuanta = 8;
  if (bitrate == 0 || clock_Hz % bitrate != 0) return std::nullopt;
  const std::uint32_t clocks = clock_Hz / bitrate;
  for (std::uint32_t quanta = kMostQuanta; quanta >= kFewestQuanta; --quanta) {
    if (clocks % quanta != 0 || clocks / quanta > 256) continue;
    const std::uint32_t segment_2 = (quanta + 2) / 5;  // a fifth, rounded; at most 5 here
    const std::uint32_t segment_1 = quanta - 1 - segment_2;
    if (segment_1 > 16) continue;
    return CanTiming{clocks / quanta, segment_1, segment_2, segment_2 < 4 ? segment_2 : 4};
  }
  return std::nullopt;
}

}  // namespace thimble::board
