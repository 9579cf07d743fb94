#include "host-tools/client/stop.h"

#include <algorithm>
#include <optional>
#include <string>

#include "host-tools/error.h"

namespace thimble::host {
namespace {

constexpr link::Micros kRepeat_us = 20'000;

}  // namespace

Stopped stop(Transport& transport, std::uint8_t node, link::Micros wait_us) {
  return stop([&](const link::CanFrame& frame) { transport.send(frame); },
              [&](link::Micros deadline_us) { return transport.receive(deadline_us); }, node, wait_us);
}

Stopped stop(const std::function<void(const link::CanFrame&)>& send,
             const std::function<std::optional<link::CanFrame>(link::Micros)>& receive, std::uint8_t node,
             link::Micros wait_us) {
  const link::Micros begin_us = now_us();
  const link::Micros deadline_us = begin_us + wait_us;
  while (receive(begin_us)) {
  }  // what came before the first frame confirms nothing
  std::optional<link::Status> heard;
  for (link::Micros now = begin_us; now < deadline_us; now = now_us()) {
    send(link::to_frame(link::EmergencyStop{}, 0));
    const link::Micros repeat_us = std::min(now + kRepeat_us, deadline_us);
    while (const std::optional<link::CanFrame> frame = receive(repeat_us)) {
      link::Status status;
      if (!link::from_frame(*frame, node, status)) continue;
      heard = status;
      if (has_stopped(status))
        return {status.mode, status.fault, static_cast<double>(now_us() - begin_us) * 1e-6};
    }
  }
  throw Error(
      ExitCode::kNotStopped, "not-stopped",
      heard ? "node " + std::to_string(node) + " is still " + name(heard->mode) + " after the e-stop frame"
            : "node " + std::to_string(node) + " has said nothing since the e-stop frame",
      "press the e-stop button, or switch the motors' supply off");
}

}  // namespace thimble::host
