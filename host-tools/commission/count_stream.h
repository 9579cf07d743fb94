// The counts of one arm, tick by tick, from the frames of a device's recording.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/link/can_frame.h"
#include "firmware/link/messages.h"
#include "host-tools/commission/bench.h"

namespace thimble::host {

namespace link = firmware::link;

class CountStream {
 public:
  CountStream(std::uint8_t node, std::uint8_t arm) : node_(node), arm_(arm) {}

  // Frames may come before begin(), which has the state that they begin from. counts: of the arm's axes there.
  void take(const link::CanFrame& frame);
  void begin(const link::RecordingStart& start, std::size_t axes, const PerAxis<std::uint32_t>& raw,
             const PerAxis<std::int64_t>& counts);

  struct Event {
    std::uint64_t tick = 0;
    link::Mode mode = link::Mode::kDisarmed;
    link::Levels levels;
  };

  // first() is the first tick that came; a tick that is missing ends what can be read, and broken() says so.
  [[nodiscard]] std::uint64_t first() const { return first_; }
  [[nodiscard]] std::uint64_t end() const { return first_ + ticks_.size(); }
  [[nodiscard]] bool broken() const { return broken_; }
  [[nodiscard]] const PerAxis<std::int64_t>& at(std::uint64_t tick) const {
    return ticks_.at(static_cast<std::size_t>(tick - first_));
  }
  [[nodiscard]] const std::vector<Event>& events() const { return events_; }
  // The ticks from `from` on, of those that came, in which the level of the arm's index rose.
  [[nodiscard]] std::vector<std::uint64_t> home_marks(std::uint64_t from) const;
  [[nodiscard]] const PerAxis<std::int64_t>& newest() const { return counts_; }
  [[nodiscard]] const PerAxis<std::uint32_t>& newest_raw() const { return raw_; }
  // The whole number of a tick, of which the link told the low 32 bits.
  [[nodiscard]] std::uint64_t whole(std::uint32_t tick) const {
    return first_ + (tick - static_cast<std::uint32_t>(first_));
  }

 private:
  void take_now(const link::CanFrame& frame);
  void take_part(std::uint16_t tick, std::uint8_t arm, std::size_t from, const std::uint16_t* counts,
                 std::size_t many);

  std::uint8_t node_, arm_;
  bool begun_ = false, broken_ = false;
  std::size_t axes_ = 0;
  std::vector<link::CanFrame> early_;
  std::uint64_t first_ = 0, checked_ = 0;
  std::size_t parts_ = 0;  // axes that have come of the next tick
  PerAxis<std::int64_t> counts_{};
  PerAxis<std::uint32_t> raw_{};
  std::vector<PerAxis<std::int64_t>> ticks_;
  std::vector<Event> events_;
  bool index_at_start_ = false;
};

}  // namespace thimble::host
