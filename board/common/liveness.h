// Detects a context that hangs. Each context calls beat() in every cycle. The context that feeds the watchdog
// calls alive() first, so the watchdog expires when any context hangs, not only the feeding one.
//
//   servo        liveness.beat(kTick);                           // at the end of a tick whose outputs have been written
//   background   liveness.beat(kLink); liveness.beat(kBackground);
//   the feeder   if (liveness.alive(now_us)) watchdog.feed();    // one context, at least twice per limit
//
// No heap, no lock, no OS. A context that beats again counts as alive again; the watchdog decides by its own
// time whether it was absent for too long.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace thimble::board {

template <std::size_t kContexts>
class Liveness {
 public:
  // limit_us: for each context the longest time between two beats. Measurement starts with the first alive().
  explicit constexpr Liveness(const std::array<std::uint32_t, kContexts>& limit_us) noexcept {
    for (std::size_t i = 0; i < kContexts; ++i) contexts_[i].limit_us = limit_us[i];
  }

  // Each context calls it from one thread or interrupt level only.
  void beat(std::size_t context) noexcept {
    std::atomic<std::uint32_t>& count = contexts_[context].count;
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  // Only from the feeding context; now_us must be monotonic.
  [[nodiscard]] bool alive(std::uint64_t now_us) noexcept {
    bool all = true;
    for (Context& context : contexts_) {
      const std::uint32_t count = context.count.load(std::memory_order_acquire);
      if (!started_ || count != context.seen) {
        context.seen = count;
        context.since_us = now_us;
      }
      all = all && now_us - context.since_us <= context.limit_us;
    }
    started_ = true;
    return all;
  }

  // The contexts that exceed their limit at now_us, by the beats that the last alive() saw; bit i is context
  // i.
  [[nodiscard]] std::uint32_t hanging(std::uint64_t now_us) const noexcept {
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < kContexts; ++i)
      if (now_us - contexts_[i].since_us > contexts_[i].limit_us) bits |= 1U << i;
    return bits;
  }

 private:
  static_assert(kContexts <= 32, "hanging() has 32 bits");
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
  struct Context {
    std::atomic<std::uint32_t> count{0};
    std::uint32_t limit_us = 0;
    std::uint32_t seen = 0;
    std::uint64_t since_us = 0;
  };
  std::array<Context, kContexts> contexts_{};
  bool started_ = false;
};

}  // namespace thimble::board
