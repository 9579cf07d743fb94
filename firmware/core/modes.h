// The commands and the modes of the controller, and every transition between the modes as one table; decide.cpp and state.cpp say when
// an event happens. docs/faults.md and the README's section on safety tell the user's side.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/link/messages.h"

namespace thimble::firmware {

using link::Mode;  // the enum and its names: firmware/link/messages.def
using link::StoppedBy;
inline constexpr unsigned kModeCount = 6;

[[nodiscard]] constexpr bool motors_on(Mode mode) noexcept {
  return mode == Mode::kArmed || mode == Mode::kDamping;
}

// A set of modes, one bit each.
using Modes = std::uint8_t;
[[nodiscard]] constexpr Modes only(Mode mode) noexcept {
  return static_cast<Modes>(1U << static_cast<unsigned>(mode));
}
[[nodiscard]] constexpr bool contains(Modes modes, Mode mode) noexcept { return (modes & only(mode)) != 0; }
inline constexpr Modes kAllModes = (1U << kModeCount) - 1U;

enum class Command : std::uint8_t {
  kNone = 0,
  kHome = 1,
  kArm = 2,
  kDisarm = 3,   // always accepted
  kClear = 4,    // clears a latched fault whose cause is gone
  kStop = 5,     // trips host_stop; always accepted
  kMove = 6,     // comes with an order: Commands::request_move()
  kEndMove = 7,  // ends a guarded move; accepted without one too
  kRecord = 8,   // the next tick is the first of a recording (firmware/observe/recorder.h); motors off
};

// What sets the arm in motion: a disarm of the same time goes before it.
[[nodiscard]] constexpr bool yields_to_disarm(Command command) noexcept {
  return command == Command::kHome || command == Command::kArm || command == Command::kMove;
}

// What undoes a stop: who has asked for it did not know of a stop of the same time. The fault that a stop latches prevents the rest.
[[nodiscard]] constexpr bool yields_to_stop(Command command) noexcept { return command == Command::kClear; }

// What makes the mode change.
enum class Event : std::uint8_t {
  kHomeCommand,
  kArmCommand,
  kDisarmCommand,
  kClearCommand,
  kAllHomed,      // the last arm has found its home position
  kLetGo,         // the dead-man switch was released, or the force source gives the arm up
  kTripDamp,      // a fault whose reaction is kDamp
  kTripZero,      // a fault whose reaction is kZero
  kDamped,        // stop_time is over, without a fault
  kDampedByTrip,  // stop_time is over, and a fault is latched
};

struct Transition {
  Mode from;
  Event event;
  Mode to;          // when every arm is homed
  Mode to_unhomed;  // when one is not
};

// An event that has no row for the present mode changes nothing.
inline constexpr std::array<Transition, 19> kTransitions = {{
    {Mode::kDisarmed, Event::kHomeCommand, Mode::kHoming, Mode::kHoming},
    {Mode::kDisarmed, Event::kTripDamp, Mode::kFaulted, Mode::kFaulted},
    {Mode::kDisarmed, Event::kTripZero, Mode::kFaulted, Mode::kFaulted},

    {Mode::kHoming, Event::kAllHomed, Mode::kReady, Mode::kReady},
    {Mode::kHoming, Event::kDisarmCommand, Mode::kDisarmed, Mode::kDisarmed},
    {Mode::kHoming, Event::kTripDamp, Mode::kFaulted, Mode::kFaulted},
    {Mode::kHoming, Event::kTripZero, Mode::kFaulted, Mode::kFaulted},

    {Mode::kReady, Event::kHomeCommand, Mode::kHoming, Mode::kHoming},
    {Mode::kReady, Event::kArmCommand, Mode::kArmed, Mode::kArmed},
    {Mode::kReady, Event::kTripDamp, Mode::kFaulted, Mode::kFaulted},
    {Mode::kReady, Event::kTripZero, Mode::kFaulted, Mode::kFaulted},

    {Mode::kArmed, Event::kDisarmCommand, Mode::kDamping, Mode::kDamping},
    {Mode::kArmed, Event::kLetGo, Mode::kDamping, Mode::kDamping},
    {Mode::kArmed, Event::kTripDamp, Mode::kDamping, Mode::kDamping},
    {Mode::kArmed, Event::kTripZero, Mode::kFaulted, Mode::kFaulted},

    {Mode::kDamping, Event::kDamped, Mode::kReady, Mode::kDisarmed},
    {Mode::kDamping, Event::kDampedByTrip, Mode::kFaulted, Mode::kFaulted},
    {Mode::kDamping, Event::kTripZero, Mode::kFaulted, Mode::kFaulted},
    // kTripDamp while damping: the braking goes on, and ends with kDampedByTrip.

    {Mode::kFaulted, Event::kClearCommand, Mode::kReady, Mode::kDisarmed},
}};

[[nodiscard]] constexpr Mode next_mode(Mode from, Event event, bool homed) noexcept {
  for (const Transition& row : kTransitions)
    if (row.from == from && row.event == event) return homed ? row.to : row.to_unhomed;
  return from;
}

}  // namespace thimble::firmware
