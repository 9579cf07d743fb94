#include "host-tools/lab/recorder.h"

#include <algorithm>

#include "firmware/link/services.h"

namespace thimble::host {
namespace {

constexpr std::uint32_t kTickMask = (1U << link::kRecordedTickBits) - 1;
constexpr std::uint32_t kBehind = kTickMask / 2 + 1;  // a tick this far ahead is an old one
constexpr std::uint16_t kMarkBehind = 0x8000;         // and so is a mark

}  // namespace

void Recorder::take(const link::CanFrame& frame, std::uint32_t time_us) {
  if (!begun_) {
    early_.push_back({time_us, frame});
    return;
  }
  link::RecordingCounts counts;
  link::RecordingCheck check;
  link::RecordingMark mark;
  if (link::from_frame(frame, node_, counts)) {
    if (!ended_) take_counts(counts);  // after the end come those of another recording
  } else if (link::from_frame(frame, node_, check)) {
    if (!ended_) take_check(check);
  } else if (link::from_frame(frame, node_, mark)) {
    if (!ended_) take_mark(mark);
  } else if (!frame.extended && frame.size <= link::kClassicDataBytes) {
    frames_.push_back({time_us, frame});
  }
}

void Recorder::begin(const link::RecordingStart& start) {
  begun_ = true;
  next_ = std::uint64_t{start.tick} + 1;
  last_check_ = start.tick;
  const std::vector<RecordedFrame> early = std::move(early_);
  for (const RecordedFrame& frame : early) take(frame.frame, frame.time_us);
}

void Recorder::take_counts(const link::RecordingCounts& counts) {
  const std::uint32_t ahead = (counts.tick - static_cast<std::uint32_t>(next_)) & kTickMask;
  if (ahead >= kBehind) return;
  if (ahead != 0) {  // what was missing is not whole either
    missing_ += ahead;
    next_ += ahead;
    arms_of_next_ = 0;
    counts_of_next_.clear();
  }
  if (counts.arm != arms_of_next_) return;
  counts_of_next_.insert(counts_of_next_.end(), counts.counts.begin(), counts.counts.end());
  if (++arms_of_next_ < arms_) return;
  if (counts_.empty() ||
      counts_.back().first + counts_.back().counts.size() / (kRecordedCounts * arms_) != next_)
    counts_.push_back({next_, {}});
  std::vector<std::uint16_t>& all = counts_.back().counts;
  all.insert(all.end(), counts_of_next_.begin(), counts_of_next_.end());
  counts_of_next_.clear();
  arms_of_next_ = 0;
  ++ticks_;
  ++next_;
}

// Checks come after the counts of their tick, or without them, and never go back.
void Recorder::take_check(const link::RecordingCheck& check) {
  const std::uint32_t ahead = (check.tick - static_cast<std::uint32_t>(last_check_)) & kTickMask;
  if (ahead >= kBehind) return;
  last_check_ += ahead;
  checks_.push_back({last_check_, check.crc, check.mode, check.command, check.last, check.levels});
  if (check.last) ended_ = true;
}

// A mark comes before the counts of its tick, so its tick is the one that should come next, or one that will be missing. Marks may be much
// farther from each other than the bits of a tick tell. One that the link repeats, or brings after a later one, is left out.
void Recorder::take_mark(const link::RecordingMark& mark) {
  const std::uint32_t ahead = (mark.tick - static_cast<std::uint32_t>(next_)) & kTickMask;
  if (ahead >= kBehind || static_cast<std::uint16_t>(mark.number - next_mark_) >= kMarkBehind) return;
  next_mark_ = static_cast<std::uint16_t>(mark.number + 1);
  marks_.push_back({next_ + ahead, mark.what, mark.value, mark.before});
  ++marks_taken_;
}

void Recorder::write(std::ostream& out) {
  if (!begun_) return;
  for (const RecordedTicks& ticks : counts_) write_ticks(out, ticks);
  if (!checks_.empty()) write_checks(out, checks_);
  if (!marks_.empty()) write_marks(out, marks_);
  if (!frames_.empty()) write_frames(out, frames_);
  counts_.clear();
  checks_.clear();
  marks_.clear();
  frames_.clear();
}

}  // namespace thimble::host
