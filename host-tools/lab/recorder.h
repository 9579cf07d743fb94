// The frames of a device's recording, put together to the messages of its file. Who calls it: `thimble record`, for every real-time
// frame it hears; one thread. Frames may come before the recording's start is known, and late ones of an earlier recording are passed over.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <vector>

#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "host-tools/lab/recording.h"

namespace thimble::host {

class Recorder {
 public:
  Recorder(std::uint8_t node, std::size_t arms) : node_(node), arms_(arms) {}

  void take(const link::CanFrame& frame, std::uint32_t time_us);
  void begin(const link::RecordingStart& start);
  [[nodiscard]] std::uint32_t marks() const { return marks_taken_; }
  // Writes what came since, once the start is known.
  void write(std::ostream& out);

  [[nodiscard]] bool ended() const { return ended_; }  // the device said so on the way
  [[nodiscard]] std::uint64_t ticks() const { return ticks_; }
  [[nodiscard]] std::uint64_t missing() const { return missing_; }  // between ticks that came
  [[nodiscard]] std::optional<std::uint64_t> last_tick() const {
    return ticks_ == 0 ? std::nullopt : std::optional(next_ - 1);
  }

 private:
  void take_counts(const link::RecordingCounts& counts);
  void take_check(const link::RecordingCheck& check);
  void take_mark(const link::RecordingMark& mark);

  std::uint8_t node_;
  std::size_t arms_;
  bool begun_ = false;
  bool ended_ = false;
  std::vector<RecordedFrame> early_;  // before the start was known
  std::uint64_t next_ = 0;            // the tick that should come
  std::uint64_t last_check_ = 0;
  std::size_t arms_of_next_ = 0;  // that have come
  std::vector<std::uint16_t> counts_of_next_;
  std::uint64_t ticks_ = 0;
  std::uint64_t missing_ = 0;
  std::vector<RecordedTicks> counts_;
  std::vector<RecordedCheck> checks_;
  std::vector<RecordedFrame> frames_;
  std::vector<RecordedMark> marks_;
  std::uint32_t marks_taken_ = 0;
  std::uint16_t next_mark_ = 0;  // the number that should come
};

}  // namespace thimble::host
