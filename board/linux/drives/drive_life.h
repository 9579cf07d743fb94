// The life of one drive, from the first frame to its last: Unknown -> Found -> Idle -> Enabled -> Running, and back by Braking, Silent or
// Fault. Who calls it: drive_bus.h, wish() before it sends and tick() after it has received, once a tick each. Sans I/O.
//
//   Unknown   no reply yet
//   Found     its version and configuration are read and compared with the file, its watchdog is proven
//   Idle      off, position known
//   Enabled   on with torque 0 and its base damping, for 20 ticks with fresh replies and a joint at rest
//   Running   follows begin_cycle()'s torque
//   Braking   torque 0 and base damping for 300 ms, then off
//   Silent    no reply for three ticks. Fault: see fault(). Both are left by clear() alone, and lead through Unknown to Idle, never farther.
#pragma once

#include <array>
#include <cstdint>

#include "board/linux/drives/drive_config.h"
#include "board/linux/drives/protocol.h"
#include "board/linux/drives/torque_witness.h"
#include "board/linux/drives/unwrap.h"

namespace thimble::board::drives {

enum class State : std::uint8_t { kUnknown, kFound, kIdle, kEnabled, kRunning, kBraking, kSilent, kFault };

enum class DriveFault : std::uint8_t {
  kNone,
#define DRIVE_FAULT(enumerator, name, sentence) enumerator,
#include "board/linux/drives/drive_faults.def"
#undef DRIVE_FAULT
};
[[nodiscard]] const char* name_of(DriveFault fault) noexcept;
[[nodiscard]] const char* sentence_of(DriveFault fault) noexcept;
[[nodiscard]] const char* name_of(State state) noexcept;

// What the frames of a tick were.
struct News {
  unsigned motions =
      0;  // positions received since the command of this tick; on the drive's own timer: since the last tick
  bool heard = false;   // any frame
  bool torque = false;  // a torque was reported
  bool malformed = false;
  bool rejected = false;
  bool other_motor = false;  // with this drive's reply id
};

class DriveLife {
 public:
  DriveLife(const DriveConfig& config, WatchdogProof proof, float period_s);

  enum class Wish : std::uint8_t {
    kDiscover,
    kAsk,
    kAskAgain,
    kNothing,
    kClear,
    kPoll,
    kEnable,
    kStandBy,
    kRun,
    kOff,
    kUnheard
  };
  [[nodiscard]] Wish wish() const noexcept;
  [[nodiscard]] const ConfigItem& item() const noexcept { return items_[item_]; }
  [[nodiscard]] unsigned enable_step() const noexcept { return step_; }

  // At the end of a tick. `asked_N_m`: the torque that the drive was told, with its damping.
  void tick(const News& news, Protocol& protocol, const Sample& sample, float asked_N_m) noexcept;
  void set_sent_enable_step(bool there_was_one) noexcept {
    step_ += there_was_one ? 1 : 0, enabling_ = there_was_one;
  }

  // Orders. Each acts from the next tick on.
  void enable() noexcept;                // in Idle
  void run() noexcept;                   // in Enabled, when ready()
  void brake() noexcept;                 // in Enabled and Running; others are off already
  void stop() noexcept;                  // in Enabled, Running and Braking: off at once, without a fault Idle
  void start_again() noexcept;           // in Idle: everything that is checked at power-on
  void clear() noexcept;                 // in Silent and Fault
  void fail(DriveFault fault) noexcept;  // the first one stays

  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] DriveFault fault() const noexcept { return fault_; }
  [[nodiscard]] bool ready() const noexcept { return state_ == State::kEnabled && settled_ >= kSettleTicks; }
  [[nodiscard]] bool powered() const noexcept {
    return state_ == State::kEnabled || state_ == State::kRunning || state_ == State::kBraking;
  }
  [[nodiscard]] double position_rad() const noexcept { return unwrap_.position_rad(); }
  [[nodiscard]] bool position_known() const noexcept { return position_known_; }
  [[nodiscard]] float torque_difference_N_m() const noexcept { return witness_.difference_N_m(); }
  [[nodiscard]] bool limit_unseen() const noexcept { return witness_.limited(); }
  [[nodiscard]] std::uint32_t config_hash() const noexcept {
    return hash_;
  }  // of the values read back, FNV-1a
  [[nodiscard]] const char* wrong_item() const noexcept {
    return wrong_item_;
  }  // kConfigDiffers, kConfigSilent; else null

 private:
  static constexpr unsigned kSettleTicks = 20;
  static constexpr unsigned kSilentTicks = 3;

  void enter(State state) noexcept;
  [[nodiscard]] Wish poll_or_off() const noexcept;
  void tick_unknown(const News& news, const Protocol& protocol) noexcept;
  void tick_found(Protocol& protocol, const Sample& sample) noexcept;
  void tick_watchdog_proof(const Sample& sample) noexcept;
  void check_start(const Sample& sample) noexcept;
  void tick_enabled(const Sample& sample) noexcept;
  void check_frames(const News& news) noexcept;
  void check_stage(const Sample& sample) noexcept;
  void check_clock(const News& news, const Sample& sample) noexcept;
  void take_position(const News& news, const Sample& sample) noexcept;
  void take_torque(const News& news, const Sample& sample, float asked_N_m) noexcept;
  void take_answer(double value) noexcept;
  [[nodiscard]] unsigned ticks(float time_s) const noexcept;

  DriveConfig config_;
  WatchdogProof proof_;
  float period_s_;
  std::array<ConfigItem, kMostItems> items_{};
  std::size_t item_count_ = 0;

  State state_ = State::kUnknown;
  DriveFault fault_ = DriveFault::kNone;
  unsigned in_state_ = 0;          // ticks
  Stage stage_ = Stage::kUnknown;  // as last reported
  unsigned missed_ = 0;            // ticks without a position
  unsigned doubled_ = 0;
  unsigned settled_ = 0;
  unsigned since_torque_ = 0;
  std::size_t item_ = 0;
  unsigned asked_ticks_ = 0;
  unsigned step_ = 0;
  unsigned off_ticks_ = 0;  // in Idle: how long the drive is told to switch off
  bool enabling_ = false;
  bool clearing_ = false;  // the drive's faults are being cleared, for kClearTicks
  bool cleared_ = false;   // since it was found
  bool proven_ = false;    // the watchdog
  unsigned proof_ticks_ = 0;
  bool position_known_ = false;
  bool counter_known_ = false;
  std::uint16_t counter_ms_ = 0;
  unsigned counter_stands_ = 0;
  Unwrap unwrap_;
  TorqueWitness witness_;
  std::uint32_t hash_ = 0;
  const char* wrong_item_ = nullptr;
};

}  // namespace thimble::board::drives
