// The time of day, where it can be trusted: from a clock that runs while the machine is off, or from a time server. A machine with
// neither begins where it ended, and so would take a night off for none, or a later correction for a night.
#pragma once

#include <time.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

namespace thimble::board {

// Seconds since 1970; 0: not known. root: for tests.
[[nodiscard]] inline std::uint32_t wall_clock_s(const std::filesystem::path& root = "/") {
  char set = '0';  // from the real-time clock, by the kernel at boot
  std::ifstream(root / "sys/class/rtc/rtc0/hctosys") >> set;
  std::error_code none;
  if (set != '1' && !std::filesystem::exists(root / "run/systemd/timesync/synchronized", none)) return 0;
  return static_cast<std::uint32_t>(::time(nullptr));
}

}  // namespace thimble::board
