// The simulated controller that `thimble view --scene` starts: in this process, in a thread of its own, in real time, with hands that
// follow the positions that a page gives. Its link is a pair of sockets in this process; other programs of this user can open its pty. All
// public functions may be called from any thread.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "board/sim/live_board.h"
#include "host-tools/client/descriptor.h"
#include "host-tools/client/transport.h"
#include "host-tools/viewer/simulated_hands.h"

namespace thimble::host {

class SimulatedDevice {
 public:
  // Throws what LiveBoard throws.
  explicit SimulatedDevice(const board::LiveOptions& options);
  SimulatedDevice(const SimulatedDevice&) = delete;
  SimulatedDevice& operator=(const SimulatedDevice&) = delete;
  ~SimulatedDevice();  // ends the thread

  [[nodiscard]] const std::string& uri() const { return uri_; }  // for other programs
  [[nodiscard]] std::unique_ptr<Transport> connect() const;      // for this one, once at a time
  [[nodiscard]] SimulatedHands& hands() { return hands_; }

 private:
  std::atomic<bool> stopping_ = false;
  Descriptor host_end_{-1};
  board::LiveBoard live_;
  SimulatedHands hands_;
  std::string uri_;
  std::thread thread_;
};

}  // namespace thimble::host
