#include "firmware/trace.h"

#include <algorithm>

#include "firmware/link/crc32.h"

namespace thimble::firmware {

void Trace::begin(const link::TraceStart& start, const TraceArms& arms) noexcept {
  start_ = start;
  arms_ = arms;
  for (std::size_t i = 0; i < arms.size(); ++i) last_counts_[i] = arms[i].raw;
  last_ = {};
  last_.tick = static_cast<std::uint16_t>(start.tick);
  last_.mode = start.mode;
  last_.levels = start.levels;
  since_check_ = 0;
  due_ = TraceEnd::kNotYet;
  running_ = true;
  end_request_.store(TraceEnd::kNotYet, std::memory_order_relaxed);
  ticks_.store(0, std::memory_order_relaxed);
  dropped_.store(0, std::memory_order_relaxed);
  end_.store(TraceEnd::kNotYet, std::memory_order_relaxed);
  phase_.store(TracePhase::kRunning, std::memory_order_release);
}

void Trace::tick(const Tick& tick) noexcept {
  TraceEntry entry;
  entry.tick = static_cast<std::uint16_t>(tick.tick);
  entry.counted = true;
  bool fits = true;
  for (std::size_t i = 0; i < tick.arms; ++i) {
    for (std::size_t j = 0; j < entry.counts[i].size(); ++j) {
      const std::uint32_t count = tick.counts[i][j];
      const auto step = static_cast<std::int32_t>(count - last_counts_[i][j]);
      fits = fits && (!tick.wide[i] || step == static_cast<std::int16_t>(step));
      last_counts_[i][j] = count;
      entry.counts[i][j] = static_cast<std::uint16_t>(count);
    }
  }
  if (!fits) end(TraceEnd::kCountsJumped);
  end(end_request_.load(std::memory_order_acquire));
  if (due_ != TraceEnd::kNotYet) {
    finish(due_);
    return;
  }
  const bool happened =
      tick.command != link::TracedCommand::kNone || last_.mode != tick.mode || last_.levels != tick.levels;
  last_.crc = link::crc32(tick.forces, last_.crc);
  last_.tick = entry.tick;
  last_.mode = tick.mode;
  last_.command = tick.command;
  last_.levels = tick.levels;
  if (happened || ++since_check_ == kCheckTicks) {
    since_check_ = 0;
    entry.checked = true;
    entry.check = last_;
  }
  ticks_.store(ticks_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  push(entry);
  if (tick.faulted) finish(TraceEnd::kFault);
}

// The last check once more, with the bit that says so: whoever has it knows that nothing follows.
void Trace::finish(TraceEnd reason) noexcept {
  TraceEntry entry;
  entry.tick = last_.tick;
  entry.checked = true;
  entry.check = last_;
  entry.check.command = link::TracedCommand::kNone;
  entry.check.last = true;
  push(entry);
  running_ = false;
  end_.store(reason, std::memory_order_relaxed);
  phase_.store(TracePhase::kEnded, std::memory_order_release);
}

void Trace::push(const TraceEntry& entry) noexcept {
  const std::uint32_t head = head_.load(std::memory_order_relaxed);
  if (head - tail_.load(std::memory_order_acquire) == kEntries) {
    dropped_.store(dropped_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
    return;
  }
  ring_[head % kEntries] = entry;
  head_.store(head + 1, std::memory_order_release);
}

bool Trace::next(TraceEntry& entry) noexcept {
  const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
  if (tail == head_.load(std::memory_order_acquire)) return false;
  entry = ring_[tail % kEntries];
  tail_.store(tail + 1, std::memory_order_release);
  return true;
}

link::TraceState Trace::state() const noexcept {
  link::TraceState state;
  state.phase = phase();
  state.end = end_.load(std::memory_order_relaxed);
  state.ticks = ticks_.load(std::memory_order_relaxed);
  state.dropped = dropped_.load(std::memory_order_relaxed);
  return state;
}

}  // namespace thimble::firmware
