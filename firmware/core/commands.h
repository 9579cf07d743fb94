// Commands from the background to the tick, and the table that says for each command in which modes it is accepted and which conditions
// refuse it. The background checks against the last tick (request()); the tick checks again when it executes (decide.cpp), because
// something may have happened in between.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "firmware/core/conditions.h"
#include "firmware/core/modes.h"
#include "firmware/core/setup.h"
#include "firmware/core/status.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/request.h"
#include "firmware/exchange/word.h"
#include "firmware/params.h"
#include "firmware/sources/sources.h"

namespace thimble::firmware {

struct CommandRow {
  // When the command has nothing to do: then it is accepted, and not posted to the tick.
  enum class NothingToDo : std::uint8_t { kNever, kWhenArmed, kWithoutFault };

  Command command;
  NothingToDo nothing_to_do;
  Modes accepted_in;        // by the background; in other modes it is refused with kWrongMode
  Conditions refused_by;    // in the background
  Modes executed_in;        // by the tick; in other modes it has no effect
  Conditions prevented_by;  // in the tick
};

inline constexpr Modes kAtRest = only(Mode::kDisarmed) | only(Mode::kReady);
// Causes of faults that are conditions too: while one lasts, the fault cannot be cleared.
inline constexpr Conditions kCauses = kEStopPressed | kDriveFault | kBadConfig;

inline constexpr std::array<CommandRow, 7> kCommandTable = {{
    {Command::kHome, CommandRow::NothingToDo::kNever,  //
     kAtRest | only(Mode::kFaulted), kFaultLatched | kEncoderStale | kBadConfig, kAtRest, 0},
    {Command::kArm, CommandRow::NothingToDo::kWhenArmed,  //
     kAllModes, kAnyCondition, only(Mode::kReady), kAnyCondition},
    {Command::kDisarm, CommandRow::NothingToDo::kNever,  //
     kAllModes, 0, kAllModes, 0},
    {Command::kClear, CommandRow::NothingToDo::kWithoutFault,  //
     only(Mode::kFaulted), kCauses, only(Mode::kFaulted), kCauses},
    // A released dead-man switch has already disarmed the arm. conditions.cpp adds the conditions that refuse only moves.
    {Command::kMove, CommandRow::NothingToDo::kNever,  //
     only(Mode::kArmed), kAnyCondition & ~kDeadManOpen, kAllModes, 0},
    {Command::kEndMove, CommandRow::NothingToDo::kNever,  //
     kAllModes, 0, kAllModes, 0},
    {Command::kRecord, CommandRow::NothingToDo::kNever,  //
     kAtRest, kFaultLatched | kEncoderStale | kNoScene | kBadConfig, kAtRest, kFaultLatched},
}};

// Null for kNone and kStop, which have no conditions.
[[nodiscard]] constexpr const CommandRow* find_command(Command command) noexcept {
  for (const CommandRow& row : kCommandTable)
    if (row.command == command) return &row;
  return nullptr;
}

// Whether the tick executes it.
[[nodiscard]] constexpr bool executes(Command command, Mode mode, Conditions unmet) noexcept {
  const CommandRow* row = find_command(command);
  return row != nullptr && contains(row->executed_in, mode) && (unmet & row->prevented_by) == 0;
}

class Commands {
 public:
  Commands(const Setup& setup, const Params& params, const Status& status, Sources& sources) noexcept
      : setup_(setup), params_(params), status_(status), sources_(sources) {}

  // --- background
  // Posts a command for the next tick, or returns the conditions that refuse it (0: posted). A later command replaces one that no tick
  // has taken yet. Nothing replaces a stop or a disarm; until a tick has obeyed it, what would set the arm in motion is refused.
  [[nodiscard]] Conditions request(Command command) noexcept;
  [[nodiscard]] bool disarm_due() const noexcept { return disarms_.get() != status_.disarms(); }
  [[nodiscard]] bool pending() const noexcept { return channel_.pending(); }  // posted, and not executed yet
  // A guarded move: its values are within the limits.
  [[nodiscard]] bool move_in_range(const MoveOrder& order) const noexcept;
  // Posts it, or returns what refuses it. Its values are in range.
  [[nodiscard]] Conditions request_move(const MoveOrder& order) noexcept;
  // The same of an order for the axes.
  [[nodiscard]] bool axes_in_range(const link::AxisOrder& order) const noexcept;
  [[nodiscard]] Conditions request_axes(const link::AxisOrder& order) noexcept;
  // Where the host says that an arm is: of the homing that is requested next. The tick reads it only with that command, so it may be taken back
  // while none is pending. place(): false: there is no such arm.
  [[nodiscard]] bool place(const link::HomePlace& place) noexcept;
  void forget_place() noexcept { place_.recall(); }
  // Posts without a check: for a replay, which knows that the command was executed.
  void replay(Command command) noexcept { channel_.post(command); }
  // Stops and disarms so far: whether one came after a request.
  [[nodiscard]] std::uint32_t halts() const noexcept { return stops_.get() + disarms_.get(); }
  void keep_alive() noexcept { alive_.add(); }  // a sign of life from the host
  [[nodiscard]] const Request<Command>& channel() const noexcept { return channel_; }

  // --- tick
  [[nodiscard]] std::optional<Command> take() noexcept { return channel_.take(); }
  // Also of a command that had no effect: no later one finds its place.
  void done() noexcept {
    if (place_.letter() != nullptr) place_.done();
    channel_.done();
  }
  // Where the host says that an arm is, of Command::kHome; null: nowhere.
  [[nodiscard]] const link::HomePlace* placed() const noexcept { return place_.letter(); }
  [[nodiscard]] std::uint32_t stops() const noexcept { return stops_.get(); }  // requested so far
  [[nodiscard]] std::uint32_t disarms() const noexcept { return disarms_.get(); }
  [[nodiscard]] std::uint32_t alive() const noexcept { return alive_.get(); }  // signs of life so far

 private:
  const Setup& setup_;
  const Params& params_;
  const Status& status_;
  Sources& sources_;
  Request<Command> channel_;
  Mailbox<link::HomePlace> place_;
  Counter stops_;  // apart from the channel: nothing may replace a stop, or a disarm
  Counter disarms_;
  Counter alive_;
};

}  // namespace thimble::firmware
