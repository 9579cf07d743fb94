#include "board/mps2-an500/eeprom.h"

#include <algorithm>
#include <array>

#include "board/mps2-an500/registers.h"

namespace thimble::board::eeprom {
namespace {

constexpr std::uint32_t kClockLine = 1U << 0U, kDataLine = 1U << 1U;
constexpr std::size_t kPageBytes = 128;
constexpr std::uint8_t kFirstChip = 0xA0;  // 0x50, as the byte on the bus; bit 0 set reads
constexpr int kMostPolls = 1000;           // while a chip writes a page; 5 ms are 50 polls

volatile I2cRegisters& lines() noexcept { return at<I2cRegisters>(kShield1I2c); }

// 1.3 us at 25 MHz, half a bit at 400 kHz.
void half_bit() noexcept {
  for (int i = 0; i < 8; ++i) asm volatile("nop");
}
void clock(bool high) noexcept {
  (high ? lines().set : lines().clear) = kClockLine;
  half_bit();
}
void data(bool high) noexcept { (high ? lines().set : lines().clear) = kDataLine; }

void begin() noexcept {
  data(true);
  clock(true);
  data(false);
  half_bit();
  clock(false);
}
void end() noexcept {
  data(false);
  clock(true);
  data(true);
  half_bit();
}
// True: acknowledged.
bool send(std::uint8_t byte) noexcept {
  for (int bit = 7; bit >= 0; --bit) {
    data((byte >> bit & 1) != 0);
    clock(true);
    clock(false);
  }
  data(true);
  clock(true);
  const bool acknowledged = (lines().set & kDataLine) == 0;
  clock(false);
  return acknowledged;
}
std::uint8_t receive(bool more) noexcept {
  unsigned byte = 0;
  data(true);
  for (int bit = 0; bit < 8; ++bit) {
    clock(true);
    byte = byte << 1U | ((lines().set & kDataLine) != 0 ? 1U : 0U);
    clock(false);
  }
  data(!more);
  clock(true);
  clock(false);
  data(true);
  return static_cast<std::uint8_t>(byte);
}

std::uint8_t chip_of(std::size_t address) noexcept {
  return static_cast<std::uint8_t>(kFirstChip | address / kChipBytes << 1U);
}

// A chip does not answer while it writes a page.
bool select(std::size_t address) noexcept {
  for (int poll = 0; poll < kMostPolls; ++poll) {
    begin();
    if (send(chip_of(address))) {
      return send(static_cast<std::uint8_t>(address % kChipBytes >> 8U)) &&
             send(static_cast<std::uint8_t>(address));
    }
    end();
  }
  return false;
}

bool write_page(std::size_t address, std::span<const std::byte> bytes) noexcept {
  bool taken = select(address);
  for (const std::byte byte : bytes) taken = taken && send(std::to_integer<std::uint8_t>(byte));
  end();
  if (!taken) return false;
  std::array<std::byte, kPageBytes> held{};
  const auto now = std::span(held).first(bytes.size());
  return read(address, now) && std::equal(bytes.begin(), bytes.end(), now.begin());
}

// If the processor was reset during a read, the chip holds the data line until its byte has been clocked out.
void free_bus() noexcept {
  constexpr int kClocks = 9;
  data(true);
  for (int i = 0; i < kClocks; ++i) {
    clock(false);
    clock(true);
  }
  clock(false);
  end();
}

}  // namespace

std::size_t chips() noexcept {
  free_bus();
  std::size_t count = 0;
  for (; count < kMostChips; ++count) {
    begin();
    const bool there = send(chip_of(count * kChipBytes));
    end();
    if (!there) break;
  }
  return count;
}

bool read(std::size_t address, std::span<std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), kChipBytes - address % kChipBytes);
    bool there = select(address);
    if (there) {
      begin();
      there = send(static_cast<std::uint8_t>(chip_of(address) | 1U));
      for (std::size_t i = 0; there && i < now; ++i) bytes[i] = static_cast<std::byte>(receive(i + 1 < now));
    }
    end();
    if (!there) return false;
    address += now;
    bytes = bytes.subspan(now);
  }
  return true;
}

bool write(std::size_t address, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), kPageBytes - address % kPageBytes);
    if (!write_page(address, bytes.first(now))) return false;
    address += now;
    bytes = bytes.subspan(now);
  }
  return true;
}

}  // namespace thimble::board::eeprom
