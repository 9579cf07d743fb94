// The CAN interfaces of this machine and how they are set up, as the kernel tells over netlink.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace thimble::board {

enum class BusState { kErrorActive, kErrorWarning, kErrorPassive, kBusOff, kStopped, kSleeping };

// A controller behind an interface; vcan has none.
struct CanController {
  BusState state = BusState::kErrorActive;
  std::uint32_t bit_rate = 0;         // bit/s; 0: not set
  std::uint32_t sample_point = 0;     // in thousandths of a bit
  std::uint32_t data_bit_rate = 0;    // of FD frames' data
  std::uint32_t restart_ms = 0;       // 0: after bus off it stays off
  std::uint32_t transmit_errors = 0;  // its counters, where the driver tells
  std::uint32_t receive_errors = 0;
  bool listen_only = false;
};

struct CanInterface {
  std::string name;
  bool up = false;
  bool fd = false;  // it takes FD frames
  std::uint32_t queue_frames = 0;
  std::optional<CanController> controller;
};

// By name. Throws std::system_error where the kernel does not answer.
[[nodiscard]] std::vector<CanInterface> read_can_interfaces();

}  // namespace thimble::board
