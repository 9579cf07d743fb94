// The CAN controller of Zynq and Zynq UltraScale+ (XCANPS, UG1085 chapter 20), polled. Classic CAN only: this controller
// knows no FD frames.
//
// Called from the background. Nothing here waits: what comes stands in a FIFO of 64 frames until receive() takes it, what
// goes leaves through another of 64. A FIFO that overflowed lost frames, and how many it does not tell: counted once each.
// A controller that went off the bus (its error counter passed 255), or that is found in configuration mode, is reset and
// comes back after kOffBus_us; what waited to be sent is lost then, and counted as one restart.
#pragma once

#include <cstdint>

#include "board/zynqmp/can_timing.h"
#include "board/zynqmp/registers.h"
#include "firmware/link/can_frame.h"

namespace thimble::board {

class Can {
 public:
  struct Counters {
    std::uint32_t received = 0;
    std::uint32_t sent = 0;       // given to the controller
    std::uint32_t overflows = 0;  // of the receive FIFO
    std::uint32_t errors = 0;  // polls that found an error on the bus (acknowledge, bit, stuff, form or CRC)
    std::uint32_t bus_offs = 0;
    std::uint32_t restarts = 0;  // after a bus-off, or found in configuration mode
  };
  // Until it takes part again after a bus-off: as long as Linux is usually told to wait (`ip link ... restart-ms 100`).
  static constexpr firmware::link::Micros kOffBus_us = 100'000;

  // Takes the frames for this node: its requests, the forces that a host orders of it, and the e-stop.
  Can(volatile CanRegisters& registers, const CanTiming& timing, std::uint32_t bitrate,
      std::uint8_t node) noexcept;

  // The next frame that came; false: none. At most 64 wait.
  [[nodiscard]] bool receive(firmware::link::CanFrame& frame) noexcept;
  // Whether a frame can leave soon. Not while the bus is lost, nor while nobody acknowledges and the FIFO is full; and no faster than the
  // bit rate lets frames leave: what stood in the FIFO would leave before an emergency that comes now.
  [[nodiscard]] bool can_send(firmware::link::Micros now) const noexcept;
  void send(const firmware::link::CanFrame& frame,
            firmware::link::Micros now) noexcept;  // classic, and only after can_send()
  // Looks after errors; in every round of the background.
  void supervise(firmware::link::Micros now) noexcept;

  [[nodiscard]] const Counters& counters() const noexcept { return counters_; }

 private:
  void start() noexcept;

  volatile CanRegisters& registers_;
  CanTiming timing_;
  std::uint32_t bitrate_;
  std::uint8_t node_;
  Counters counters_;
  bool on_bus_ = false;
  firmware::link::Micros back_us_ = 0;
  firmware::link::Micros free_us_ = 0;  // when the bus will have carried what was sent, were it ours alone
};

}  // namespace thimble::board
