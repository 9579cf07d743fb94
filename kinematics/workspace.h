// The limits of an arm's axes, and of sums of them (the elbow of a parallelogram).
#pragma once

#include <cstddef>

#include "kinematics/arm_data.h"

namespace thimble::kinematics {

// The first limit that these axes are beyond: 0 for none, n + 1 for axis n, kMaxJoints + n + 1 for sum n. margin > 0 narrows every limit, rad or
// m. NaN is beyond a limit. axes: a vector of at least `count`, which is how many the arm has.
template <typename Axes>
[[nodiscard]] constexpr int workspace_limit(const ArmData& arm, const Axes& axes,
                                            typename Axes::Scalar margin, int count) noexcept {
  using S = typename Axes::Scalar;
  for (int j = 0; j < count; ++j) {
    const AxisData& axis = arm.axis[static_cast<std::size_t>(j)];
    if (!(axes[j] >= S(axis.lower) + margin && axes[j] <= S(axis.upper) - margin)) return j + 1;
  }
  for (int i = 0; i < arm.sum_count; ++i) {
    const LimitSum& limit = arm.sum[static_cast<std::size_t>(i)];
    S sum = 0;
    for (int j = 0; j < count; ++j) sum += S(limit.weight[static_cast<std::size_t>(j)]) * axes[j];
    if (!(sum >= S(limit.lower) + margin && sum <= S(limit.upper) - margin)) return kMaxJoints + i + 1;
  }
  return 0;
}

template <typename Axes>
[[nodiscard]] constexpr int workspace_limit(const ArmData& arm, const Axes& axes,
                                            typename Axes::Scalar margin = 0) noexcept {
  return workspace_limit(arm, axes, margin, axes_of(arm.geometry));
}

}  // namespace thimble::kinematics
