#include "kinematics/force_fade.h"

#include <Eigen/LU>

#include "kinematics/directions.h"

namespace thimble::kinematics {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr float kNoForce = 1e-3F;  // of the greatest singular value

}  // namespace

ForceFade::ForceFade(const Jacobian3<float>& home) noexcept {
  const Directions at_home = directions_of(home);
  while (dof_ < 3 && at_home.value[dof_] > kNoForce * at_home.value[0]) ++dof_;
  if (dof_ == 0) return;
  least_ = kLost * at_home.value[dof_ - 1];
  most_ = kLoose * at_home.value[0];
}

ForceFade::Faded ForceFade::of(const Jacobian3<float>& jacobian, const Vector3f& force_N) const noexcept {
  // Nothing is near: of the squares of three singular values the least is at least 4 det / trace^2, and none is more than the trace.
  const Matrix3f squares = jacobian * jacobian.transpose();
  const float trace = squares.trace();
  if (dof_ == 3 && 4.0F * squares.determinant() > least_ * least_ * trace * trace && trace < most_ * most_)
    return {force_N, false};
  const Directions now = directions_of(jacobian);
  Faded result{force_N, false};
  for (int i = 0; i < dof_; ++i) {
    const float value = now.value[i];
    if (value >= least_ && value <= most_) continue;
    const float part = value > most_ ? most_ / value : value / least_;  // NaN for NaN
    const Vector3f along = now.along.col(i);
    result.force_N -= (1.0F - part) * force_N.dot(along) * along;
    result.faded = true;
  }
  return result;
}

}  // namespace thimble::kinematics
