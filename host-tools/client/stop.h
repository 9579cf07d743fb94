// Stops everything on a link with the e-stop frame: no session, no address and no place among the hosts is needed, so it works
// whatever else goes on. Every node on the bus stops. One thread.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "firmware/link/messages.h"
#include "host-tools/client/transport.h"

namespace thimble::host {

inline constexpr link::Micros kStop_us = 2'000'000;  // by default a status is awaited so long

struct Stopped {
  link::Mode mode = link::Mode::kFaulted;  // faulted, or damping: the tip is braked, and the motors go off
  std::uint8_t fault = 0;                  // host_stop, unless another fault was there first
  double after_s = 0;                      // from the first frame to the status that confirms it
};

// The node has stopped with a fault, or stops: its tip is braked.
[[nodiscard]] inline bool has_stopped(const link::Status& status) {
  return status.fault != 0 && (status.mode == link::Mode::kFaulted || status.mode == link::Mode::kDamping);
}

// Sends the frame again and again until the node says in a status that it has stopped. Error kNotStopped: it has not said so in time; the
// errors of the transport.
[[nodiscard]] Stopped stop(Transport& transport, std::uint8_t node = 1, link::Micros wait_us = kStop_us);
// The same for who has no transport at hand: send() sends a frame; receive() gives the next one, or nothing once its deadline has passed.
[[nodiscard]] Stopped stop(
    const std::function<void(const link::CanFrame&)>& send,
    const std::function<std::optional<link::CanFrame>(link::Micros deadline_us)>& receive, std::uint8_t node,
    link::Micros wait_us);

}  // namespace thimble::host
