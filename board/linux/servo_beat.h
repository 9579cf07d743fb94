// What the servo and the guardian tell each other, in memory that both processes share: when the servo last
// wrote outputs with a drive on, and whether the guardian has switched the drives off since.
//
//   servo      beat->driving(now_ns);  write; if (beat->cut()) drives off;    every tick with a drive on
//              drives off;             beat->off();                           when the last drive is off
//   guardian   if (now_ns - beat->last_ns() > limit) { beat->cut_drives(); drives off; beat->cut_drives(); }
//
// No lock: a process may be stopped at any instruction.
#pragma once

#include <sys/mman.h>

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <new>
#include <system_error>

namespace thimble::board {

class ServoBeat {
 public:
  struct Unmap {
    void operator()(ServoBeat* beat) const noexcept { munmap(beat, sizeof(ServoBeat)); }
  };
  using Shared = std::unique_ptr<ServoBeat, Unmap>;
  // Before the fork. Throws std::system_error.
  [[nodiscard]] static Shared make() {
    void* memory =
        mmap(nullptr, sizeof(ServoBeat), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (memory == MAP_FAILED) throw std::system_error(errno, std::generic_category(), "shared memory");
    return Shared(new (memory) ServoBeat);
  }

  void driving(std::uint64_t now_ns) noexcept { last_ns_.store(now_ns); }
  void off() noexcept {
    last_ns_.store(0);
    cut_.store(false);
  }
  // The guardian has switched the drives off, and off() was not called since.
  [[nodiscard]] bool cut() const noexcept { return cut_.load(); }

  // 0: every drive is off.
  [[nodiscard]] std::uint64_t last_ns() const noexcept { return last_ns_.load(); }
  void cut_drives() noexcept { cut_.store(true); }

 private:
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
  std::atomic<std::uint64_t> last_ns_{0};
  std::atomic<bool> cut_{false};
};

}  // namespace thimble::board
