// What of a period the parts of a tick take, one after the other: reading, the controller, the converters, the buses of drives. For --check.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "board/linux/board_config.h"

namespace thimble::board {

struct RateBudget {
  double period_us = 0;
  double read_us = 0;  // encoders and lines, measured here
  double rendering_us =
      0;  // at most, by work_units; `measured` says whether by this computer's unit or as the docs ask for
  bool measured = false;
  double spi_us = 0;  // on the wire: all converters, one after the other
  double bus_us =
      0;  // of the most loaded bus, replies included: they must have come when the next tick reads them
  std::string bus;  // its interface; empty: no drives

  [[nodiscard]] double sum_us() const { return read_us + rendering_us + spi_us + bus_us; }
  // A line for each part, and the sum with whether it fits.
  [[nodiscard]] std::vector<std::string> lines() const;
};

// read_us: see above. unit_ns: of measure_work.h.
[[nodiscard]] RateBudget rate_budget(const BoardConfig& config, double read_us,
                                     std::optional<double> unit_ns);

}  // namespace thimble::board
