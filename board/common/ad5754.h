// Encodes motor currents for an AD5754R, a digital-to-analogue converter with four outputs of 16 bits (Analog
// Devices, data sheet rev. G): 24-bit frames, most significant byte first, SPI mode 1 (data sampled at the
// falling clock edge).
//
//   bit 23: 0 write   bits 21-19: register   bits 18-16: output   bits 15-0: data
//   register 0: voltage of an output   1: its range   2: power   3: control
//
// Pin BIN/2sCOMP is tied to ground: voltages are in two's complement, so the word 0 after power-on is 0 V.
// Pin LDAC is tied high: voltages take effect with the frame `load`, so all outputs of an arm change
// together. No heap, no OS; cannot fail.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "kinematics/limited.h"

namespace thimble::board {

class Ad5754 {
 public:
  using Frame = std::array<std::uint8_t, 3>;
  static constexpr std::size_t kOutputs = 4;
  static constexpr float kRange_V = 10.0F;  // set_range() selects -10 V to 10 V minus one step

  struct Channel {
    float volts_per_ampere = 1.0F;  // of the amplifier; may be negative
    float offset_V = 0.0F;          // voltage at which the amplifier drives no current
  };

  [[nodiscard]] static constexpr Frame set_range() noexcept {
    return frame(1, kAll, 4);
  }  // +-10 V, all outputs
  [[nodiscard]] static constexpr Frame power_up() noexcept {
    return frame(2, 0, 0x1F);  // four outputs and the reference
  }
  [[nodiscard]] static constexpr Frame load() noexcept { return frame(3, 5, 0); }
  [[nodiscard]] static constexpr Frame voltage(std::uint8_t output, std::int16_t word) noexcept {
    return frame(0, output, static_cast<std::uint16_t>(word));
  }

  // `which` is true if the voltage was clamped to the range. A current that is not finite gives offset_V,
  // which is zero current.
  [[nodiscard]] static kinematics::Limited<std::int16_t, bool> word(const Channel& channel,
                                                                    float current_A) noexcept {
    float steps = (current_A * channel.volts_per_ampere + channel.offset_V) * (32768.0F / kRange_V);
    const bool finite = std::isfinite(steps);
    if (!finite) steps = channel.offset_V * (32768.0F / kRange_V);
    if (steps > 32767.0F) return {INT16_MAX, true};
    if (steps < -32768.0F) return {INT16_MIN, true};
    return {static_cast<std::int16_t>(std::lround(steps)), !finite};
  }

 private:
  static constexpr std::uint8_t kAll = 4;

  [[nodiscard]] static constexpr Frame frame(unsigned reg, unsigned output, std::uint16_t data) noexcept {
    return {static_cast<std::uint8_t>(reg << 3U | output), static_cast<std::uint8_t>(data >> 8U),
            static_cast<std::uint8_t>(data & 0xFFU)};
  }
};

}  // namespace thimble::board
