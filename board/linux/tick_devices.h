// The devices that the servo thread reads and writes once per tick. Implementations: the board's devices
// (devices.h), and tests.
#pragma once

#include <cstdint>

#include "firmware/core/config.h"

namespace thimble::board {

class TickDevices {
 public:
  virtual ~TickDevices() = default;
  // Fills arms, e-stop and dead-man switch; in.tick is already set. Waits at most for a bus transfer.
  virtual void read(firmware::Inputs& in, std::uint64_t now_ns, std::uint64_t period_ns) noexcept = 0;
  virtual void write(const firmware::Outputs& out) noexcept = 0;
  // Zero current and every drive off. Also called from the main thread when no servo runs.
  virtual void make_safe() noexcept = 0;
};

}  // namespace thimble::board
