// A recording: the inputs of every tick of a run, and a check of what each tick did, on their way from the tick to the background.
// The core owns the recorder; the controller sends its entries (RecordingCounts, RecordingCheck, RecordingMark of messages.def). While nothing is recorded it
// costs the tick one branch.
//
// A recording begins in a state that its start record describes completely (Core::resume()), so the counts, levels and commands that
// follow determine every force bit for bit. It ends by itself when they no longer do (RecordingEnd).
//
// begin(), tick() and end() are called by the tick, the rest by the background. An entry that finds the ring full is dropped and counted:
// the host sees a gap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/limits.h"
#include "firmware/core/marks.h"
#include "firmware/core/modes.h"
#include "firmware/exchange/mailbox.h"
#include "firmware/exchange/request.h"
#include "firmware/exchange/ring.h"
#include "firmware/exchange/word.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"

namespace thimble::firmware {

using link::RecordingEnd;
using link::RecordingPhase;

// Packed: there are many, in the fastest memory of a board.
struct RecordingEntry {
  enum class What : std::uint8_t { kTick, kCheckedTick, kEnd, kMark };  // kEnd is a check without counts
  struct NumberedMark {
    Mark mark;
    std::uint16_t number;
  };

  union {
    std::array<std::array<std::uint16_t, link::kMaxJoints>, control::kMaxArms> counts{};
    NumberedMark marked;  // of kMark
  };
  std::uint16_t tick = 0;  // low bits
  What what = What::kTick;
  // Of a check.
  link::RecordedCommand command = link::RecordedCommand::kNone;
  std::uint32_t crc = 0;
  link::Mode mode = link::Mode::kDisarmed;
  link::Levels levels;

  [[nodiscard]] bool counted() const noexcept { return what == What::kTick || what == What::kCheckedTick; }
  [[nodiscard]] bool checked() const noexcept { return what == What::kCheckedTick || what == What::kEnd; }
  void add(const link::RecordingCheck& check) noexcept;
  [[nodiscard]] link::RecordingCheck check() const noexcept;
  [[nodiscard]] link::RecordingMark mark() const noexcept;
};

struct RecordingStart {
  link::RecordingStart start;
  std::array<link::RecordingArm, control::kMaxArms> arms;  // start.arms of them
};

class Recorder {
 public:
  static constexpr std::uint32_t kEntries = 128;  // 32 ms at 4 kHz; 6 kB
  static constexpr std::uint32_t kCheckTicks = 16;

  // What a tick brings besides counts.
  struct Tick {
    std::uint64_t tick = 0;
    std::array<std::span<const std::uint32_t>, control::kMaxArms> counts;  // of the arms in use
    std::size_t arms = 0;
    // True: registers of 32 bits. Their low 16 bits give the change since the last tick only if it is small.
    std::array<bool, control::kMaxArms> wide{};
    std::span<const std::byte> forces;  // of all arms, after all limits
    Mode mode = Mode::kDisarmed;
    link::RecordedCommand command = link::RecordedCommand::kNone;  // executed in this tick
    link::Levels levels;
    bool faulted = false;        // the recording ends with this tick
    const Mark* mark = nullptr;  // that it took
  };

  explicit Recorder(const Request<Command>& commands) noexcept : commands_(commands) {}

  // --- tick
  [[nodiscard]] bool running() const noexcept { return running_; }
  void begin(const RecordingStart& start) noexcept;
  // The recorded data do not determine this tick, so the tick before was the last of the recording.
  void end(RecordingEnd reason) noexcept {
    if (counts_only_ && reason != RecordingEnd::kTickLost && reason != RecordingEnd::kCountsJumped &&
        reason != RecordingEnd::kStopped)
      return;
    if (running_ && due_ == RecordingEnd::kNotYet) due_ = reason;
  }
  void tick(const Tick& tick) noexcept;

  // --- background
  [[nodiscard]] bool next(RecordingEntry& entry) noexcept { return ring_.pop(entry); }
  // Of the recording that is requested next: its counts alone are wanted, so it goes on where they do not determine the forces.
  void request_counts_only(bool yes) noexcept { counts_only_wanted_.set(yes); }
  void request_end(RecordingEnd reason) noexcept { end_request_.post(reason); }
  // No tick has seen that request yet. Afterwards the recording has ended, or goes on for its counts alone.
  [[nodiscard]] bool end_pending() const noexcept { return end_request_.pending(); }
  [[nodiscard]] RecordingPhase phase() const noexcept { return phase_.get(); }
  [[nodiscard]] link::RecordingState state() const noexcept;
  // How the recording began that runs or that ran last. Null: there is none, or a command is pending, which may begin the next one.
  [[nodiscard]] const RecordingStart* start() const noexcept {
    return commands_.pending() ? nullptr : start_.letter();
  }

 private:
  void push(const RecordingEntry& entry) noexcept;
  void push(const Mark& mark, std::uint16_t tick) noexcept;
  void finish(RecordingEnd reason) noexcept;

  const Request<Command>& commands_;

  // The tick's.
  bool running_ = false;
  bool counts_only_ = false;
  RecordingEnd due_ = RecordingEnd::kNotYet;
  std::array<std::array<std::uint32_t, link::kMaxJoints>, control::kMaxArms> last_counts_{};
  std::uint32_t since_check_ = 0;
  link::RecordingCheck last_;

  Mailbox<RecordingStart> start_;  // taken back when the background has asked for the next recording
  Ring<RecordingEntry, kEntries> ring_;
  Request<RecordingEnd> end_request_;
  Value<bool> counts_only_wanted_{false};
  // phase_ is set last: a reader of it sees the figures that belong to it.
  Signal<RecordingPhase> phase_{RecordingPhase::kNone};
  Value<RecordingEnd> end_{RecordingEnd::kNotYet};
  Counter ticks_;
  Counter dropped_;
  Counter marks_;
};

}  // namespace thimble::firmware
