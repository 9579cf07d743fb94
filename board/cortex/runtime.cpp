#include "board/cortex/runtime.h"

#include <cstddef>
#include <cstdint>

extern "C" {
extern std::uint32_t data_begin, data_end, data_stored, bss_begin, bss_end;
extern void (*init_array_begin[])();
extern void (*init_array_end[])();

void __cxa_pure_virtual() { thimble::board::crash(); }
void abort() { thimble::board::crash(); }
void _exit(int) { thimble::board::crash(); }
}

namespace thimble::board {

void start_runtime() noexcept {
  const std::uint32_t* from = &data_stored;
  for (std::uint32_t* to = &data_begin; to < &data_end;) *to++ = *from++;
  for (std::uint32_t* to = &bss_begin; to < &bss_end;) *to++ = 0;
  for (void (**constructor)() = init_array_begin; constructor < init_array_end; ++constructor)
    (*constructor)();
}

}  // namespace thimble::board
