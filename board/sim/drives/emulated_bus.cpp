#include "board/sim/drives/emulated_bus.h"

#include <linux/can.h>
#include <sys/socket.h>

#include <algorithm>
#include <limits>

#include "firmware/link/socketcan.h"

namespace thimble::board::emulated {

void EmulatedBus::run(std::uint64_t now_us) {
  for (const auto& drive : drives_) drive->advance(now_us);
  canfd_frame raw{};
  for (;;) {
    const ssize_t got = recv(socket_.get(), &raw, sizeof(raw), MSG_DONTWAIT);
    if (got <= 0) break;
    CanFrame frame;
    if (!firmware::link::from_socketcan(raw, static_cast<std::size_t>(got), frame)) continue;
    ++heard_;
    if (tap != nullptr) tap->push_back(frame);
    for (const auto& drive : drives_) drive->hear(frame, now_us);
  }
  std::vector<Outgoing> due;
  for (const auto& drive : drives_)
    std::erase_if(drive->outgoing(), [&](const Outgoing& one) {
      if (one.due_us > now_us) return false;
      due.insert(std::ranges::upper_bound(due, one.due_us, {}, &Outgoing::due_us), one);
      return true;
    });
  if (swap_next_two && due.size() >= 2) {
    std::swap(due[0], due[1]);
    swap_next_two = false;
  }
  for (const Outgoing& one : due) send(one.frame);
}

std::uint64_t EmulatedBus::next_due_us() const {
  std::uint64_t due_us = std::numeric_limits<std::uint64_t>::max();
  for (const auto& drive : drives_)
    for (const Outgoing& one : drive->outgoing()) due_us = std::min(due_us, one.due_us);
  return due_us;
}

void EmulatedBus::send(const CanFrame& frame) {
  if (tap != nullptr) tap->push_back(frame);
  canfd_frame raw{};
  const std::size_t bytes = firmware::link::to_socketcan(frame, raw);
  send_raw(std::as_bytes(std::span(&raw, 1)).first(bytes));
}

void EmulatedBus::send_raw(std::span<const std::byte> bytes) {
  // A host that reads nothing loses frames, as with a full controller.
  (void)::send(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
}

}  // namespace thimble::board::emulated
