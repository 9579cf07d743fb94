#include "kinematics/force_fade.h"

#include <algorithm>
#include <cmath>

namespace thimble::kinematics {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr int kSweeps = 5;         // of Jacobi's method: quadratic, and three rows need 3 or 4 in float
constexpr float kNoForce = 1e-3F;  // of the greatest singular value

struct Directions {
  Vector3f value;  // singular values, descending
  Matrix3f along;  // columns, where the force point moves
};

// Turns the rows p and q of a, and the columns of `along`, so that the rows are square to each other.
void rotate(Jacobian3<float>& a, Matrix3f& along, int p, int q) noexcept {
  const float dot = a.row(p).dot(a.row(q));
  if (dot == 0.0F) return;
  const float theta = (a.row(q).squaredNorm() - a.row(p).squaredNorm()) / (2.0F * dot);
  const float t = (theta >= 0 ? 1.0F : -1.0F) / (std::abs(theta) + std::sqrt(theta * theta + 1.0F));
  const float c = 1.0F / std::sqrt(t * t + 1.0F), s = t * c;
  for (int j = 0; j < a.cols(); ++j) {
    const float ap = a(p, j), aq = a(q, j);
    a(p, j) = c * ap - s * aq;
    a(q, j) = s * ap + c * aq;
  }
  for (int i = 0; i < 3; ++i) {
    const float vp = along(i, p), vq = along(i, q);
    along(i, p) = c * vp - s * vq;
    along(i, q) = s * vp + c * vq;
  }
}

// By one-sided Jacobi rotations: small values keep their digits, which the square of the matrix would lose.
Directions directions_of(const Jacobian3<float>& jacobian) noexcept {
  Jacobian3<float> a = jacobian;
  Directions found{Vector3f::Zero(), Matrix3f::Identity()};
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    rotate(a, found.along, 0, 1);
    rotate(a, found.along, 0, 2);
    rotate(a, found.along, 1, 2);
  }
  for (int i = 0; i < 3; ++i) found.value[i] = a.row(i).norm();
  const auto order = [&found](int i, int j) {
    if (found.value[i] >= found.value[j]) return;
    std::swap(found.value[i], found.value[j]);
    found.along.col(i).swap(found.along.col(j));
  };
  order(0, 1);
  order(0, 2);
  order(1, 2);
  return found;
}

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
