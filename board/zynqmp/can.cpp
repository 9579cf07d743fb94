#include "board/zynqmp/can.h"

#include <algorithm>

#include "firmware/link/host_address.h"
#include "firmware/link/messages.h"

namespace thimble::board {
namespace {

using firmware::link::CanFrame;

constexpr std::uint32_t kReset = 1U << 0U, kEnable = 1U << 1U;  // of srr
// of sr
constexpr std::uint32_t kConfigurationMode = 1U << 0U, kTransmitFull = 1U << 10U;
// of isr and icr
constexpr std::uint32_t kReceived = 1U << 4U, kReceiveOverflow = 1U << 6U, kReceiveNotEmpty = 1U << 7U,
                        kError = 1U << 8U, kBusOff = 1U << 9U;
constexpr std::uint32_t kAllInterrupts = 0x7FFF;
constexpr std::uint32_t kAllErrors = 0x1F;  // of esr
// Words that hold an id: 11 bits, their remote bit (or, extended, its substitute), extended, 18 bits, their
// remote bit.
constexpr std::uint32_t kSubstitute = 1U << 20U, kExtended = 1U << 19U, kRemote = 1U << 0U;
constexpr std::uint32_t kEveryIdBit = 0xFFFFFFFE;  // remote frames pass the filter too; the link drops them

// Bits of a frame without data and stuff bits, with the three bits of interframe space.
constexpr std::uint32_t kStandardBits = 47, kExtendedBits = 67;
constexpr firmware::link::Micros kAhead_us = 100;  // longest expected time of one cycle of the loop

constexpr std::uint32_t id_word(std::uint32_t id, bool extended, bool remote) noexcept {
  if (!extended) return id << 21U | (remote ? kSubstitute : 0);
  return (id >> 18U) << 21U | kSubstitute | kExtended | (id & 0x3FFFFU) << 1U | (remote ? kRemote : 0);
}

std::uint32_t big_endian(const std::uint8_t* bytes) noexcept {
  return std::uint32_t{bytes[0]} << 24U | std::uint32_t{bytes[1]} << 16U | std::uint32_t{bytes[2]} << 8U |
         bytes[3];
}

void to_bytes(std::uint32_t word, std::uint8_t* bytes) noexcept {
  for (unsigned i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(word >> (24U - 8U * i));
}

}  // namespace

Can::Can(volatile CanRegisters& registers, const CanTiming& timing, std::uint32_t bitrate,
         std::uint8_t node) noexcept
    : registers_(registers), timing_(timing), bitrate_(bitrate), node_(node) {
  start();
}

void Can::start() noexcept {
  registers_.srr = kReset;  // to configuration mode, FIFOs empty; the bit clears itself
  registers_.srr = 0;
  registers_.msr = 0;  // normal: no loop-back, no sleep, no snooping
  registers_.brpr = timing_.brpr();
  registers_.btr = timing_.btr();
  registers_.ier = 0;
  registers_.icr = kAllInterrupts;
  // A filter may be written only while it is off.
  registers_.afr = 0;
  registers_.filter[0].mask = id_word(firmware::link::kRequestMask, true, false);
  registers_.filter[0].id = id_word(firmware::link::request_id(node_), true, false);
  registers_.filter[1].mask = 0x7FFU << 21U | kExtended;
  registers_.filter[1].id = id_word(firmware::link::EmergencyStop::kId, false, false);
  registers_.filter[2].mask = kEveryIdBit;
  registers_.filter[2].id = id_word(std::uint32_t{firmware::link::ForceOrder::kId} + node_, false, false);
  registers_.filter[3].mask = id_word(firmware::link::kClaimMask, true, false);
  registers_.filter[3].id = id_word(firmware::link::claim_id(node_), true, false);
  registers_.afr = 0b1111;
  registers_.srr = kEnable;
  on_bus_ = true;
}

bool Can::receive(CanFrame& frame) noexcept {
  if (!on_bus_ || (registers_.isr & kReceiveNotEmpty) == 0) return false;
  const std::uint32_t id = registers_.rxfifo.id;  // takes the frame out of the FIFO
  const std::uint32_t dlc = registers_.rxfifo.dlc;
  const std::uint32_t data[2] = {registers_.rxfifo.data1, registers_.rxfifo.data2};
  registers_.icr = kReceiveNotEmpty | kReceived;  // kReceiveNotEmpty is set again while frames remain
  ++counters_.received;
  frame = {};
  frame.extended = (id & kExtended) != 0;
  frame.id = frame.extended ? (id >> 21U) << 18U | (id >> 1U & 0x3FFFFU) : id >> 21U;
  frame.remote = (id & (frame.extended ? kRemote : kSubstitute)) != 0;
  const std::uint32_t length = dlc >> 28U;
  frame.size = frame.remote
                   ? 0
                   : static_cast<std::uint8_t>(length < 8 ? length : 8);  // 9 to 15 mean 8 on a classic bus
  to_bytes(data[0], &frame.data[0]);
  to_bytes(data[1], &frame.data[4]);
  return true;
}

bool Can::can_send(firmware::link::Micros now) const noexcept {
  return on_bus_ && now + kAhead_us >= free_us_ && (registers_.sr & kTransmitFull) == 0;
}

void Can::send(const CanFrame& frame, firmware::link::Micros now) noexcept {
  const std::uint32_t bits = (frame.extended ? kExtendedBits : kStandardBits) + 8U * frame.size;
  free_us_ = std::max(free_us_, now) + bits * 1'000'000U / bitrate_;
  registers_.txfifo.id = id_word(frame.id, frame.extended, frame.remote);
  registers_.txfifo.dlc = std::uint32_t{frame.size} << 28U;
  registers_.txfifo.data1 = big_endian(&frame.data[0]);
  registers_.txfifo.data2 = big_endian(&frame.data[4]);  // the last word sends it
  ++counters_.sent;
}

void Can::supervise(firmware::link::Micros now) noexcept {
  if (!on_bus_) {
    if (now < back_us_) return;
    start();
    ++counters_.restarts;
    return;
  }
  const std::uint32_t status = registers_.isr;
  if ((status & kReceiveOverflow) != 0) {
    ++counters_.overflows;
    registers_.icr = kReceiveOverflow;
  }
  if ((status & kError) != 0) {
    ++counters_.errors;
    registers_.esr = kAllErrors;  // write 1 to clear
    registers_.icr = kError;
  }
  const bool bus_off = (status & kBusOff) != 0;
  if (bus_off || (registers_.sr & kConfigurationMode) != 0) {
    if (bus_off) ++counters_.bus_offs;
    registers_.srr = kReset;  // stays off the bus
    on_bus_ = false;
    back_us_ = now + kOffBus_us;
  }
}

}  // namespace thimble::board
