// What the kernel module arm_hardware/arm_hardware.c shows of its digital-to-analogue converter: the file that arm_plant and stop_latency
// read. And the clock of both.
#pragma once

#include <time.h>

#include <array>
#include <cstdint>

namespace thimble::test {

struct ConverterOutputs {
  std::array<std::int16_t, 4> word;
  std::array<std::uint16_t, 4> range;
  std::uint16_t power;
  std::uint16_t bad_frames;
  std::uint32_t loads;
  std::uint64_t last_load_ns;  // CLOCK_MONOTONIC
};
static_assert(sizeof(ConverterOutputs) == 32);

inline std::uint64_t now_ns() {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return static_cast<std::uint64_t>(time.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(time.tv_nsec);
}

}  // namespace thimble::test
