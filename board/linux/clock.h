// The board's clock: CLOCK_MONOTONIC, the same in every process.
#pragma once

#include <time.h>

#include <cstdint>

namespace thimble::board {

[[nodiscard]] inline std::uint64_t monotonic_ns() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec);
}

}  // namespace thimble::board
