// A bank of 24C512 EEPROMs (64 KiB each, I2C addresses 0x50 to 0x57) on the second shield connector: one
// address range. Called from the background. Writing a page takes 5 ms; the call waits for it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::board::eeprom {

inline constexpr std::size_t kChipBytes = 65536;
inline constexpr std::size_t kMostChips = 8;

// Number of consecutive chips that answer, from 0x50 on.
[[nodiscard]] std::size_t chips() noexcept;

// False: a chip did not answer, or (write) the verification failed.
[[nodiscard]] bool read(std::size_t address, std::span<std::byte> bytes) noexcept;
[[nodiscard]] bool write(std::size_t address, std::span<const std::byte> bytes) noexcept;

}  // namespace thimble::board::eeprom
