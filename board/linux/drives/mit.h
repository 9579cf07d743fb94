// MIT mode (mini-cheetah, CubeMars AK, Damiao): packs commands, unpacks replies.
//
// A command has the motor's id (11 bits) and 8 bytes: a big-endian row of position 16, velocity 12, kp 12, kd 12, torque 12 bits. A code is a
// step of a range that is the drive's configuration, so both ends must have the same one. Units: rad, rad/s, N m at the output.
// No code means exactly zero: with a symmetric range zero lies between two codes (Dither makes the mean exact).
// The firmware's clients truncate to a code; nearest() stays within half a step.
// Sources: bgkatz/motorcontrol 3586419, neurobionics/TMotorCANControl, enactic/openarm_can 9866604, cmjang/DM_Control_Python 7da9387.
// Nothing here fails or allocates.
#pragma once

#include <cstdint>

#include "board/linux/drives/drive.h"

namespace thimble::board::drives::mit {

struct Range {
  float lo = 0, hi = 0;
  std::uint8_t bits = 12;

  [[nodiscard]] constexpr std::uint16_t top() const { return static_cast<std::uint16_t>((1U << bits) - 1U); }
  [[nodiscard]] constexpr float step() const { return (hi - lo) / static_cast<float>(top()); }
};

[[nodiscard]] std::uint16_t nearest(float value, const Range& range) noexcept;  // limited to the range
[[nodiscard]] std::uint16_t truncated(float value,
                                      const Range& range) noexcept;  // the same, as the firmware's clients do
[[nodiscard]] float value_of(std::uint16_t code, const Range& range) noexcept;

// The ranges of a drive, from its configuration (Damiao: registers 21 to 23).
struct Ranges {
  Range position{-12.5F, 12.5F, 16};
  Range velocity{-65, 65, 12};
  Range torque{-40, 40, 12};
  Range kp{0, 500, 12};
  Range kd{0, 5, 12};
};
[[nodiscard]] constexpr Ranges ranges_of(float position_rad, float velocity_rad_s, float torque_N_m) {
  Ranges ranges;
  ranges.position = {-position_rad, position_rad, 16};
  ranges.velocity = {-velocity_rad_s, velocity_rad_s, 12};
  ranges.torque = {-torque_N_m, torque_N_m, 12};
  return ranges;
}

struct Codes {
  std::uint16_t position = 0, velocity = 0, kp = 0, kd = 0, torque = 0;
};

// kp is limited to one code below its top, so that no command equals a magic frame.
[[nodiscard]] CanFrame pack(std::uint16_t id, const Codes& codes, bool fd) noexcept;
[[nodiscard]] Codes codes_of(const CanFrame& frame) noexcept;

// Carries the part of a torque that its codes cannot express over to the next tick: the mean torque is the one asked for.
class Dither {
 public:
  // The codes of a torque with damping. The velocity zero that cannot be sent gives kd times its error, which is taken off the torque.
  [[nodiscard]] Codes codes(const Command& command, const Ranges& ranges) noexcept;

 private:
  float owed_N_m_ = 0;
};

enum class Magic : std::uint8_t { kClearError = 0xFB, kEnable = 0xFC, kDisable = 0xFD, kZero = 0xFE };
[[nodiscard]] CanFrame pack_magic(std::uint16_t id, Magic magic, bool fd) noexcept;

// Damiao's registers: a frame to 0x7FF names the drive.
inline constexpr std::uint32_t kRegisterId = 0x7FF;
enum class Register : std::uint8_t {
  kMasterId = 7,
  kDriveId = 8,
  kTimeout = 9,  // steps of 50 us; 0: none
  kControlMode = 10,
  kPositionRange = 21,
  kVelocityRange = 22,
  kTorqueRange = 23,
  kBitRate = 35,
};
inline constexpr float kTimeoutStep_s = 50e-6F;
[[nodiscard]] CanFrame pack_read_register(std::uint16_t id, std::uint8_t number, bool fd) noexcept;
[[nodiscard]] CanFrame pack_write_register(std::uint16_t id, std::uint8_t number, std::uint32_t value,
                                           bool fd) noexcept;
[[nodiscard]] constexpr bool register_is_integer(std::uint8_t number) {
  return (number >= 7 && number <= 10) || (number >= 13 && number <= 16) || number == 35 || number == 36;
}

struct Unpacked {
  Reply reply = Reply::kOther;
  std::uint8_t register_number = 0;  // kAnswer
  std::uint32_t value = 0;           // kAnswer: four bytes as they are
};
// `asked`: the register whose answer is waited for, 0: none; the layout alone does not tell an answer from a motion reply.
// The drive's flavour decides on byte 0 (error and id), 6 and 7. Fields that the reply does not carry stay.
[[nodiscard]] Unpacked unpack(Kind kind, std::uint16_t id, std::uint16_t master_id, const Ranges& ranges,
                              std::uint8_t asked, const CanFrame& frame, Sample& sample) noexcept;

}  // namespace thimble::board::drives::mit
