// The two scene slots as a board gives them: flash, a file, or memory. Called from the background only, but
// what is mapped is read by the tick, in place.
#pragma once

#include <cstddef>
#include <span>

namespace thimble::firmware {

class Storage {
 public:
  static constexpr unsigned kSlots = 2;

  // Slot contents in place: at least 8-byte aligned, at the same address and size for ever. Both slots have
  // one size.
  [[nodiscard]] virtual std::span<const std::byte> slot(unsigned index) const noexcept = 0;

  // Makes the first `bytes` of a slot writable (at least; a flash rounds up to its sectors). May take long on
  // a flash; power may fail in the middle, and then the slot holds anything. False: the hardware refused.
  [[nodiscard]] virtual bool erase(unsigned index, std::size_t bytes) noexcept = 0;

  // Writes bytes that were erased and not written since. The store writes in ascending order, the slot's
  // header last; power may fail after any byte.
  [[nodiscard]] virtual bool write(unsigned index, std::size_t offset,
                                   std::span<const std::byte> bytes) noexcept = 0;

 protected:
  ~Storage() = default;
};

}  // namespace thimble::firmware
