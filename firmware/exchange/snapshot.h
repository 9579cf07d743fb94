// The newest value of a small object. The writer replaces it whenever it likes, also one that nobody has read; the reader gets it whole
// or, while it is being replaced, not at all. Used for the force commands of a host.
//
//   writer  write(value)
//   reader  read(value): true: a value that was written after the last one read; false: none, or it is changing; try in the next tick
//           skip(): what has been written until now does not count
//
// Memory order: a sequence lock with one attempt. version_ is odd while the words change.
//   write() stores version + 1 (odd), then each word with release, then version + 2 with release.
//   read() loads the version with acquire, then each word with acquire, then the version again.
// An even version that is acquired gives the words of that write or of later ones. If a word is of a later write, its acquire load
// pairs with its release store, and the odd version before that store is visible too: the second load of the version gives at least
// that, so it differs from the first, and the value is refused. All words then belong to one write. The words are atomic, so a word
// that is read while it is written is no data race. What the writer wrote before write() is visible to a reader that gets the value.
// On one core: a reader that interrupts a write finds an odd version, or words that it refuses; a writer that interrupts a read
// changes the version. Neither loops. The version wraps after 2^31 writes, which cannot happen within one read.
#pragma once

#include <array>
#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace thimble::firmware {

template <class T>
class Snapshot {
  static_assert(std::is_trivially_copyable_v<T>);
  static_assert(sizeof(T) % sizeof(std::uint32_t) == 0, "of whole words");

 public:
  // --- writer
  void write(const T& value) noexcept {
    const auto words = std::bit_cast<Words>(value);
    const std::uint32_t version = version_.load(std::memory_order_relaxed);
    version_.store(version + 1, std::memory_order_relaxed);
    for (std::size_t i = 0; i < kWords; ++i) words_[i].store(words[i], std::memory_order_release);
    version_.store(version + 2, std::memory_order_release);
  }

  // --- reader
  [[nodiscard]] bool written() const noexcept { return version_.load(std::memory_order_acquire) != seen_; }
  [[nodiscard]] bool read(T& value) noexcept {
    const std::uint32_t version = version_.load(std::memory_order_acquire);
    if (version == seen_ || version % 2 != 0) return false;
    Words words;
    for (std::size_t i = 0; i < kWords; ++i) words[i] = words_[i].load(std::memory_order_acquire);
    if (version_.load(std::memory_order_relaxed) != version) return false;
    seen_ = version;
    value = std::bit_cast<T>(words);
    return true;
  }
  void skip() noexcept { seen_ = version_.load(std::memory_order_acquire); }

 private:
  static constexpr std::size_t kWords = sizeof(T) / sizeof(std::uint32_t);
  using Words = std::array<std::uint32_t, kWords>;

  std::array<std::atomic<std::uint32_t>, kWords> words_{};
  std::atomic<std::uint32_t> version_{0};
  std::uint32_t seen_ = 0;  // the reader's
};

}  // namespace thimble::firmware
