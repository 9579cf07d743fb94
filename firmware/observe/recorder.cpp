#include "firmware/observe/recorder.h"

#include <algorithm>
#include <optional>

#include "firmware/link/crc32.h"

namespace thimble::firmware {

void Recorder::begin(const RecordingStart& start) noexcept {
  start_.recall();
  *start_.blank() = start;
  start_.send();
  for (std::size_t i = 0; i < start.arms.size(); ++i) last_counts_[i] = start.arms[i].raw;
  last_ = {};
  last_.tick = static_cast<std::uint16_t>(start.start.tick);
  last_.mode = start.start.mode;
  last_.levels = start.start.levels;
  since_check_ = 0;
  due_ = TraceEnd::kNotYet;
  running_ = true;
  if (end_request_.take()) end_request_.done();  // of the recording before
  ticks_.clear();
  dropped_.clear();
  end_.set(TraceEnd::kNotYet);
  phase_.set(TracePhase::kRunning);
}

void Recorder::tick(const Tick& tick) noexcept {
  RecordingEntry entry;
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
  if (const std::optional<TraceEnd> asked = end_request_.take()) {
    end(*asked);
    end_request_.done();
  }
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
  ticks_.add();
  push(entry);
  if (tick.faulted) finish(TraceEnd::kFault);
}

// The last check once more, with the bit that says so: whoever has it knows that nothing follows.
void Recorder::finish(TraceEnd reason) noexcept {
  RecordingEntry entry;
  entry.tick = last_.tick;
  entry.checked = true;
  entry.check = last_;
  entry.check.command = link::TracedCommand::kNone;
  entry.check.last = true;
  push(entry);
  running_ = false;
  end_.set(reason);
  phase_.set(TracePhase::kEnded);
}

void Recorder::push(const RecordingEntry& entry) noexcept {
  RecordingEntry* place = ring_.blank();
  if (place == nullptr) {
    dropped_.add();
    return;
  }
  *place = entry;
  ring_.push();
}

link::TraceState Recorder::state() const noexcept {
  link::TraceState state;
  state.phase = phase();
  state.end = end_.get();
  state.ticks = ticks_.get();
  state.dropped = dropped_.get();
  return state;
}

}  // namespace thimble::firmware
