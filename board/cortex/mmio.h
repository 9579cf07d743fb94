// Access to memory-mapped registers.
#pragma once

#include <cstdint>

namespace thimble::board {

template <class Registers>
[[nodiscard]] inline volatile Registers& at(std::uintptr_t address) noexcept {
  return *reinterpret_cast<volatile Registers*>(address);
}
[[nodiscard]] inline volatile std::uint32_t& word(std::uintptr_t address) noexcept {
  return at<std::uint32_t>(address);
}

}  // namespace thimble::board
