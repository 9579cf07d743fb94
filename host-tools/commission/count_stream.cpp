#include "host-tools/commission/count_stream.h"

#include "firmware/link/services.h"

namespace thimble::host {
namespace {

constexpr std::uint32_t kTickMask = (1U << link::kRecordedTickBits) - 1;
constexpr std::uint32_t kBehind = kTickMask / 2 + 1;  // a tick this far ahead is an old one

std::uint32_t ahead(std::uint16_t tick, std::uint64_t of) {
  return (tick - static_cast<std::uint32_t>(of)) & kTickMask;
}

}  // namespace

void CountStream::begin(const link::RecordingStart& start, std::size_t axes,
                        const PerAxis<std::uint32_t>& raw, const PerAxis<std::int64_t>& counts) {
  begun_ = true;
  axes_ = axes;
  first_ = std::uint64_t{start.tick} + 1;
  checked_ = start.tick;
  index_at_start_ = start.levels.index.at(arm_);
  raw_ = raw;
  counts_ = counts;
  for (const link::CanFrame& frame : early_) take_now(frame);
  early_.clear();
}

void CountStream::take(const link::CanFrame& frame) { begun_ ? take_now(frame) : early_.push_back(frame); }

void CountStream::take_now(const link::CanFrame& frame) {
  link::RecordingCounts first;
  link::RecordingCounts3 next;
  link::RecordingCounts6 last;
  link::RecordingCheck check;
  if (link::from_frame(frame, node_, first)) {
    take_part(first.tick, first.arm, 0, first.counts.data(), first.counts.size());
  } else if (link::from_frame(frame, node_, next)) {
    take_part(next.tick, next.arm, first.counts.size(), next.counts.data(), next.counts.size());
  } else if (link::from_frame(frame, node_, last)) {
    take_part(last.tick, last.arm, first.counts.size() + next.counts.size(), last.counts.data(),
              last.counts.size());
  } else if (link::from_frame(frame, node_, check)) {
    const std::uint32_t later = ahead(check.tick, checked_);
    if (later >= kBehind) return;
    checked_ += later;
    events_.push_back({checked_, check.mode, check.levels});
  }
}

std::vector<std::uint64_t> CountStream::home_marks(std::uint64_t from) const {
  std::vector<std::uint64_t> marks;
  bool before = index_at_start_;
  for (const Event& event : events_) {
    const bool now = event.levels.index.at(arm_);
    if (now && !before && event.tick >= from && event.tick < end()) marks.push_back(event.tick);
    before = now;
  }
  return marks;
}

// 16 bits of each counter: the change since the tick before is what they say of it.
void CountStream::take_part(std::uint16_t tick, std::uint8_t arm, std::size_t from,
                            const std::uint16_t* counts, std::size_t many) {
  if (arm != arm_ || broken_ || ahead(tick, end()) >= kBehind) return;
  if (ahead(tick, end()) != 0 || from != parts_) {
    broken_ = true;
    return;
  }
  for (std::size_t k = 0; k < many && parts_ < axes_; ++k, ++parts_) {
    const auto step = static_cast<std::int16_t>(counts[k] - static_cast<std::uint16_t>(raw_.at(parts_)));
    raw_.at(parts_) += static_cast<std::uint32_t>(static_cast<std::int32_t>(step));
    counts_.at(parts_) += step;
  }
  if (parts_ < axes_) return;
  parts_ = 0;
  ticks_.push_back(counts_);
}

}  // namespace thimble::host
