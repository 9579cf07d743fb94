// What must survive a restart, a crash and power-off besides scenes and parameters: the heat of the motors, and how often the board has
// crashed with what it runs. Called from the background; the journal keeps it.
//
// Heat. A record is written when the motors go on, every 5 s while they are on and warm (every minute while they are cold), when they go
// off, and when they have cooled by 2 K. A start resumes from the newest record with the least cooling that is consistent with the time
// off: none if no clock tells, neither the board's (Config::utc_s) nor a host's (tell_time()). If the motors were on, the start adds all
// heat that the limits allow in kUnrecorded_s.
//
// Crashes. A start that follows three in a row which ended by watchdog or crash within kTrial_s, of the start or of taking a scene or a
// parameter set into use, leaves out what has never run for kTrial_s; if both have, the scene, and after three more crashes the
// parameters. What is left out stays left out until another scene is uploaded, or the parameters are saved again.
#pragma once

#include <cstdint>

#include "firmware/core/core.h"
#include "firmware/link/can_frame.h"
#include "firmware/params.h"
#include "firmware/store/journal.h"

namespace thimble::firmware {

class PersistentState {
 public:
  static constexpr float kTrial_s = 600;
  static constexpr std::uint8_t kCrashes = 3;
  // From the newest record to a crash: an interval, and the longest cycle of the background that a board's watchdogs allow (10 s, of
  // board/linux). More would not be hotter: the winding is at its limit by then.
  static constexpr float kUnrecorded_s = 15;
  static constexpr std::uint32_t kRefresh_s = 60;           // motors on and cold
  static constexpr std::uint32_t kClockError_s = 60;        // by which two hosts' clocks may differ
  static constexpr std::uint32_t kLatest_s = 4102444800;    // 2100: nor has one that says more
  static constexpr std::uint32_t kEarliest_s = 1704067200;  // 2024: a clock that says less has not been set

  PersistentState(Storage& storage, Core& core) noexcept : journal_(storage), core_(core) {}

  // What is in the stores. The sequence numbers tell when a scene or parameters are taken into use.
  struct InStore {
    std::uint32_t scene_sequence = 0;
    std::uint32_t params_sequence = 0;
    JournalRecord::InUse crc;
  };

  // --- At start, in this order: reads the journal, and returns what is left out; resumes the heat, by the parameters, and writes a record.
  [[nodiscard]] JournalRecord::InUse begin(const InStore& in_store, bool crashed) noexcept;
  void resume_heat(const Params& params, std::uint32_t utc_s) noexcept;

  // --- Then
  // Writes a record where one is due.
  void poll(const InStore& in_store, link::Micros now) noexcept;
  // A host's clock. Cools the motors if it shows that the board was off.
  void tell_time(std::uint32_t utc_s, link::Micros now) noexcept;
  [[nodiscard]] const JournalRecord::InUse& set_aside() const noexcept { return record_.set_aside; }
  // Seconds since 1970; 0: not known.
  [[nodiscard]] std::uint32_t utc_at_start() const noexcept { return start_utc_s_; }
  [[nodiscard]] std::uint32_t utc_s(link::Micros now) noexcept;
  [[nodiscard]] std::uint32_t up_s(link::Micros now) noexcept;  // since the first poll
  // How often the board has started, this time included. Wraps.
  [[nodiscard]] std::uint16_t starts() const noexcept { return record_.starts; }

 private:
  [[nodiscard]] bool due(bool motors_on, link::Micros now) const noexcept;
  [[nodiscard]] bool keeps_heat_of_start() const noexcept {
    return start_utc_s_ == 0 && before_utc_s_ != 0 && !motors_were_on_;
  }
  [[nodiscard]] std::uint32_t off_s() const noexcept;  // at least
  void note(const InStore& in_store, link::Micros now) noexcept;
  void write(bool motors_on, link::Micros now) noexcept;
  void append() noexcept;  // record_; where the store does not take it, no arm may be armed
  [[nodiscard]] link::Micros uptime_us(link::Micros now) noexcept;

  Journal journal_;
  Core& core_;
  JournalRecord record_;            // as written last, or to be written
  MotorsHeat heat_{};               // as of the tick, 0.1 s ago at most
  MotorsHeat at_start_{};           // before any cooling by a host's clock
  std::uint32_t before_utc_s_ = 0;  // at_start_ is the heat of this time, or more; 0: not known when
  std::uint32_t start_utc_s_ = 0;   // as the clock says; 0: not known yet
  // What the journal calls the start, once start_utc_s_ is known: this, or the time of the record before it where the clock went backwards.
  std::uint32_t heat_start_utc_s_ = 0;
  bool motors_were_on_ = false;  // since start
  bool news_ = false;            // other than heat
  bool failed_ = false;          // to write
  bool polled_ = false;
  InStore in_store_;
  link::Micros started_us_ = 0, taken_us_ = 0, written_us_ = 0;
};

}  // namespace thimble::firmware
