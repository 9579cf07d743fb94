#include "board/zynqmp/nor.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "board/zynqmp/clock.h"
#include "board/zynqmp/registers.h"

namespace thimble::board {
namespace {

// Bits of cfg: I/O mode (no DMA), automatic start of commands, write protect and hold driven high, 300 MHz /
// 8.
constexpr std::uint32_t kConfiguration = 1U << 19U | 2U << 3U;
// of isr
constexpr std::uint32_t kRxEmpty = 1U << 11U, kGenFifoEmpty = 1U << 7U, kTxEmpty = 1U << 8U,
                        kTxFull = 1U << 3U;
constexpr std::uint32_t kResetFifos = 0x7;  // of fifo_ctrl
// An entry of gen_fifo.
constexpr std::uint32_t kImmediate = 0xFF, kDataXfer = 1U << 8U, kExponent = 1U << 9U, kSpiMode = 1U << 10U,
                        kChipSelect = 1U << 12U, kLowerBus = 1U << 14U, kTransmit = 1U << 16U,
                        kReceive = 1U << 17U;
constexpr std::uint32_t kLine = kSpiMode | kLowerBus;
constexpr std::uint32_t kSetup = 4;  // clocks between the select and the first bit

// Commands of the flash; addresses have 4 bytes.
constexpr std::uint8_t kReadId = 0x9F, kReadStatus = 0x05, kWriteEnable = 0x06, kRead = 0x13, kProgram = 0x12,
                       kEraseSector = 0xDC;
constexpr std::uint8_t kBusy = 0x01;           // of the status
constexpr std::uint8_t k64MiB = 0x20;          // third byte of the id: log2 of the size, in Micron's encoding
constexpr std::uint32_t kTransfer_us = 5'000;  // 256 bytes take 60 us
constexpr std::uint32_t kProgram_us = 10'000;
constexpr std::uint32_t kErase_us = 1'500'000;

volatile GqspiRegisters& registers() noexcept { return at<GqspiRegisters>(kGqspi); }

// Waits until a bit of isr has the given value; false: not within kTransfer_us.
bool wait_for(std::uint32_t bit, bool set) noexcept {
  if (((registers().isr & bit) != 0) == set) return true;
  const firmware::link::Micros from = clock::now_us();
  while (((registers().isr & bit) != 0) != set) {
    if (clock::now_us() - from > kTransfer_us) return false;
  }
  return true;
}

// One chip select cycle: begin(), transfers, end().
void begin() noexcept { registers().gen_fifo = kLine | kChipSelect | kSetup; }
bool end(bool done) noexcept {
  registers().gen_fifo = kLine | kSetup;
  const bool ended = wait_for(kGenFifoEmpty, true) && done;
  if (!ended) registers().fifo_ctrl = kResetFifos;  // remaining bytes would shift the next transfer
  return ended;
}

// At most a page; written as words, the last one padded; the controller does not send the padding.
bool send(std::span<const std::byte> bytes) noexcept {
  if (bytes.size() == Nor::kPageBytes) {
    registers().gen_fifo = kLine | kChipSelect | kTransmit | kDataXfer | kExponent | 8;
  } else {
    registers().gen_fifo =
        kLine | kChipSelect | kTransmit | kDataXfer | (static_cast<std::uint32_t>(bytes.size()) & kImmediate);
  }
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint32_t)) {
    std::uint32_t data = 0;
    std::memcpy(&data, &bytes[at], std::min(bytes.size() - at, sizeof data));
    if (!wait_for(kTxFull, false)) return false;
    registers().txd = data;
  }
  return wait_for(kTxEmpty, true);
}

bool receive(std::span<std::byte> bytes) noexcept {
  if (bytes.size() == Nor::kPageBytes) {
    registers().gen_fifo = kLine | kChipSelect | kReceive | kDataXfer | kExponent | 8;
  } else {
    registers().gen_fifo =
        kLine | kChipSelect | kReceive | kDataXfer | (static_cast<std::uint32_t>(bytes.size()) & kImmediate);
  }
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint32_t)) {
    if (!wait_for(kRxEmpty, false)) return false;
    const std::uint32_t data = registers().rxd;
    std::memcpy(&bytes[at], &data, std::min(bytes.size() - at, sizeof data));
  }
  return true;
}

