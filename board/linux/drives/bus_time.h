// How long the frames of a tick occupy a bus, at worst, and whether a rate can be kept.
//
// Called at start and by tools, never in the tick. Bits are those of a frame with the most stuff bits possible and three bits of interframe
// space (classic: Davis, Burns, Bril and Lukkien 2007; FD: ISO 11898-1, counted here). Arbitration among the frames costs nothing more, since
// only one is sent at a time. What comes on the drive's own timer every 10 ms or less often is not counted: the rest of the bus is for it.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "board/linux/drives/drive.h"

namespace thimble::board::drives {

struct BusRate {
  float nominal_bits_s = 1e6F;
  float data_bits_s = 5e6F;  // of FD frames with bit rate switch
};

enum class Stuffing : std::uint8_t { kMost, kNone };

// A frame on the bus. `extended`: 29-bit id, for FD frames only (no drive here has classic ones).
[[nodiscard]] float frame_time_us(std::uint8_t size, bool fd, bool extended, const BusRate& rate = {},
                                  Stuffing stuffing = Stuffing::kMost) noexcept;

// What a tick exchanges with one drive.
enum class Exchange : std::uint8_t {
  kMoteusAll,        // command 32, reply 32 bytes; drive 1 to 7 (from 8 on 23 us more)
  kMoteusMotion,     // 24 and 12
  kOdriveCyclic,     // torque 4, estimates 8 on the drive's timer
  kOdriveDamped,     // torque with damping 8, estimates 8 on its timer
  kOdriveRequested,  // torque with damping 8, remote request, estimates 8
  kMiniCheetah,      // 8 and 7
  kEightBytes,       // 8 and 8, classic: Damiao, CubeMars
  kEightBytesFd,     // Damiao FD
};
[[nodiscard]] float exchange_time_us(Exchange exchange, Stuffing stuffing = Stuffing::kMost,
                                     const BusRate& rate = {}) noexcept;
[[nodiscard]] inline float bus_time_us(Exchange exchange, unsigned drives,
                                       const BusRate& rate = {}) noexcept {
  return static_cast<float>(drives) * exchange_time_us(exchange, Stuffing::kMost, rate);
}

inline constexpr float kMostLoad = .8F;  // of a tick

struct BusLoad {
  float time_us = 0;
  float share = 0;  // of the tick
  bool fits = false;
  // "three ODrives at 1 kHz need 69 % of can0"; where it does not fit, with what to do.
  std::array<char, 200> text{};

  [[nodiscard]] std::string_view sentence() const noexcept { return text.data(); }
};
// All drives of one bus at `rate_Hz` ticks a second.
[[nodiscard]] BusLoad bus_load(std::string_view interface, std::span<const Exchange> drives, float rate_Hz,
                               const BusRate& rate = {}) noexcept;

}  // namespace thimble::board::drives
