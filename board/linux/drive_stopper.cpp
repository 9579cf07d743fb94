#include "board/linux/drive_stopper.h"

#include <time.h>

#include <utility>

#include "board/linux/drives/protocol.h"

namespace thimble::board {

void DriveStopper::add(Descriptor socket, std::span<const drives::DriveConfig> bus) {
  drives::Outbox outbox;
  for (const drives::DriveConfig& config : bus) drives::make_protocol(config)->switch_off(outbox);
  const auto frames = outbox.frames();
  buses_.push_back({drives::CanSocket(std::move(socket)), {frames.begin(), frames.end()}});
}

void DriveStopper::stop() noexcept {
  // A queue that is full empties by a frame in about 0.1 ms.
  constexpr int kTries = 5;
  constexpr timespec kPause{0, 300'000};
  for (Bus& bus : buses_)
    for (int i = 0; i < kTries && bus.socket.send(bus.frames) == drives::CanSocket::Sent::kFull; ++i)
      nanosleep(&kPause, nullptr);
}

}  // namespace thimble::board
