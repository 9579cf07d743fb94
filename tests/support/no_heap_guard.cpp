#include "tests/support/no_heap_guard.h"

#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <new>

#include "tests/support/sanitizers.h"

namespace {

thread_local int guards = 0;

void check() noexcept {
  if (guards == 0) return;
  guards = 0;  // abort's own machinery may allocate
  static constexpr char kMessage[] = "no_heap_guard: the heap was used under the guard\n";
  (void)!write(STDERR_FILENO, kMessage, sizeof(kMessage) - 1);
  std::abort();
}

void* allocate(std::size_t bytes) {
  check();
  if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}

void* allocate(std::size_t bytes, std::align_val_t alignment) {
  check();
  const auto align = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(align, (bytes + align - 1) / align * align)) return memory;
  throw std::bad_alloc();
}

void release(void* memory) noexcept {
  check();
  std::free(memory);
}

}  // namespace

namespace thimble::test {

NoHeapGuard::NoHeapGuard() noexcept { ++guards; }
NoHeapGuard::~NoHeapGuard() { --guards; }

}  // namespace thimble::test

// The other forms of new and delete call these.
void* operator new(std::size_t bytes) { return allocate(bytes); }
void* operator new[](std::size_t bytes) { return allocate(bytes); }
void* operator new(std::size_t bytes, std::align_val_t alignment) { return allocate(bytes, alignment); }
void* operator new[](std::size_t bytes, std::align_val_t alignment) { return allocate(bytes, alignment); }
void operator delete(void* memory) noexcept { release(memory); }
void operator delete[](void* memory) noexcept { release(memory); }
void operator delete(void* memory, std::size_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t) noexcept { release(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::align_val_t) noexcept { release(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }
void operator delete[](void* memory, std::size_t, std::align_val_t) noexcept { release(memory); }

#if defined(__GLIBC__) && !THIMBLE_UNDER_SANITIZERS && !defined(__SANITIZE_THREAD__)
// The executable's malloc stands before the C library's.
extern "C" {
// The C library's own names. NOLINTBEGIN(bugprone-reserved-identifier)
void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void __libc_free(void* memory);
// NOLINTEND(bugprone-reserved-identifier)

void* malloc(std::size_t bytes) noexcept {
  check();
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  check();
  return __libc_calloc(count, bytes);
}
void* realloc(void* memory, std::size_t bytes) noexcept {
  check();
  return __libc_realloc(memory, bytes);
}
void free(void* memory) noexcept {
  if (memory != nullptr) check();
  __libc_free(memory);
}
}
#endif
