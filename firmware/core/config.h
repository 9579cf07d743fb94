// What a board tells the controller, and what the two exchange in every tick: the Config once, Inputs and Outputs each period. Units: SI.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "control/scene/limits.h"
#include "control/scene/pauses.h"
#include "firmware/core/modes.h"
#include "firmware/link/services.h"
#include "kinematics/arm_data.h"
#include "kinematics/base_pose.h"

namespace thimble::firmware {

class ForceSource;
namespace link {
class ByteWriter;
}

// A routine of the board's own: that of a simulated board which breaks its hardware (service 31, routine 02F0).
class BoardRoutine {
 public:
  // In the background. False: the arguments are wrong.
  [[nodiscard]] virtual bool start(std::span<const std::uint8_t> arguments) noexcept = 0;

 protected:
  ~BoardRoutine() = default;
};

// Data identifiers of the board's own: what only boards of its kind can tell.
class BoardData {
 public:
  // In the background. False: not one of them.
  [[nodiscard]] virtual bool read(std::uint16_t id, link::ByteWriter& out) const noexcept = 0;

 protected:
  ~BoardData() = default;
};

using control::kMaxArms;
inline constexpr std::size_t kJoints = kinematics::kMaxJoints;  // of an arm, at most
using Axes = kinematics::PerAxis<float>;  // one number an axis, 0 beyond those of the arm
// Of an arm: with less the god object may not get on over an ordinary mesh (no_tunnel.with_work_for_100).
inline constexpr std::uint32_t kLeastWork = 100;

struct ArmConfig {
  const char* model = "premium-1.5";  // by its name among Config::arms_known and those built in
  // The arm image of the store (firmware/store/arm_store.h), checked and 8-byte aligned; it goes before `model`. Empty: there is none.
  std::span<const std::byte> image{};
  kinematics::BasePose base;  // default: the world's origin is at the tip's home position
  // True: homing ends at the tick in which ArmInputs::index is set. False: the user holds the arm in its home
  // pose and homing takes the next sample.
  bool has_index = false;
  // The encoders' receivers report a lost line (ArmEvidence::line_loss), so a joint that stands still is no reason for a probe (encoder_probe.h).
  bool has_line_loss = false;
};

struct Config {
  float period_s = 1.0F / 4000.0F;  // 40 us to 20 ms
  std::uint8_t arm_count = 1;       // 1 to kMaxArms
  // What rendering may do in a tick, in the units of control/work.h, at least kLeastWork an arm: a tick has a bound (docs/time.md).
  std::uint32_t work_units = 4000;
  std::array<ArmConfig, kMaxArms> arm{};
  std::uint8_t node_id = 1;  // on the link, 1 to 127
  // The largest block of an upload. Less where the store is slow, because the host waits for the answer to each block.
  std::uint16_t block_bytes = link::kMaxBlockBytes;
  bool classic_can = false;  // the board's bus has no FD: hosts are told to ask in classic frames
  std::uint32_t bus_bits_per_s =
      0;  // bit rate of a classic bus; a recording that it cannot carry is refused. 0: not known
  const char* serial_number = "none";  // text for the host
  const char* board = "none";          // the board that the image is for, by its folder in board/
  const char* reset_reason = "";  // why it started: "power_on", "watchdog", "host", "crash"; empty: not known
  std::uint32_t utc_s =
      0;  // the time at start, seconds since 1970, of a clock that runs while the board is off; 0: not known
  // What the board lacks for safe motion, as found at start ("no_realtime_priority,no_watchdog"): arming is refused, and
  // the refusal contains this text. Empty: nothing.
  const char* lacks = "";
  // Called about every 20 us during long work of the background (checking an image). A board without a tick interrupt
  // runs the tick there. Null: not needed.
  control::Pause pause = nullptr;
  // Arms that `arm` may name, before those of kinematics/built_in_arms.h. They must outlive the controller.
  std::span<const kinematics::ArmData> arms_known{};
  BoardRoutine* inject = nullptr;         // of a simulated board; must outlive the controller
  const BoardData* board_data = nullptr;  // null: none; must outlive the controller
  // Force sources in front of those of firmware/sources/sources.h: of a board, or of a test. They must outlive the controller.
  std::span<ForceSource* const> sources{};
};

// What a board may measure of an arm besides its counts; what it does not measure stays as it is here.
struct ArmEvidence {
  static constexpr float kNot = std::numeric_limits<float>::quiet_NaN();
  static constexpr std::array<float, kJoints> kNone{kNot, kNot, kNot, kNot, kNot, kNot, kNot};

  bool line_loss = false;  // an encoder's receiver reports a broken wire, a short or no supply
  std::array<float, kJoints> current_A = kNone;  // of the motors, as ArmOutputs::current_A
  std::array<float, kJoints> motor_C = kNone;    // of the windings
  float supply_V = kNot;                         // of the motor drives
};

struct ArmInputs {
  std::array<std::uint32_t, kJoints> counts{};  // counter registers as they are (as wide as the arm says)
  std::uint64_t sample_tick = 0;                // Inputs::tick in which they were latched
  bool index = false;                           // the arm stands at its index
  bool drive_fault = false;
  ArmEvidence evidence;
};

struct Inputs {
  // Periods since the loop started, lost ones included: it rises by 1 a tick, by more after an overrun.
  std::uint64_t tick = 0;
  std::uint64_t time_us = 0;  // the board's monotonic clock at the start of this tick
  float last_tick_us = 0;     // how long the tick before took; 0: not known
  float late_us = 0;          // how long after its time this tick began, for telemetry
  bool e_stop = false;        // true: pressed, or its wire open
  bool dead_man = false;      // true: held (a board without one says true)
  std::array<ArmInputs, kMaxArms> arm;
};

struct ArmOutputs {
  std::array<float, kJoints> current_A{};
  bool enable = false;  // of the motor drives
};

struct Outputs {
  Mode mode = Mode::kDisarmed;
  bool event = false;  // level of the event line (firmware/core/marks.h)
  std::array<ArmOutputs, kMaxArms> arm;
};

}  // namespace thimble::firmware
