// Proof that every part of a controller makes progress: what a watchdog may be fed on. Each context counts its rounds with
// beat(); the one that feeds asks alive() first, so a watchdog bites when any of them hangs, not only the one that feeds.
//
//   servo        liveness.beat(kTick);                           // at the end of a tick whose outputs have been written
//   background   liveness.beat(kLink); liveness.beat(kBackground);
//   the feeder   if (liveness.alive(now_us)) watchdog.feed();    // one context, at least twice per limit
//
// No heap, no lock, no OS. A context that beats again counts as alive again: whether it was away for too long is the
// watchdog's to say, by its own time.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace thimble::board {

template <std::size_t kContexts>
class Liveness {
 public:
  // limit_us: for each context, how long it may take from one beat to the next. The time starts with the first alive().
  explicit constexpr Liveness(const std::array<std::uint32_t, kContexts>& limit_us) noexcept {
    for (std::size_t i = 0; i < kContexts; ++i) contexts_[i].limit_us = limit_us[i];
  }

  // Each context's beat comes from one thread or interrupt level only.
  void beat(std::size_t context) noexcept {
    std::atomic<std::uint32_t>& count = contexts_[context].count;
    count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_release);
  }

  // The feeder's context only; now_us never runs backwards.
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

  // Which contexts were over their limit at the last alive(), as bits.
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
