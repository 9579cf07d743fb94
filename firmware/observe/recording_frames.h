// A recording as real-time frames: tick after tick, the counts of each arm (RecordingCounts), then the tick's check where it
// has one (RecordingCheck). A recording can fill the bus, so after every kFramesInARow of its frames the services have a turn.
//
// Who calls it: the controller, in the background context. Nothing here can fail.
#pragma once

#include <cstdint>

#include "control/scene/limits.h"
#include "firmware/link/can_frame.h"
#include "firmware/observe/recorder.h"

namespace thimble::firmware {

class RecordingFrames {
 public:
  static constexpr std::uint8_t kFramesInARow = 8;

  RecordingFrames(Recorder& recorder, std::uint8_t arm_count, std::uint8_t node) noexcept
      : recorder_(recorder), arm_count_(arm_count), node_(node) {}

  [[nodiscard]] bool next_frame(link::CanFrame& frame) noexcept;
  // True once after every kFramesInARow frames.
  [[nodiscard]] bool services_turn() noexcept;
  // Drops what has not been sent of the last recording: the next one is about to begin.
  void discard() noexcept;

 private:
  Recorder& recorder_;
  std::uint8_t arm_count_;
  std::uint8_t node_;
  RecordingEntry entry_;                  // the tick that is being sent
  std::uint8_t arm_ = control::kMaxArms;  // whose counts are next; after the last arm comes the check
  std::uint8_t frames_in_a_row_ = 0;
};

}  // namespace thimble::firmware
