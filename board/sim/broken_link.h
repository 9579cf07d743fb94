// One direction of the link of the simulated board, with what is broken in it. Sound, it passes every frame on at once.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "board/sim/sim_board.h"
#include "firmware/link/can_frame.h"

namespace thimble::board {

class BrokenLink {
 public:
  static constexpr std::size_t kMostWaiting = 4096;  // frames; what comes then is lost

  void send(const firmware::link::CanFrame& frame, std::uint64_t now_us, const SimBoard& board) {
    if (board.injected(Injection::kLinkCut)) return;
    const double delay_s = board.injected(Injection::kLinkDelay).value_or(0);
    const int times = board.injected(Injection::kLinkDuplicate) ? 2 : 1;
    for (int i = 0; i < times && waiting_.size() < kMostWaiting; ++i)
      waiting_.push_back({frame, now_us + static_cast<std::uint64_t>(delay_s * 1e6)});
  }
  // The next frame that has arrived.
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive(std::uint64_t now_us) {
    if (waiting_.empty() || waiting_.front().due_us > now_us) return std::nullopt;
    const firmware::link::CanFrame frame = waiting_.front().frame;
    waiting_.pop_front();
    return frame;
  }

 private:
  struct Waiting {
    firmware::link::CanFrame frame;
    std::uint64_t due_us;
  };
  std::deque<Waiting> waiting_;
};

}  // namespace thimble::board
