// While a NoHeapGuard exists, every allocation or release on its thread prints a line and aborts the program.
// For tests and benchmarks that require "no heap in the tick":
//
//   { NoHeapGuard guard; out = controller.tick(in); }
//
// Link thimble_no_heap_guard. It replaces operator new and delete of the whole program and, without
// sanitizers, malloc and related functions.
#pragma once

namespace thimble::test {

class NoHeapGuard {
 public:
  NoHeapGuard() noexcept;
  ~NoHeapGuard();
  NoHeapGuard(const NoHeapGuard&) = delete;
  NoHeapGuard& operator=(const NoHeapGuard&) = delete;
};

}  // namespace thimble::test
