#include "firmware/observe/recorder.h"

#include <algorithm>
#include <optional>

#include "firmware/link/crc32.h"

namespace thimble::firmware {

void RecordingEntry::add(const link::RecordingCheck& check) noexcept {
  tick = check.tick;
  what = check.last ? What::kEnd : What::kCheckedTick;
  command = check.command;
  crc = check.crc;
  mode = check.mode;
  levels = check.levels;
}

link::RecordingCheck RecordingEntry::check() const noexcept {
  link::RecordingCheck check;
  check.tick = tick;
  check.last = what == What::kEnd;
  check.command = command;
  check.crc = crc;
  check.mode = mode;
  check.levels = levels;
  return check;
}

link::RecordingMark RecordingEntry::mark() const noexcept {
  link::RecordingMark mark;
  mark.tick = tick;
  mark.what = marked.mark.kind;
  mark.value = marked.mark.value;
  mark.before = marked.mark.before;
  mark.number = marked.number;
  return mark;
}

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
  marks_.clear();
  end_.set(RecordingEnd::kNotYet);
  phase_.set(RecordingPhase::kRunning);
}

void Recorder::tick(const Tick& tick) noexcept {
  RecordingEntry entry;
  entry.tick = static_cast<std::uint16_t>(tick.tick);
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
    entry.add(last_);
  }
  ticks_.add();
  if (tick.mark != nullptr) push(*tick.mark, entry.tick);
  push(entry);
  if (tick.faulted) finish(RecordingEnd::kFault);
}

// The last check once more, with the bit that says so: whoever has it knows that nothing follows.
void Recorder::finish(RecordingEnd reason) noexcept {
  RecordingEntry entry;
  entry.add(last_);
  entry.what = RecordingEntry::What::kEnd;
  entry.command = link::RecordedCommand::kNone;
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

// One that finds the ring full is missed by its number.
void Recorder::push(const Mark& mark, std::uint16_t tick) noexcept {
  if (RecordingEntry* place = ring_.blank(); place != nullptr) {
    *place = {};
    place->tick = tick;
    place->what = RecordingEntry::What::kMark;
    place->marked = {mark, static_cast<std::uint16_t>(marks_.get())};
    ring_.push();
  }
  marks_.add();
}

link::RecordingState Recorder::state() const noexcept {
  link::RecordingState state;
  state.phase = phase();
  state.end = end_.get();
  state.ticks = ticks_.get();
  state.dropped = dropped_.get();
  state.marks = marks_.get();
  return state;
}

}  // namespace thimble::firmware
