// What the arm's file says of each drive, and what a drive of its kind can do. Plain data.
//
// Units: SI, at the drive's shaft (drive.h). Called at start only; nothing here is read in the tick but by drive_bus.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string_view>

#include "board/linux/drives/bus_time.h"
#include "board/linux/drives/drive.h"
#include "board/linux/drives/mit.h"

namespace thimble::board::drives {

// A value in the drive that must equal the file's.
struct ConfigItem {
  const char* name;          // moteus: as `conf get` takes it; of ODrive and Damiao for messages only
  std::uint16_t number = 0;  // ODrive 0.6: endpoint; Damiao: register
  bool integer = false;      // the four bytes are an integer (a bool too), not a float
  double value = 0;
};
inline constexpr std::size_t kMostItems = 16;
inline constexpr std::size_t kMostDrives = 8;  // of a bus

struct DriveConfig {
  Kind kind = Kind::kMoteus;
  std::uint8_t id = 1;         // moteus 1 to 127, ODrive 0 to 62, MIT mode the motor's id
  std::uint16_t reply_id = 0;  // MIT mode: of this motor alone
  mit::Ranges ranges;          // MIT mode
  float watchdog_s = .015F;    // 10 to 20 ticks
  float peak_torque_N_m = 1;
  float top_speed_rad_s = 30;  // a faster step of the position is a jump
  float base_damping_N_m_s_rad =
      0;                // while the drives are enabled and when they are dropped; ODrive has no other
  float moteus_kd = 0;  // servo.pid_position.kd, N m per turn/s
  int moteus_timeout_mode =
      12;  // servo.timeout_mode: 12 damps with the damping last sent, 15 shorts the phases
  float torque_constant_N_m_A = 1;  // ODrive 0.5
  float current_limit_A = 10;       // ODrive
  float torque_lag_s = .001F;       // current loop and filters, from a command to the torque reported
  bool request_estimates = false;   // ODrive: asked for each tick, instead of on its own timer
  float reply_period_s = 0;         // ODrive's timer; 0: every tick
  float least_reply_us =
      0;  // a reply that comes sooner after its command is one of the tick before; 0: not known (bus_time.h: unstuffed)
  bool short_frames = false;                                     // moteus: telemetry every tenth tick
  std::uint8_t needed_home_state = 0;                            // moteus
  float start_lo_rad = -std::numeric_limits<float>::infinity();  // of the first position
  float start_hi_rad = std::numeric_limits<float>::infinity();
  bool watchdog_proven = false;  // mini-cheetah and CubeMars cannot tell: it was tried on this drive, by hand
  std::span<const ConfigItem> items{};  // besides those that its kind always has (kind_items())
};

// What the drive exchanges in a tick, for bus_load(): with DriveConfig::short_frames that of nine ticks out of ten.
[[nodiscard]] Exchange exchange_of(const DriveConfig& config) noexcept;

enum class AbsoluteKind : std::uint8_t { kNone, kRotorTurn, kOutputTurn, kOutput };

struct Capabilities {
  float torque_step_N_m = 0;       // 0: none to speak of
  bool has_damping = false;        // of a value of each tick
  bool has_fixed_damping = false;  // of base_damping_N_m_s_rad alone
  bool damps_on_silence = false;
  float least_watchdog_s = 0;
  float most_watchdog_s = 0;
  AbsoluteKind absolute = AbsoluteKind::kNone;
};
[[nodiscard]] Capabilities capabilities_of(const DriveConfig& config) noexcept;

// The items that are read back from every drive of the kind: its watchdog, and what gives the frames their meaning.
struct KindItems {
  std::array<ConfigItem, kMostItems> items{};
  std::size_t count = 0;
};
[[nodiscard]] KindItems kind_items(const DriveConfig& config) noexcept;

// What is wrong with the drives of a bus.
struct WrongDrive {
  std::string_view what{};  // a sentence; empty: nothing
  std::string_view key{};   // of the drive in the board's configuration; empty: the drive itself
  float least_s = 0;        // of a watchdog: what is allowed
  float most_s = 0;
  std::size_t drive = 0;
  std::size_t other = 0;  // the drive that has the same id; `drive`: there is none
};
[[nodiscard]] WrongDrive find_wrong(std::span<const DriveConfig> drives, float period_s) noexcept;
// Its sentence alone.
[[nodiscard]] std::string_view check_drives(std::span<const DriveConfig> drives, float period_s) noexcept;

}  // namespace thimble::board::drives