bool command(std::uint8_t code) noexcept {
  begin();
  const std::array bytes{std::byte{code}};
  const bool sent = send(bytes);
  return end(sent);
}

bool command(std::uint8_t code, std::uint32_t address, std::span<const std::byte> out,
             std::span<std::byte> in) noexcept {
  begin();
  const std::array bytes{std::byte{code}, static_cast<std::byte>(address >> 24U),
                         static_cast<std::byte>(address >> 16U), static_cast<std::byte>(address >> 8U),
                         static_cast<std::byte>(address)};
  const bool done = send(bytes) && (out.empty() || send(out)) && (in.empty() || receive(in));
  return end(done);
}

bool ask(std::uint8_t code, std::span<std::byte> answer) noexcept {
  begin();
  const std::array bytes{std::byte{code}};
  const bool done = send(bytes) && receive(answer);
  return end(done);
}

}  // namespace

Nor::Nor(control::Pause pause) noexcept : pause_(pause) {
  registers().sel = 1;  // the generic half
  registers().en = 0;
  registers().idr = ~0U;
  registers().fifo_ctrl = kResetFifos;
  registers().cfg = kConfiguration;
  registers().rx_thresh = 1;
  registers().tx_thresh = 1;
  registers().gf_thresh = 1;
  registers().lpbk_dly_adj = 0;
  registers().en = 1;
  std::array<std::byte, 3> id{};
  present_ = ask(kReadId, id) && id[2] == std::byte{k64MiB};
}

bool Nor::read(std::uint32_t address, std::span<std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const std::size_t now = std::min(bytes.size(), kPageBytes);
    if (!command(kRead, address, {}, bytes.first(now))) return false;
    if (pause_ != nullptr) pause_();
    address += static_cast<std::uint32_t>(now);
    bytes = bytes.subspan(now);
  }
  return true;
}

bool Nor::wait_until_done(std::uint32_t limit_us) noexcept {
  const firmware::link::Micros from = clock::now_us();
  for (;;) {
    std::array<std::byte, 1> status{};
    if (!ask(kReadStatus, status)) return false;
    if ((status[0] & std::byte{kBusy}) == std::byte{}) return true;
    if (clock::now_us() - from > limit_us) return false;
    if (pause_ != nullptr) pause_();
  }
}

bool Nor::erase_sector(std::uint32_t address) noexcept {
  address -= address % static_cast<std::uint32_t>(kSectorBytes);
  if (!command(kWriteEnable) || !command(kEraseSector, address, {}, {}) || !wait_until_done(kErase_us))
    return false;
  std::array<std::byte, kPageBytes> held{};
  for (std::uint32_t at = 0; at < kSectorBytes; at += static_cast<std::uint32_t>(kPageBytes)) {
    if (!read(address + at, held) ||
        !std::ranges::all_of(held, [](std::byte b) { return b == std::byte{0xFF}; }))
      return false;
  }
  return true;
}

bool Nor::write_page(std::uint32_t address, std::span<const std::byte> bytes) noexcept {
  if (!command(kWriteEnable) || !command(kProgram, address, bytes, {}) || !wait_until_done(kProgram_us))
    return false;
  std::array<std::byte, kPageBytes> held{};
  const auto now = std::span(held).first(bytes.size());
  return read(address, now) && std::ranges::equal(bytes, now);
}

bool Nor::write(std::uint32_t address, std::span<const std::byte> bytes) noexcept {
  while (!bytes.empty()) {
    const std::size_t now = std::min<std::size_t>(bytes.size(), kPageBytes - address % kPageBytes);
    if (!write_page(address, bytes.first(now))) return false;
    address += static_cast<std::uint32_t>(now);
    bytes = bytes.subspan(now);
  }
  return true;
}

}  // namespace thimble::board
