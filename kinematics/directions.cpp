#include "kinematics/directions.h"

#include <cmath>
#include <utility>

namespace thimble::kinematics {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr int kSweeps = 5;  // of Jacobi's method: quadratic, and three rows need 3 or 4 in float

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

}  // namespace

// By one-sided Jacobi rotations: small values keep their digits, which the square of the matrix would lose.
Directions directions_of(const Jacobian3<float>& jacobian) noexcept {
  Directions found{Vector3f::Zero(), Matrix3f::Identity(), jacobian};
  Jacobian3<float>& a = found.by_axes;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    rotate(a, found.along, 0, 1);
    rotate(a, found.along, 0, 2);
    rotate(a, found.along, 1, 2);
  }
  for (int i = 0; i < 3; ++i) found.value[i] = a.row(i).norm();
  const auto order = [&found, &a](int i, int j) {
    if (found.value[i] >= found.value[j]) return;
    std::swap(found.value[i], found.value[j]);
    a.row(i).swap(a.row(j));
    found.along.col(i).swap(found.along.col(j));
  };
  order(0, 1);
  order(0, 2);
  order(1, 2);
  return found;
}

Vector3f Directions::force_of(const PerAxis<float>& torques, float least) const noexcept {
  Vector3f force = Vector3f::Zero();
  for (int i = 0; i < 3 && value[i] >= least; ++i)
    force += by_axes.row(i).dot(torques.head(by_axes.cols())) / (value[i] * value[i]) * along.col(i);
  return force;
}

PerAxis<float> Directions::speeds_for(const Vector3f& velocity, float least) const noexcept {
  PerAxis<float> speeds = PerAxis<float>::Zero();
  for (int i = 0; i < 3 && value[i] >= least; ++i)
    speeds.head(by_axes.cols()) +=
        along.col(i).dot(velocity) / (value[i] * value[i]) * by_axes.row(i).transpose();
  return speeds;
}

}  // namespace thimble::kinematics
