// Faults of the simulated bench as a command line names them, and what its builder repairs.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "host-tools/commission/sim_bench.h"

namespace thimble::host {

struct PlantedFault {
  ArmFault fault{};
  bool of_motor = false;   // an axis without one cannot have it
  bool exchanges = false;  // needs two axes
  double factor = 0;       // where none is given; 0: it takes none
  double least = 0, most = 0;
};
[[nodiscard]] std::span<const PlantedFault> planted_faults() noexcept;

// "motor-sign@upper", "weak-motor@upper:0.577", "motors-swapped@upper,fore", "line-ignored". The factor is true by given (SimFault); without it a
// typical one. Throws Error (kUsage): unknown-fault, unknown-axis, bad-fault.
[[nodiscard]] SimFault planted_fault(const std::string& text, const ArmFile& arm);

// The first of `faults` that a finding names, itself or as one that looks the same.
[[nodiscard]] std::optional<std::size_t> fault_behind(std::span<const SimFault> faults,
                                                      const ArmFinding& found);

}  // namespace thimble::host
