// Files of the PC for a program under QEMU (ARM semihosting 2.0): where a test on bare metal leaves its results.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace thimble::test {

inline long semihosting(long operation, const void* argument) noexcept {
  register long r0 asm("r0") = operation;
  register const void* r1 asm("r1") = argument;
  // The call is BKPT on profile M only. On A and R it is SVC, with another number in each state (Arm's semihosting specification); the
  // emulator hangs on a BKPT there.
#if __ARM_ARCH_PROFILE == 'M'
  asm volatile("bkpt 0xAB" : "+r"(r0) : "r"(r1) : "memory");
#elif defined(__thumb__)
  asm volatile("svc 0xAB" : "+r"(r0) : "r"(r1) : "memory", "lr");
#else
  asm volatile("svc 0x123456" : "+r"(r0) : "r"(r1) : "memory", "lr");
#endif
  return r0;
}

// A handle for writing, in QEMU's working directory; below 0: it can't be opened.
template <std::size_t kSize>
[[nodiscard]] long open_for_writing(const char (&name)[kSize]) noexcept {
  const struct {
    const char* name;
    long mode;
    long length;
  } argument = {name, 5, kSize - 1};  // "wb"
  return semihosting(0x01, &argument);
}

[[nodiscard]] inline bool write(long file, std::span<const std::byte> bytes) noexcept {
  const struct {
    long file;
    const std::byte* bytes;
    std::size_t size;
  } argument = {file, bytes.data(), bytes.size()};
  return semihosting(0x05, &argument) == 0;  // bytes not written
}

[[noreturn]] inline void exit_with(int code) noexcept {
  const struct {
    std::uint32_t reason;
    int code;
  } argument = {0x20026, code};  // application exit
  semihosting(0x20, &argument);
  for (;;) {
  }
}

}  // namespace thimble::test
