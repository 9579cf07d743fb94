// A recording replayed by the same core (board/sim/replay.h), and compared with the checks that the device sent.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "board/sim/simulation.h"
#include "host-tools/lab/recording.h"

namespace thimble::host {

struct ReplayVerdict {
  std::uint64_t ticks = 0;   // replayed
  std::uint64_t checks = 0;  // of those that agreed
  // Numbers of ticks, as the device counts them; the first one has start.tick + 1.
  std::uint64_t first_tick = 0;
  std::uint64_t exact_to =
      0;  // all forces up to this tick are the device's; first_tick - 1: none was checked
  std::optional<std::uint64_t> differs_at;  // the first check that does not agree
  std::optional<std::uint64_t>
      gap_at;  // the first tick that is missing, or whose check is; nothing behind it is replayed
  std::uint64_t not_replayed = 0;  // ticks of the file behind the gap
  double peak_force_N = 0;
  std::uint64_t contact_ticks = 0;  // with a contact of any arm
  [[nodiscard]] bool exact() const { return !differs_at && !gap_at; }
};

// Calls row() for every tick and arm. Error kBadInput `cannot-replay`: the recording has an arm model or parameter that this program does not know.
[[nodiscard]] ReplayVerdict replay_recording(const Recording& recording,
                                             const std::function<void(const board::LogRow&)>& row = {});

}  // namespace thimble::host
