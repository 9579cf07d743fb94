// How late the ticks began, as a histogram since start. The board measures (Inputs::late_us), the tick counts, the background reads.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "firmware/exchange/word.h"

namespace thimble::firmware {

inline constexpr std::array<float, 12> kLateBounds_us = {1,   2,   5,   10,   20,   50,
                                                         100, 200, 500, 1000, 2000, 5000};

class LateTicks {
 public:
  // --- tick
  void add(float late_us) noexcept {
    const auto bound = std::upper_bound(kLateBounds_us.begin(), kLateBounds_us.end(), late_us);
    ticks_[static_cast<std::size_t>(bound - kLateBounds_us.begin())].add();
    if (late_us > worst_us_.get()) worst_us_.set(late_us);
  }

  // --- background
  // [i]: ticks later than bound i - 1 and below bound i of kLateBounds_us; the last one: all the others.
  [[nodiscard]] std::uint32_t ticks(std::size_t index) const noexcept { return ticks_[index].get(); }
  [[nodiscard]] float worst_us() const noexcept { return worst_us_.get(); }

 private:
  std::array<Counter, kLateBounds_us.size() + 1> ticks_;
  Value<float> worst_us_;
};

}  // namespace thimble::firmware
