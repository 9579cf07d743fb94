#include "board/zynqmp/memory.h"

#include <cstdint>

#include "board/zynqmp/board.h"

extern "C" {  // of zynqmp.ld
extern const char code_origin[], data_origin[], slots_origin[], outside_origin[];
}

namespace thimble::board {
namespace {

// Region access control (DRACR): Cortex-R5 Technical Reference Manual 4.3.21.
constexpr std::uint32_t kNeverExecuted = 1U << 12U, kReadWrite = 3U << 8U, kReadOnly = 6U << 8U;
constexpr std::uint32_t kCached = 1U << 3U | 3U;  // normal, write-back, write-allocate
constexpr std::uint32_t kUncached = 1U
                                    << 3U;  // normal memory; the tightly coupled memory is as fast as a cache
constexpr std::uint32_t kDevice = 1U;

// Size field of DRSR: log2(bytes) - 1; bit 0 switches the region on.
constexpr std::uint32_t size(unsigned log2_bytes) noexcept { return (log2_bytes - 1) << 1U | 1U; }

void set_region(std::uint32_t number, const void* base, std::uint32_t size_and_on,
                std::uint32_t access) noexcept {
  asm volatile(
      "mcr p15, 0, %0, c6, c2, 0\n"  // RGNR
      "mcr p15, 0, %1, c6, c1, 0\n"  // DRBAR
      "mcr p15, 0, %3, c6, c1, 4\n"  // DRACR
      "mcr p15, 0, %2, c6, c1, 2\n"  // DRSR
      ::"r"(number),
      "r"(base), "r"(size_and_on), "r"(access)
      : "memory");
}

constexpr std::uint32_t kOutside = 4;

}  // namespace

void permit_outside(bool permitted) noexcept {
  set_region(kOutside, outside_origin, size(20), kCached | (permitted ? kReadOnly : kNeverExecuted));
  asm volatile("dsb\n isb" ::: "memory");
}

// Where regions overlap, the one with the higher number applies.
void protect_memory() noexcept {
  const auto* const peripherals = reinterpret_cast<const void*>(std::uintptr_t{0xFF000000});
  set_region(0, peripherals, size(24), kDevice | kReadWrite | kNeverExecuted);
  set_region(1, code_origin, size(18), kUncached | kReadOnly);
  set_region(2, data_origin, size(18), kCached | kReadWrite | kNeverExecuted);
  set_region(3, slots_origin, size(24), kCached | kReadWrite | kNeverExecuted);
  permit_outside(true);
  set_region(kOutside + 1, board_fabric, size(12), kDevice | kReadWrite | kNeverExecuted);
  for (std::uint32_t unused = kOutside + 2; unused < 16; ++unused) set_region(unused, nullptr, 0, 0);
  std::uint32_t control = 0;
  asm volatile("mrc p15, 0, %0, c1, c0, 0" : "=r"(control));
  control &= ~(1U << 17U);                     // BR: no background region
  control |= 1U << 0U | 1U << 2U | 1U << 12U;  // M, C, I
  asm volatile("dsb\n mcr p15, 0, %0, c1, c0, 0\n isb" ::"r"(control) : "memory");
}

}  // namespace thimble::board
