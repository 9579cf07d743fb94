// The CAN controller of Zynq and Zynq UltraScale+ (XCANPS, UG1085 chapter 20), polled. Classic CAN only: this
// controller does not support FD frames.
//
// Called from the background. No function waits: received frames stay in a FIFO of 64 frames until receive()
// reads them, and frames to be sent go through another FIFO of 64. An overflow loses an unknown number of
// frames and is counted once. A CAN controller that is bus-off (its error counter exceeded 255), or in
// configuration mode, is reset and restarts after kOffBus_us; frames that wait to be sent are lost then, and
// one restart is counted.
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
    std::uint32_t sent = 0;       // written to the controller
    std::uint32_t overflows = 0;  // of the receive FIFO
    std::uint32_t errors = 0;  // polls that found an error on the bus (acknowledge, bit, stuff, form or CRC)
    std::uint32_t bus_offs = 0;
    std::uint32_t restarts = 0;  // after a bus-off, or found in configuration mode
  };
  // Time from a bus-off to the restart: the usual value on Linux (`ip link ... restart-ms 100`).
  static constexpr firmware::link::Micros kOffBus_us = 100'000;

  // Accepts the frames for this node: requests and address claims of all hosts, force commands and the e-stop.
  Can(volatile CanRegisters& registers, const CanTiming& timing, std::uint32_t bitrate,
      std::uint8_t node) noexcept;

  // The next received frame; false: none. At most 64 are queued.
  [[nodiscard]] bool receive(firmware::link::CanFrame& frame) noexcept;
  // True if a frame can be sent soon: not while bus-off, not while the FIFO is full because nobody
  // acknowledges, and no faster than the bit rate allows, because frames in the FIFO would delay an emergency
  // frame.
  [[nodiscard]] bool can_send(firmware::link::Micros now) const noexcept;
  void send(const firmware::link::CanFrame& frame,
            firmware::link::Micros now) noexcept;  // classic, and only after can_send()
  // Handles errors; called in every cycle of the background.
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
  firmware::link::Micros free_us_ =
      0;  // time at which all sent frames would have left on an otherwise idle bus
};

}  // namespace thimble::board
