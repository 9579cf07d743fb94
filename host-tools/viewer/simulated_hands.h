// The hands of a simulated board, which follow the positions that a page gives. The board's loop moves them; all functions may be called from
// any thread.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "board/sim/live_loop.h"
#include "host-tools/viewer/mutex.h"

namespace thimble::host {

class SimulatedHands {
 public:
  // The hands hold the arms where they are: there is their home. After each round of the board: move().
  explicit SimulatedHands(board::SimBoard& board);

  [[nodiscard]] std::size_t arms() const { return arms_; }

  // The hand goes there, or as far as the arm's workspace reaches, at a hand's speed.
  void want(std::size_t arm, const std::array<double, 3>& position_m);
  [[nodiscard]] std::array<double, 3> hand_m(std::size_t arm) const;
  // Every hand goes where its arm is homed, and stays there while this lives, whatever pages want meanwhile.
  class LedHome {
   public:
    explicit LedHome(SimulatedHands& hands) : hands_(hands) { hands_.lead_home(true); }
    LedHome(const LedHome&) = delete;
    LedHome& operator=(const LedHome&) = delete;
    ~LedHome() { hands_.lead_home(false); }
    [[nodiscard]] bool there() const;

   private:
    SimulatedHands& hands_;
  };

  // Of the record with this sequence number: the newest tick in it, and when the round of ticks that it is of began, on the
  // machine's steady clock: what is measured from there on errs by up to a round to the long side.
  struct Stamp {
    std::uint64_t tick = 0;
    std::uint64_t since_us = 0;
  };
  [[nodiscard]] Stamp stamp(std::uint8_t sequence) const;

  void move(const board::LiveLoop::Round& round);

 private:
  using Vector = std::array<double, 3>;
  struct Hand {
    std::optional<Vector> wanted_m;
    bool fresh = false;  // not brought into the workspace yet
    Vector goal_m{}, at_m{}, home_m{};
  };
  void lead_home(bool yes);

  mutable Mutex mutex_;
  std::array<Hand, 2> hands_;
  std::array<Stamp, 256> stamps_{};
  std::uint64_t last_us_ = 0;
  bool led_home_ = false;
  std::size_t arms_ = 1;
};

}  // namespace thimble::host
