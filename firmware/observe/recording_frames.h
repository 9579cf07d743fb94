// A recording as real-time frames: tick after tick, the counts of each arm (RecordingCounts), then the tick's check where it
// has one (RecordingCheck). A recording can fill the bus, so after every kFramesInARow of its frames the services have a turn.
//
// Who calls it: the controller, in the background context. Nothing here can fail.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/scene/limits.h"
#include "firmware/link/can_frame.h"
#include "firmware/observe/recorder.h"

namespace thimble::firmware {

class RecordingFrames {
 public:
  static constexpr std::uint8_t kFramesInARow = 8;

  // axes: of each arm; must outlive this.
  RecordingFrames(Recorder& recorder, std::uint8_t arm_count,
                  const std::array<std::size_t, control::kMaxArms>& axes, std::uint8_t node) noexcept
      : recorder_(recorder), arm_count_(arm_count), axes_(axes), node_(node) {}

  [[nodiscard]] bool next_frame(link::CanFrame& frame) noexcept;
  // True once after every kFramesInARow frames.
  [[nodiscard]] bool services_turn() noexcept;
  // Drops what has not been sent of the last recording: the next one is about to begin.
  void discard() noexcept;

 private:
  [[nodiscard]] link::CanFrame counts_frame() const noexcept;

  Recorder& recorder_;
  std::uint8_t arm_count_;
  const std::array<std::size_t, control::kMaxArms>& axes_;
  std::uint8_t node_;
  RecordingEntry entry_;                  // the tick that is being sent
  std::uint8_t arm_ = control::kMaxArms;  // whose counts are next; after the last arm comes the check
  std::size_t joint_ = 0;                 // of that arm, whose count is next
  std::uint8_t frames_in_a_row_ = 0;
};

}  // namespace thimble::firmware
