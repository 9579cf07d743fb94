// The simulated arm as a scanner: homed, armed and alone with a specimen, it makes one guarded move after another,
// faster than real time and deterministic. What the link offers a host (routine 0206), without the link; used by
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

// what(): why the controller did not arm, refused the move or tripped.
class ProbeError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class SimProbe {
 public:
  struct Result {
    firmware::link::MoveState state;
    std::vector<firmware::link::MoveSample> samples;  // in the order in which they were taken
  };

  // options.hand is left out: nobody holds the arm. image: a scene in which the tip touches nothing.
  SimProbe(SimBoardOptions options, std::span<const std::byte> image);

  // From where the arm stands; returns when it holds again. Throws ProbeError.
  Result move(const firmware::link::MoveOrder& order);

  [[nodiscard]] SimBoard& board() noexcept { return board_; }

 private:
  void tick();
  [[noreturn]] void fail(const std::string& what);

  SimBoard board_;
};

}  // namespace thimble::board
