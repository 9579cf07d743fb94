// The simulated board in real time: the ticks that are due by the machine's steady clock, and between them the frames of the hosts. The
// caller has the carrier of frames, and waits: LiveBoard with ports, or the worker of a page.
//
//   LiveLoop loop(carrier, start);
//   for (;;) loop.round();  // again within some milliseconds
//
// One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "board/sim/broken_link.h"
#include "board/sim/sim_board.h"

namespace thimble::board {

class LiveLoop {
 public:
  class Carrier {
   public:
    Carrier() = default;
    Carrier(const Carrier&) = delete;
    Carrier& operator=(const Carrier&) = delete;
    virtual ~Carrier() = default;
    virtual void send(const firmware::link::CanFrame& frame) = 0;
    [[nodiscard]] virtual std::optional<firmware::link::CanFrame> receive() = 0;
    [[nodiscard]] virtual std::uint64_t dropped() const = 0;  // frames, so far
  };
  using Start = std::function<std::unique_ptr<SimBoard>(const char* reset_reason)>;

  // Access for the calling program after a round. `sent`: the real-time frames of this round, in order; `since_us`: steady clock of the
  // machine before its first tick.
  struct Round {
    SimBoard& board;
    const std::vector<firmware::link::CanFrame>& sent;
    std::uint64_t since_us;
  };

  // start: makes the board, now and each time that a host restarts it.
  LiveLoop(Carrier& carrier, Start start);
  LiveLoop(const LiveLoop&) = delete;
  LiveLoop& operator=(const LiveLoop&) = delete;
  ~LiveLoop() = default;

  void round(const std::function<void(const Round&)>& each = {});  // `each` may be empty

  [[nodiscard]] SimBoard& board() noexcept { return *board_; }
  [[nodiscard]] double skipped_s() const noexcept {
    return skipped_s_;
  }  // that no tick has simulated: the machine was late

 private:
  void send_all();
  void hear_all(double due_s);

  Carrier& carrier_;
  Start start_;
  std::unique_ptr<SimBoard> board_;
  BrokenLink to_hosts_, from_hosts_;
  std::vector<firmware::link::CanFrame> sent_;
  std::uint64_t last_us_;
  double skipped_s_ = 0;
  double flood_ = 0;  // frames of nobody that are due
};

}  // namespace thimble::board
