// The file of `thimble-sim --inject`: which hardware breaks, when, and for how long (JSON, docs/cli.md).
#pragma once

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "board/sim/injection.h"

namespace thimble::board {

// what(): file, line and cause.
class InjectionError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Of arms with so many axes. Throws InjectionError.
[[nodiscard]] std::vector<PlannedFault> read_injections(const std::filesystem::path& file, std::size_t axes);

}  // namespace thimble::board
