// moteus (r4, n1, c1, x1) on CAN FD at 1/5 Mbit/s with bit rate switch: packs commands, unpacks replies.
//
// Ids: a command has source 0 (this host) and asks for a reply: 0x8000 | drive, always 29 bits. The reply is drive << 8, 11 bits up to drive
// 7 and 29 bits from 8 on. The payload is a row of subframes, padded with 0x50.
// Units on the wire: turns, turns/s, N m at the output. Position, velocity, torque and current are floats: int16 has steps of 10 mN m.
// Source: mjbots/moteus db1a762, fw/moteus_controller.cc, docs/protocol. Nothing here fails or allocates.
#pragma once

#include <cstdint>
#include <string_view>

#include "board/linux/drives/drive.h"

namespace thimble::board::drives::moteus {

inline constexpr std::uint8_t kLowestId = 1;
inline constexpr std::uint8_t kHighestId = 127;

// A torque with damping in the drive. Every frame sets mode 10, position NaN, velocity 0 and kp 0: writing the mode resets what is not
// written to full gain and position 0.
struct Motion {
  float torque_N_m = 0;          // feed-forward
  float kd_scale = 0;            // 0 to 1, of the drive's servo.pid_position.kd
  std::uint16_t timeout_ms = 0;  // of this command; 0: the drive's servo.default_timeout_s
};

enum class Query : std::uint8_t {
  kNone,
  kMotion,   // position, velocity: a reply of 12 bytes
  kAll,      // and torque, current, mode, voltage, temperature, fault: 32 bytes
  kCounted,  // and the millisecond counter: 32 bytes
};

[[nodiscard]] CanFrame pack_motion(std::uint8_t id, const Motion& motion, Query query) noexcept;
// Power stage off; clears a latched fault or timeout.
[[nodiscard]] CanFrame pack_stop(std::uint8_t id, Query query) noexcept;
// Asks without a command. It does not feed the drive's watchdog.
[[nodiscard]] CanFrame pack_query(std::uint8_t id, Query query) noexcept;
// Asks for the home state.
[[nodiscard]] CanFrame pack_home_query(std::uint8_t id) noexcept;
// A part of the diagnostic stream ("conf get servo.default_timeout_s\n"), at most kMostText characters, and a poll for the text that
// answers it. Empty: only the poll.
inline constexpr std::size_t kMostText = 57;
[[nodiscard]] CanFrame pack_text(std::uint8_t id, std::string_view text) noexcept;

struct Unpacked {
  Reply reply = Reply::kOther;
  std::uint16_t rejected_register = 0;
  std::uint16_t error = 0;
  std::string_view text;  // kAnswer: of the diagnostic stream; in the frame
};
// Fields that the reply does not carry stay. `frame` must outlive Unpacked::text.
[[nodiscard]] Unpacked unpack(std::uint8_t id, const CanFrame& frame, Sample& sample) noexcept;

// True for any frame that claims to come from the drive, on either width of id.
[[nodiscard]] constexpr std::uint32_t reply_id(std::uint8_t id) {
  return static_cast<std::uint32_t>(id) << 8U;
}

// Damping b [N m s/rad] as kd_scale for a drive whose kd is `kd` [N m per turn/s], at most 1.
[[nodiscard]] float kd_scale_of(float damping_N_m_s_rad, float kd) noexcept;

}  // namespace thimble::board::drives::moteus
