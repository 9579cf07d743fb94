#include "firmware/observe/recording_frames.h"

#include "firmware/link/messages.h"

namespace thimble::firmware {

bool RecordingFrames::next_frame(link::CanFrame& frame) noexcept {
  if (arm_ >= arm_count_ && !entry_.checked) {
    if (!recorder_.next(entry_)) return false;
    arm_ = entry_.counted ? std::uint8_t{0} : arm_count_;
  }
  ++frames_in_a_row_;
  if (arm_ < arm_count_) {
    link::RecordingCounts counts;
    counts.tick = entry_.tick;
    counts.arm = arm_;
    counts.counts = entry_.counts[arm_];
    ++arm_;
    frame = link::to_frame(counts, node_);
    return true;
  }
  entry_.checked = false;
  frame = link::to_frame(entry_.check, node_);
  return true;
}

bool RecordingFrames::services_turn() noexcept {
  if (frames_in_a_row_ < kFramesInARow) return false;
  frames_in_a_row_ = 0;
  return true;
}

void RecordingFrames::discard() noexcept {
  for (std::uint32_t i = 0; i < Recorder::kEntries && recorder_.next(entry_); ++i) {
  }
  arm_ = control::kMaxArms;
  entry_.checked = false;
}

}  // namespace thimble::firmware
