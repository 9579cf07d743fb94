// The simulated arm as a scanner: homed and armed, without a hand, it executes guarded moves on a specimen,
// faster than real time and deterministic. Equivalent to routine 0206 of the link, without the link. Used by
// `thimble scan --simulate` and by tests.
//
//   SimProbe probe({.specimen = ...}, image);
//   const SimProbe::Result result = probe.move({.target_z_m = -0.01F, .speed_m_s = 0.02F, .force_limit_N = 1.5F});
#pragma once

#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

#include "board/sim/sim_board.h"
#include "firmware/link/messages.h"

namespace thimble::board {

// what(): why the controller did not arm, refused the move or has a fault.
class ProbeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class SimProbe {
 public:
  struct Result {
    firmware::link::MoveState state;
    std::vector<firmware::link::MoveSample> samples;  // in order of time
  };

  // options.hand is ignored: no hand holds the arm. image: a scene in which the tip touches nothing.
  SimProbe(SimBoardOptions options, std::span<const std::byte> image);

  // Moves from the present position; returns when the arm holds its position again. Throws ProbeError.
  Result move(const firmware::link::MoveOrder& order);

  [[nodiscard]] SimBoard& board() noexcept { return board_; }

 private:
  void tick();
  [[noreturn]] void fail(const std::string& what);

  SimBoard board_;
};

}  // namespace thimble::board
