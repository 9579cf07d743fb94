#include "board/files/rotation.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace thimble::board {
namespace {

Eigen::Matrix3d turned(double degrees, int axis) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const double quarters = degrees / 90, whole = std::round(quarters);
  const bool exact = quarters == whole;
  const int which = static_cast<int>(std::fmod(whole, 4) + 4) % 4;
  constexpr std::array<double, 4> kCosine{1, 0, -1, 0};
  const double c = exact ? kCosine.at(static_cast<std::size_t>(which)) : std::cos(degrees * kDegree);
  const double s =
      exact ? kCosine.at(static_cast<std::size_t>((which + 3) % 4)) : std::sin(degrees * kDegree);
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  R(a, a) = R(b, b) = c;
  R(a, b) = -s;
  R(b, a) = s;
  return R;
}

}  // namespace

Eigen::Matrix3d rotation_of(const Eigen::Vector3d& rpy_deg) {
  return turned(rpy_deg.z(), 2) * turned(rpy_deg.y(), 1) * turned(rpy_deg.x(), 0);
}

}  // namespace thimble::board
