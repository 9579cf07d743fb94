#include "firmware/observe/recorder.h"

#include <algorithm>
#include <optional>

#include "firmware/link/crc32.h"

namespace thimble::firmware {

void Recorder::begin(const RecordingStart& start) noexcept {
  start_.recall();
  *start_.blank() = start;
  start_.send();
  for (std::size_t i = 0; i < start.arms.size(); ++i)
    std::copy_n(start.arms[i].raw.begin(), last_counts_[i].size(), last_counts_[i].begin());
  last_ = {};
  last_.tick = static_cast<std::uint16_t>(start.start.tick);
  last_.mode = start.start.mode;
  last_.levels = start.start.levels;
  since_check_ = 0;
  counts_only_ = counts_only_wanted_.get();
  due_ = RecordingEnd::kNotYet;
  running_ = true;
  if (end_request_.take()) end_request_.done();  // of the recording before
  ticks_.clear();
  dropped_.clear();
  end_.set(RecordingEnd::kNotYet);
  phase_.set(RecordingPhase::kRunning);
}

void Recorder::tick(const Tick& tick) noexcept {
  RecordingEntry entry;
  entry.tick = static_cast<std::uint16_t>(tick.tick);
  entry.counted = true;
  bool fits = true;
  for (std::size_t i = 0; i < tick.arms; ++i) {
    for (std::size_t j = 0; j < tick.counts[i].size(); ++j) {
      const std::uint32_t count = tick.counts[i][j];
      const auto step = static_cast<std::int32_t>(count - last_counts_[i][j]);
      fits = fits && (!tick.wide[i] || step == static_cast<std::int16_t>(step));
      last_counts_[i][j] = count;
      entry.counts[i][j] = static_cast<std::uint16_t>(count);
    }
  }
  if (!fits) end(RecordingEnd::kCountsJumped);
  const std::optional<RecordingEnd> asked = end_request_.take();
  if (asked) end(*asked);
  const bool ends = due_ != RecordingEnd::kNotYet;
  if (ends) finish(due_);
  if (asked) end_request_.done();
  if (ends) return;
  const bool happened =
      tick.command != link::RecordedCommand::kNone || last_.mode != tick.mode || last_.levels != tick.levels;
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
  if (tick.faulted) finish(RecordingEnd::kFault);
}

// The last check once more, with the bit that says so: whoever has it knows that nothing follows.
void Recorder::finish(RecordingEnd reason) noexcept {
  RecordingEntry entry;
  entry.tick = last_.tick;
  entry.checked = true;
  entry.check = last_;
  entry.check.command = link::RecordedCommand::kNone;
  entry.check.last = true;
  push(entry);
  running_ = false;
  end_.set(reason);
  phase_.set(RecordingPhase::kEnded);
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

link::RecordingState Recorder::state() const noexcept {
  link::RecordingState state;
  state.phase = phase();
  state.end = end_.get();
  state.ticks = ticks_.get();
  state.dropped = dropped_.get();
  return state;
}

}  // namespace thimble::firmware
