// A trace: what every tick of a run was fed with, and a check of what it did, on their way from the tick to the background. The
// servo owns it; the controller sends its entries (TraceCounts, TraceCheck of messages.def). Off, it costs the tick one branch.
//
// A trace begins with a servo in a state that its start record tells in full (Servo::resume()), so the counts, the levels and the
// commands that follow determine every force to the bit. It ends by itself where they no longer would (TraceEnd).
//
// Two contexts, as in servo.h: begin(), tick() and end() belong to the tick, the rest to the background. An entry that finds the
// ring full is dropped and counted: the host sees a gap.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/limits.h"
#include "firmware/link/messages.h"
#include "firmware/link/services.h"

namespace thimble::firmware {

using link::Mode;
using link::TraceEnd;
using link::TracePhase;

struct TraceEntry {
  std::array<std::array<std::uint16_t, 3>, control::kMaxArms> counts{};
  std::uint16_t tick = 0;  // low bits
  bool counted = false;    // with counts: all but the end's
  bool checked = false;
  link::TraceCheck check;
};

// All arms of a start record.
using TraceArms = std::array<link::TraceArm, control::kMaxArms>;

class Trace {
 public:
  static constexpr std::uint32_t kEntries = 128;  // 32 ms at 4 kHz; 4 kB
  static constexpr std::uint32_t kCheckTicks = 16;

  // What a tick brings besides counts.
  struct Tick {
    std::uint64_t tick = 0;
    std::array<std::span<const std::uint32_t>, control::kMaxArms> counts;  // of the arms that there are
    std::size_t arms = 0;
    // Registers of 32 bits: their low half tells the way since the last tick only while it is short.
    std::array<bool, control::kMaxArms> wide{};
    std::span<const std::byte> forces;  // of all arms, after all limits
    Mode mode = Mode::kDisarmed;
    link::TracedCommand command = link::TracedCommand::kNone;  // carried out in this tick
    link::Levels levels;
    bool faulted = false;  // the trace ends with this tick
  };

  // --- tick
  [[nodiscard]] bool running() const noexcept { return running_; }
  void begin(const link::TraceStart& start, const TraceArms& arms) noexcept;
  // This tick is not determined by what is recorded: the last tick was the trace's last.
  void end(TraceEnd reason) noexcept {
    if (running_ && due_ == TraceEnd::kNotYet) due_ = reason;
  }
  void tick(const Tick& tick) noexcept;

  // --- background
  [[nodiscard]] bool next(TraceEntry& entry) noexcept;
  void request_end(TraceEnd reason) noexcept { end_request_.store(reason, std::memory_order_release); }
  [[nodiscard]] TracePhase phase() const noexcept { return phase_.load(std::memory_order_acquire); }
  [[nodiscard]] link::TraceState state() const noexcept;
  // Of the trace that runs or ran last; all 0 while phase() is kNone.
  [[nodiscard]] const link::TraceStart& start() const noexcept { return start_; }
  [[nodiscard]] const TraceArms& arms() const noexcept { return arms_; }

 private:
  void push(const TraceEntry& entry) noexcept;
  void finish(TraceEnd reason) noexcept;

  // The tick's.
  bool running_ = false;
  TraceEnd due_ = TraceEnd::kNotYet;
  std::array<std::array<std::uint32_t, 3>, control::kMaxArms> last_counts_{};
  std::uint32_t since_check_ = 0;
  link::TraceCheck last_;
  // Written before the phase says that a trace runs, and not again until the next one.
  link::TraceStart start_;
  TraceArms arms_;

  std::array<TraceEntry, kEntries> ring_;
  std::atomic<std::uint32_t> head_{0};
  std::atomic<std::uint32_t> tail_{0};
  std::atomic<TraceEnd> end_request_{TraceEnd::kNotYet};
  std::atomic<TracePhase> phase_{TracePhase::kNone};
  std::atomic<TraceEnd> end_{TraceEnd::kNotYet};
  std::atomic<std::uint32_t> ticks_{0};
  std::atomic<std::uint32_t> dropped_{0};
};

}  // namespace thimble::firmware
