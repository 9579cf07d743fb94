// ODrive CANSimple, firmware 0.5 and 0.6: packs commands, unpacks messages. Classic frames, 11-bit id = node << 5 | command.
//
// A request, an answer and an echo of this host's own frame share an id: an answer is never a remote frame and has 8 bytes.
// Units on the wire: turns, turns/s and N m of the motor's shaft. The two firmwares give the ids 0x01, 0x03, 0x15, 0x19, 0x1C and 0x1D
// other meanings, so unpack() is told which one answers (get_version(): an answer is 0.6, silence 0.5).
// Source: odriverobotics/ODrive f9b5419 (0.5.6), ros_odrive and ODriveResources (0.6). Nothing here fails or allocates.
#pragma once

#include <cstdint>

#include "board/linux/drives/drive.h"

namespace thimble::board::drives::odrive {

enum class Message : std::uint8_t {
  kVersion = 0x00,  // 0.6
  kHeartbeat = 0x01,
  kEmergencyStop = 0x02,
  kError = 0x03,
  kRxSdo = 0x04,  // 0.6
  kTxSdo = 0x05,  // 0.6
  kAxisState = 0x07,
  kEstimates = 0x09,
  kControllerModes = 0x0B,
  kInputVelocity = 0x0D,
  kInputTorque = 0x0E,
  kLimits = 0x0F,
  kIq = 0x14,
  kTemperature = 0x15,  // 0.6
  kReboot = 0x16,
  kSupply = 0x17,
  kClearErrors = 0x18,
  kVelocityGains = 0x1B,
  kTorques = 0x1C,  // 0.6
};

enum class AxisState : std::uint8_t { kIdle = 1, kClosedLoop = 8 };
enum class ControlMode : std::uint8_t { kTorque = 1, kVelocity = 2 };

inline constexpr std::uint8_t kHighestNode = 62;  // 63: a drive of 0.6 without an address
inline constexpr std::uint32_t kWatchdogError05 = 0x800;
inline constexpr std::uint32_t kPartError05 =
    0x80000000;  // ours: motor, encoder or controller report an error, the axis none
inline constexpr std::uint32_t kWatchdogError06 = 0x01000000;

[[nodiscard]] constexpr std::uint32_t id_of(std::uint8_t node, Message message) {
  return static_cast<std::uint32_t>(node) << 5U | static_cast<std::uint32_t>(message);
}

// A remote frame: the drive answers at once. It feeds the drive's watchdog like any frame to the node.
[[nodiscard]] CanFrame pack_request(std::uint8_t node, Message message) noexcept;
[[nodiscard]] CanFrame pack_axis_state(std::uint8_t node, AxisState state) noexcept;
// Input mode passthrough: no ramp, no filter.
[[nodiscard]] CanFrame pack_controller_modes(std::uint8_t node, ControlMode mode) noexcept;
[[nodiscard]] CanFrame pack_torque(std::uint8_t node, float torque_N_m) noexcept;
// Velocity 0 with a torque on top: with ControlMode::kVelocity the drive damps with its velocity gain.
[[nodiscard]] CanFrame pack_damped_torque(std::uint8_t node, float torque_N_m) noexcept;
// The velocity gain that damps; the integrator is 0.
[[nodiscard]] CanFrame pack_damping(std::uint8_t node, float damping_N_m_s_rad) noexcept;
[[nodiscard]] CanFrame pack_limits(std::uint8_t node, float velocity_rad_s, float current_A) noexcept;
// firmware06: it has one byte there.
[[nodiscard]] CanFrame pack_clear_errors(std::uint8_t node, bool firmware06) noexcept;
[[nodiscard]] CanFrame pack_emergency_stop(std::uint8_t node) noexcept;
// 0.6: asks for the value of an endpoint, whose number is in the file of the firmware's release.
[[nodiscard]] CanFrame pack_read_endpoint(std::uint8_t node, std::uint16_t endpoint) noexcept;

struct Version {
  std::uint8_t protocol = 0;
  std::uint8_t major = 0, minor = 0, revision = 0;
};

struct Unpacked {
  Reply reply = Reply::kOther;
  Message message = Message::kHeartbeat;
  Version version;             // kVersion
  std::uint16_t endpoint = 0;  // kTxSdo
  std::uint32_t value = 0;     // kTxSdo: four bytes as they are
};
// Fields that the message does not carry stay. torque_constant_N_m_A: 0.5 reports the current alone, the torque is computed from it.
[[nodiscard]] Unpacked unpack(std::uint8_t node, bool firmware06, float torque_constant_N_m_A,
                              const CanFrame& frame, Sample& sample) noexcept;

}  // namespace thimble::board::drives::odrive
