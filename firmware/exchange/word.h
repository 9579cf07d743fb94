// One machine word that one context writes and the other reads: Value, Signal and Counter. These are the smallest types of
// firmware/exchange/; the rules below hold for all its types.
//
// Two contexts, and no more (firmware/controller.h): the tick and the background. On a microcontroller they share one core, and the
// tick is an interrupt of the background; on embedded Linux they are two threads on two cores; some boards run the tick from a pause
// of the background. So each type must hold for both cases:
//   two cores      needs an order in hardware: a store with release, paired with a load with acquire.
//   one interrupt  needs only an order in the compiler's output, and release and acquire give that too. The interrupted context
//                  stands still between two of its instructions, so the other one may never wait for it: no lock, no retry loop
//                  without a bound.
// Every object has one writer context and one reader context. All words are at most 32 bits and lock-free.
//
//   type      carries                                               use it for
//   Value     itself, nothing else (relaxed)                        a parameter, a figure
//   Signal    itself, and all that its writer wrote before          a mode, a phase
//   Counter   a number that only rises (relaxed)                    how often something happened
//   Request   a command; the newest one wins; it is acknowledged    commands to the tick            (request.h)
//   Mailbox   one object, one at a time; the writer waits           a scene, a picture              (mailbox.h)
//   Snapshot  the newest object; neither side waits                 a force command                 (snapshot.h)
//   Ring      objects in order; a full ring refuses the newest      telemetry, recordings           (ring.h)
#pragma once

#include <atomic>
#include <cstdint>
#include <type_traits>

namespace thimble::firmware {

template <class T>
concept ExchangeWord = std::is_trivially_copyable_v<T> && sizeof(T) <= sizeof(std::uint32_t) &&
                       std::atomic<T>::is_always_lock_free;

// A word that stands for itself.
// Order: relaxed. A load gives some value that was stored, whole, and never an older one than the same reader saw before. It says
// nothing about any other object; if a reader concludes from the value that other data is ready, a Signal is needed.
template <ExchangeWord T>
class Value {
 public:
  constexpr Value() noexcept : word_(T{}) {}
  constexpr explicit Value(T initial) noexcept : word_(initial) {}

  void set(T value) noexcept { word_.store(value, std::memory_order_relaxed); }  // writer
  [[nodiscard]] T get() const noexcept { return word_.load(std::memory_order_relaxed); }

 private:
  std::atomic<T> word_;
};

// A word that also announces what its writer wrote before it.
// Order: set() releases, get() acquires. A reader that gets the value of a set() also sees every store that precedes that set() in its
// writer. Nothing keeps the writer from writing again: data that is announced must be left alone, or be exchange types itself.
template <ExchangeWord T>
class Signal {
 public:
  constexpr Signal() noexcept : word_(T{}) {}
  constexpr explicit Signal(T initial) noexcept : word_(initial) {}

  void set(T value) noexcept { word_.store(value, std::memory_order_release); }  // writer
  [[nodiscard]] T get() const noexcept { return word_.load(std::memory_order_acquire); }

 private:
  std::atomic<T> word_;
};

// A count of events. One writer, so load and store need not be one instruction. It wraps; a reader compares for inequality, or subtracts.
// Order: relaxed, as Value. An event whose data matters travels in a Ring or a Mailbox.
class Counter {
 public:
  void add(std::uint32_t events = 1) noexcept {  // writer
    count_.store(count_.load(std::memory_order_relaxed) + events, std::memory_order_relaxed);
  }
  void clear() noexcept { count_.store(0, std::memory_order_relaxed); }  // writer
  [[nodiscard]] std::uint32_t get() const noexcept { return count_.load(std::memory_order_relaxed); }

 private:
  std::atomic<std::uint32_t> count_{0};
};

}  // namespace thimble::firmware
