#include "board/zynqmp/uart.h"

#include <array>

#include "board/zynqmp/registers.h"

namespace thimble::board::uart {
namespace {

// of control: both directions reset, then enabled
constexpr std::uint32_t kResets = 0x03, kEnables = 0x14;
constexpr std::uint32_t kEightBitsNoParity = 0x20;  // of mode
// of channel_status
constexpr std::uint32_t kReceiverEmpty = 1U << 1U, kTransmitterEmpty = 1U << 3U, kTransmitterFull = 1U << 4U;
constexpr std::uint32_t kOverrun = 1U << 5U;  // of int_status
constexpr std::uint32_t kSamples = 5;         // of a bit, one more than baud_rate_divider

constexpr std::size_t kBytes = 8192;                       // a power of two
[[gnu::section(".slots")]] std::array<char, kBytes> ring;  // in DDR: the fast memory is for the controller
std::uint32_t head = 0, tail = 0;
std::uint32_t overrun_count = 0;

volatile UartRegisters& registers() noexcept { return at<UartRegisters>(kUart1); }

}  // namespace

void start(std::uint32_t clock_Hz, std::uint32_t baud) noexcept {
  registers().control = kResets;
  registers().mode = kEightBitsNoParity;
  registers().baud_rate_gen = (clock_Hz + baud * kSamples / 2) / (baud * kSamples);
  registers().baud_rate_divider = kSamples - 1;
  registers().int_disable = ~0U;
  registers().receiver_timeout = 0;
  registers().control = kEnables;
}

bool take(char& byte) noexcept {
  if ((registers().int_status & kOverrun) != 0) {
    registers().int_status = kOverrun;
    ++overrun_count;
  }
  if ((registers().channel_status & kReceiverEmpty) != 0) return false;
  byte = static_cast<char>(registers().fifo);
  return true;
}

std::size_t room() noexcept { return kBytes - (head - tail); }

bool put(std::string_view bytes) noexcept {
  if (bytes.size() > room()) return false;
  for (const char byte : bytes) ring[head++ % kBytes] = byte;
  return true;
}

void feed() noexcept {
  while (head != tail && (registers().channel_status & kTransmitterFull) == 0)
    registers().fifo = static_cast<std::uint8_t>(ring[tail++ % kBytes]);
}

void forget() noexcept { tail = head; }

bool sent() noexcept { return head == tail && (registers().channel_status & kTransmitterEmpty) != 0; }

std::uint32_t overruns() noexcept { return overrun_count; }

}  // namespace thimble::board::uart
