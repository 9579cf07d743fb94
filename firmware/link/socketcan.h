// A CAN frame as Linux has it on a raw socket: struct can_frame (16 bytes) or struct canfd_frame (72).
//
// Who calls it: both ends where they run on Linux. Only a change of layout; the sockets are theirs. A bare-metal board does not
// include it.
#pragma once

#include <linux/can.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "firmware/link/can_frame.h"

namespace thimble::firmware::link {

// Fills `raw` and returns how many of its bytes are to be written.
[[nodiscard]] inline std::size_t to_socketcan(const CanFrame& frame, canfd_frame& raw) noexcept {
  raw = {};
  raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) | (frame.remote ? CAN_RTR_FLAG : 0U);
  raw.len = frame.size;
  if (frame.fd && frame.bit_rate_switch) raw.flags = CANFD_BRS;
  std::copy_n(frame.data.begin(), frame.size, static_cast<std::uint8_t*>(raw.data));
  return frame.fd ? CANFD_MTU : CAN_MTU;
}

// What was read, `bytes` long. False: no such length, or an error frame (CAN_ERR_FLAG).
[[nodiscard]] inline bool from_socketcan(const canfd_frame& raw, std::size_t bytes,
                                         CanFrame& frame) noexcept {
  const bool fd = bytes == CANFD_MTU;
  if ((!fd && bytes != CAN_MTU) || (raw.can_id & CAN_ERR_FLAG) != 0) return false;
  frame = {};
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  frame.fd = fd;
  frame.bit_rate_switch = fd && (raw.flags & CANFD_BRS) != 0;
  frame.size = raw.len;
  if (!is_valid(frame)) return false;
  std::copy_n(static_cast<const std::uint8_t*>(raw.data), frame.size, frame.data.begin());
  return true;
}

}  // namespace thimble::firmware::link
