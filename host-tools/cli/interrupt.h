// Ctrl-C and SIGTERM end a long verb after its current loop iteration, so that it can clean up.
#pragma once

#include <csignal>

namespace thimble::host {

inline volatile std::sig_atomic_t interrupted = 0;

inline void heed_interrupts() {
  const auto stop = [](int) { interrupted = 1; };
  std::signal(SIGINT, stop);
  std::signal(SIGTERM, stop);
}

// And what comes after its last round is ended at once again.
inline void heed_interrupts_no_more() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

}  // namespace thimble::host
