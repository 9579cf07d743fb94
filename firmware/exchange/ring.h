// Objects on their way from one context to the other, in order. A full ring refuses the newest object: the writer never waits, and
// counts what it had to drop. Used for telemetry records and for the ticks of a recording.
//
//   writer  blank(): the place of the next object, null when the ring is full; push() what was filled in there
//   reader  front(): the oldest object, null when the ring is empty; pop(); or pop(object): both at once
//
// Memory order. head_ counts the objects that were pushed, tail_ those that were popped; the difference is what the ring holds, and the
// counts may wrap because the capacity is a power of two. head_ is the writer's, tail_ the reader's.
//   push() releases head_, front() acquires it: the reader sees the object whole.
//   pop() releases tail_, blank() acquires it: the writer uses a place again only after the reader's last load from it.
// Each side reads its own count relaxed, as nobody else writes it. The other side's count may be old; then the ring looks fuller to the
// writer, or emptier to the reader, than it is; both are safe. An interrupt between blank() and push() does not see the new object yet.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace thimble::firmware {

template <class T, std::uint32_t Capacity>
class Ring {
  static_assert(Capacity > 0 && (Capacity & (Capacity - 1)) == 0, "a power of two: the counts wrap");

 public:
  static constexpr std::uint32_t kCapacity = Capacity;

  // --- writer
  [[nodiscard]] T* blank() noexcept {
    const std::uint32_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) == Capacity) return nullptr;
    return &objects_[head % Capacity];
  }
  void push() noexcept { head_.store(head_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }

  // --- reader
  [[nodiscard]] const T* front() const noexcept {
    const std::uint32_t tail = tail_.load(std::memory_order_relaxed);
    if (tail == head_.load(std::memory_order_acquire)) return nullptr;
    return &objects_[tail % Capacity];
  }
  void pop() noexcept { tail_.store(tail_.load(std::memory_order_relaxed) + 1, std::memory_order_release); }
  [[nodiscard]] bool pop(T& object) noexcept {
    const T* oldest = front();
    if (oldest == nullptr) return false;
    object = *oldest;
    pop();
    return true;
  }

 private:
  std::array<T, Capacity> objects_{};
  std::atomic<std::uint32_t> head_{0};
  std::atomic<std::uint32_t> tail_{0};
};

}  // namespace thimble::firmware
