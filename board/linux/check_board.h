// What stands against arming, as thimble-board finds it at start and `thimble-board --check` prints it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board/linux/board_config.h"
#include "board/linux/missing.h"
#include "board/linux/slot_files.h"
#include "board/posix/port.h"

namespace thimble::board {

inline constexpr int kCheckMissing = 3, kCheckForbidden = 5;  // exit codes

[[nodiscard]] inline std::string describe(const Missing& missing) {
  return missing.what + "; " + missing.remedy;
}
inline void add(std::vector<Missing>& all, std::vector<Missing> more) {
  for (Missing& one : more) all.push_back(std::move(one));
}

// error: an errno.
[[nodiscard]] Missing no_watchdog(const BoardConfig& config, int error);
// By the saved lost_ticks, which a host may change: without it the one-shot would end before the fault.
[[nodiscard]] std::optional<Missing> too_late(const BoardConfig& config, SlotFiles& store);
// Throws std::system_error or std::runtime_error.
[[nodiscard]] std::unique_ptr<Port> open_port(const LinkConfig& link, std::uint8_t node);

// Opens every device once, as the board would, and prints the drives, what a tick takes (rate_budget.h; `scenes`: images to measure rendering
// with), what the kernel has, and what is missing. Returns the exit code.
[[nodiscard]] int check_board(const BoardConfig& config, const std::vector<std::string>& scenes);

}  // namespace thimble::board
