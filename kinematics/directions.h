// The directions in which an arm can push, by its Jacobian J (3 x axes): J = sum value_i along_i by_axes_i^T / value_i, a singular value decomposition
// with the rows scaled. Bounded, in the tick for arms other than the two-link.
#pragma once

#include <Eigen/Core>

#include "kinematics/geometry.h"

namespace thimble::kinematics {

// A force or a motion is told in directions with at least this lever.
inline constexpr float kLeastLever_m = 1e-3F;

struct Directions {
  Eigen::Vector3f value;     // singular values, descending; m
  Eigen::Matrix3f along;     // columns: where the force point moves, orthonormal
  Jacobian3<float> by_axes;  // rows, square to each other: along^T J, of length value

  // The force whose torques J^T F are nearest to these, of directions with at least this singular value.
  [[nodiscard]] Eigen::Vector3f force_of(const PerAxis<float>& torques, float least) const noexcept;
  // The least speeds of the axes that give the force point this velocity, as far as those directions allow it.
  [[nodiscard]] PerAxis<float> speeds_for(const Eigen::Vector3f& velocity, float least) const noexcept;
};

// NaN gives NaN.
[[nodiscard]] Directions directions_of(const Jacobian3<float>& jacobian) noexcept;

}  // namespace thimble::kinematics
