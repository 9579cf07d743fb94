// Random play with the simulated arm, for hours of its time: every demonstration, hands, hosts that ask, write, upload and stop, faults of
// the hardware, restarts. Deterministic: the same seed plays the same.
//
// Whatever goes wrong by itself is in `complaints`: a fault that nothing explains, a tick that did not come, a drive that stays on, a
// force that is too great, an arm that cannot be armed again.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "firmware/core/faults.h"

namespace thimble::test {

struct Demonstration {
  std::string name;
  std::vector<std::byte> image;
  std::string stroke;  // file of the hand's path
};
// Every scene below the folder `scenes` that has a stroke.
[[nodiscard]] std::vector<Demonstration> demonstrations();

struct Played {
  double simulated_s = 0;
  double armed_s = 0;
  std::uint64_t ticks = 0;
  std::uint32_t boards = 0, arms_armed = 0, swaps = 0, uploads = 0, requests = 0, writes = 0, stops = 0,
                rivals = 0;
  std::uint32_t injected = 0;              // faults of the hardware
  std::array<std::uint32_t, 256> named{};  // by firmware::Fault: faults that the controller named
  std::uint32_t probes = 0;                // of the encoders
  std::vector<std::string> complaints;
};

// From the seed, for this simulated time.
[[nodiscard]] Played play(std::uint64_t seed, double seconds);

}  // namespace thimble::test
