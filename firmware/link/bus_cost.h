// What frames cost a CAN bus, in bits: for the tables of docs/link.md, and for a recording that a bus cannot carry.
//
// Bit stuffing is counted at its most: one bit after every four (ISO 11898-1), so a real bus carries a little more.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/link/messages.h"

namespace thimble::firmware::link {

// Of a classic frame with an 11-bit identifier, with the pause behind it.
[[nodiscard]] constexpr std::uint32_t classic_bits(std::size_t bytes) noexcept {
  const auto data = static_cast<std::uint32_t>(8 * bytes);
  return 47 + data + (34 + data - 1) / 4;
}

// Of a tick of a recording, for an arm of so many joints; without the check.
[[nodiscard]] constexpr std::uint32_t recording_frames(std::size_t joints) noexcept {
  return static_cast<std::uint32_t>((joints + kClassicCounts - 1) / kClassicCounts);
}

// Of a recording in classic frames, in a second.
[[nodiscard]] constexpr float recording_bits_per_s(std::size_t arms, std::size_t joints,
                                                   float rate_Hz) noexcept {
  constexpr float kChecks = 1.0F / 16.0F;  // in a tick
  const auto counts = static_cast<float>(arms * recording_frames(joints));
  return (counts + kChecks) * static_cast<float>(classic_bits(kClassicDataBytes)) * rate_Hz;
}

// True when a classic bus of this bit rate carries it. A rate of 0 is not known: nothing is said against it.
[[nodiscard]] constexpr bool recording_fits(std::size_t arms, std::size_t joints, float rate_Hz,
                                            std::uint32_t bits_per_s) noexcept {
  return bits_per_s == 0 || recording_bits_per_s(arms, joints, rate_Hz) <= static_cast<float>(bits_per_s);
}

}  // namespace thimble::firmware::link
