#include "board/mps2-an500/uart.h"

#include <array>
#include <atomic>

#include "board/mps2-an500/registers.h"

namespace thimble::board::uart {
namespace {

constexpr std::uint32_t kBaud = 921'600;
constexpr std::uint32_t kTransmitterFull = 1U << 0U, kReceiverFull = 1U << 1U;
constexpr std::uint32_t kAll = 0xF;  // both directions and their interrupts

volatile UartRegisters& registers() noexcept { return at<UartRegisters>(kUart0); }

// One writer, one reader; kBytes is a power of two.
template <std::size_t kBytes>
class Ring {
 public:
  [[nodiscard]] bool push(char byte) noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == kBytes) return false;
    bytes_[head % kBytes] = byte;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }
  [[nodiscard]] bool pop(char& byte) noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (head_.load(std::memory_order_acquire) == tail) return false;
    byte = bytes_[tail % kBytes];
    tail_.store(tail + 1, std::memory_order_release);
    return true;
  }
  [[nodiscard]] std::size_t used() const noexcept {
    return head_.load(std::memory_order_acquire) - tail_.load(std::memory_order_acquire);
  }

 private:
  std::array<char, kBytes> bytes_{};
  std::atomic<std::uint32_t> head_{0};
  std::atomic<std::uint32_t> tail_{0};
};

constexpr std::size_t kReceiveBytes = 8192, kTransmitBytes = 8192;
constinit Ring<kReceiveBytes> receive;  // one complete block of an upload
constinit Ring<kTransmitBytes> transmit;
std::atomic<std::uint32_t> drops{0};

// Called with the transmit interrupt disabled, or from this interrupt.
void feed() noexcept {
  char byte = 0;
  while ((registers().state & kTransmitterFull) == 0 && transmit.pop(byte))
    registers().data = static_cast<std::uint8_t>(byte);
}

// The transmit interrupt occurs when the register becomes empty, so the first byte is written here.
class Guard {
 public:
  Guard() noexcept {
    asm volatile("mrs %0, basepri\n msr basepri, %1" : "=&r"(before_) : "r"(0x40U) : "memory");
  }
  ~Guard() { asm volatile("msr basepri, %0" ::"r"(before_) : "memory"); }
  Guard(const Guard&) = delete;
  Guard& operator=(const Guard&) = delete;

 private:
  std::uint32_t before_ = 0;
};

}  // namespace

void start() noexcept {
  registers().divider = kClock_Hz / kBaud;
  registers().control = kAll;
  for (const unsigned interrupt : {kUart0ReceiveInterrupt, kUart0TransmitInterrupt})
    at<std::uint8_t>(kInterruptPriority + interrupt) = 0x40;  // lower priority than the tick
  word(kInterruptEnable) = 1U << kUart0ReceiveInterrupt | 1U << kUart0TransmitInterrupt;
}

bool take(char& byte) noexcept { return receive.pop(byte); }

std::size_t room() noexcept { return kTransmitBytes - transmit.used(); }

bool put(std::string_view bytes) noexcept {
  if (bytes.size() > room()) return false;
  for (const char byte : bytes) static_cast<void>(transmit.push(byte));
  const Guard guard;
  feed();
  return true;
}

void forget() noexcept {
  const Guard guard;
  for (char byte = 0; transmit.pop(byte);) {
  }
}

bool sent() noexcept { return transmit.used() == 0 && (registers().state & kTransmitterFull) == 0; }

std::uint32_t dropped() noexcept { return drops.load(std::memory_order_relaxed); }

extern "C" void on_uart_receive() {
  registers().interrupts = 1U << 1U;
  while ((registers().state & kReceiverFull) != 0) {
    if (!receive.push(static_cast<char>(registers().data))) drops.store(drops.load() + 1);
  }
}

extern "C" void on_uart_transmit() {
  registers().interrupts = 1U << 0U;
  feed();
}

}  // namespace thimble::board::uart
