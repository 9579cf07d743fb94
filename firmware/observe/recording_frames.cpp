#include "firmware/observe/recording_frames.h"

#include <algorithm>
#include <cstddef>

#include "firmware/link/messages.h"

namespace thimble::firmware {

bool RecordingFrames::next_frame(link::CanFrame& frame) noexcept {
  if (arm_ >= arm_count_ && !entry_.checked()) {
    if (!recorder_.next(entry_)) return false;
    arm_ = entry_.counted() ? std::uint8_t{0} : arm_count_;
    joint_ = 0;
  }
  ++frames_in_a_row_;
  if (arm_ < arm_count_) {
    frame = counts_frame();
    joint_ += link::kClassicCounts;
    if (joint_ >= axes_[arm_]) {
      joint_ = 0;
      ++arm_;
    }
    return true;
  }
  frame = entry_.checked() ? link::to_frame(entry_.check(), node_) : link::to_frame(entry_.mark(), node_);
  entry_ = {};
  return true;
}

// Of three joints, of the arm whose turn it is.
link::CanFrame RecordingFrames::counts_frame() const noexcept {
  const auto filled = [&](auto message) {
    message.tick = entry_.tick;
    message.arm = arm_;
    std::copy_n(entry_.counts[arm_].begin() + static_cast<std::ptrdiff_t>(joint_), message.counts.size(),
                message.counts.begin());
    return link::to_frame(message, node_);
  };
  if (joint_ == 0) return filled(link::RecordingCounts{});
  return joint_ == link::kClassicCounts ? filled(link::RecordingCounts3{}) : filled(link::RecordingCounts6{});
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
  entry_ = {};
}

}  // namespace thimble::firmware
