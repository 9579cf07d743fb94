// What the page wants of every tick of the simulated board, not of every telemetry record: the forces, which its sound plays, and the longest tick.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "board/sim/sim_board.h"

namespace thimble::host {

class TickLog {
 public:
  // The forces are kept while somebody listens.
  void listen(bool yes) {
    listens_ = yes;
    forces_N_.clear();
  }

  void take(const firmware::Telemetry& tick) {
    worst_us_ = std::max(worst_us_, tick.tick_us);
    if (!listens_) return;
    if (forces_N_.size() >= kMostNumbers) forces_N_.clear();  // nobody has fetched them for too long
    for (std::size_t arm = 0; arm < tick.arm_count; ++arm)
      for (int axis = 0; axis < 3; ++axis) forces_N_.push_back(tick.arm[arm].force_N[axis]);
  }

  // x, y, z of each arm of each tick since the last call, on the hand. The bytes are valid until the next one.
  [[nodiscard]] std::string_view forces() {
    given_.clear();
    std::swap(given_, forces_N_);
    return {reinterpret_cast<const char*>(given_.data()), given_.size() * sizeof(float)};
  }
  // Since the last call.
  [[nodiscard]] float worst_us() { return std::exchange(worst_us_, 0.0F); }

 private:
  static constexpr std::size_t kMostNumbers = std::size_t{3} * 8192;

  bool listens_ = false;
  float worst_us_ = 0;
  std::vector<float> forces_N_, given_;
};

}  // namespace thimble::host
