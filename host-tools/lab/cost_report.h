// The cost of a scene in words and as a warning, for `thimble compile` and `thimble upload` (docs/time.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "board/sim/scene_cost.h"

namespace thimble::host {

struct CostReport {
  std::string board;
  double rate_Hz = 0;
  board::SceneCost cost;
  std::string text;     // one line
  std::string warning;  // empty: it fits
  double fits_Hz = 0;   // the highest rate that fits; 0: none below, or not looked for
};

// Of an image that is valid, on a board of board::board_costs(). work_units: of a device; 0: what the board gives at this rate.
// A scene without objects has an empty text.
[[nodiscard]] CostReport cost_report(std::span<const std::byte> image, const board::BoardCost& board,
                                     double rate_Hz, std::uint32_t work_units = 0, std::size_t arms = 1);

// "mps2-an500, zynqmp, linux, sim"
[[nodiscard]] std::string board_names();

}  // namespace thimble::host
