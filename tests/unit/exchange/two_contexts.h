// Runs two step functions as the two contexts of a controller: on two threads, or with one of them as an interrupt of the other after
// every single instruction. A step returns true when its context has finished. Steps of one context never overlap.
#pragma once

#include <csignal>
#include <cstdint>
#include <thread>
#include <type_traits>

#if defined(__SANITIZE_THREAD__)
#define THIMBLE_TSAN 1
#elif defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define THIMBLE_TSAN 1
#endif
#endif
#ifndef THIMBLE_TSAN
#define THIMBLE_TSAN 0
#endif

// The trap flag of x86 raises SIGTRAP after each instruction. ThreadSanitizer delivers signals late, at calls of its own.
#if defined(__x86_64__) && !THIMBLE_TSAN
#define THIMBLE_SINGLE_STEP 1
#include <ucontext.h>
#else
#define THIMBLE_SINGLE_STEP 0
#endif

namespace thimble::test {

template <class A, class B>
void on_two_threads(A&& a, B&& b) {
  const auto run = [](auto& step) {
    for (std::uint32_t i = 1; !step(); ++i)
      if (i % 64 == 0) std::this_thread::yield();  // on one core the other context needs a turn
  };
  std::thread other([&] { run(b); });
  run(a);
  other.join();
}

#if THIMBLE_SINGLE_STEP
namespace single_step {

inline constexpr greg_t kTrapFlag = 0x100;
inline void (*interrupt)(void*) = nullptr;
inline void* interrupt_state = nullptr;
inline volatile std::sig_atomic_t on = 0;
inline std::uint64_t interrupts = 0;

inline void handler(int, siginfo_t*, void* context) {
  auto& flags = static_cast<ucontext_t*>(context)->uc_mcontext.gregs[REG_EFL];
  if (on == 0) {
    flags &= ~kTrapFlag;
    return;
  }
  flags |= kTrapFlag;
  ++interrupts;
  interrupt(interrupt_state);
}

}  // namespace single_step

// `main` runs to its end, or for `most` steps; `other` gets one step after each of its instructions. Returns the number of interrupts.
template <class Main, class Other>
std::uint64_t interrupted_everywhere(Main&& main, Other&& other, int most) {
  struct sigaction action {};
  struct sigaction before {};
  action.sa_sigaction = single_step::handler;
  action.sa_flags = SA_SIGINFO;
  (void)sigaction(SIGTRAP, &action, &before);
  using Step = std::remove_reference_t<Other>;
  single_step::interrupt = [](void* state) { (void)(*static_cast<Step*>(state))(); };
  single_step::interrupt_state = &other;
  single_step::interrupts = 0;
  single_step::on = 1;
  (void)raise(SIGTRAP);  // its handler sets the trap flag
  for (int i = 0; i < most; ++i)
    if (main()) break;
  single_step::on = 0;  // the next trap clears the flag
  (void)sigaction(SIGTRAP, &before, nullptr);
  return single_step::interrupts;
}
#endif

}  // namespace thimble::test
