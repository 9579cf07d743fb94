#include <chrono>

#include "host-tools/client/transport.h"

namespace thimble::host {
namespace {

MicrosClock other_clock = nullptr;

}  // namespace

void use_clock(MicrosClock clock) { other_clock = clock; }

link::Micros now_us() {
  if (other_clock != nullptr) return other_clock();
  return static_cast<link::Micros>(std::chrono::duration_cast<std::chrono::microseconds>(
                                       std::chrono::steady_clock::now().time_since_epoch())
                                       .count());
}

}  // namespace thimble::host
