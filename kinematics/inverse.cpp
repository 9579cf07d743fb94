// Arm::inverse(), which does not run in the tick.
#include <cmath>

#include "kinematics/arm.h"
#include "kinematics/directions.h"
#include "kinematics/force_fade.h"

namespace thimble::kinematics {
namespace {

constexpr int kInverseSteps = 60;

}  // namespace

template <typename S>
bool Arm<S>::inverse(const Vector3<S>& tip_m, PerAxis<S>& axes) const noexcept {
  if (is_two_link_) {
    Vector3<S> joints;
    if (!two_link_.inverse(tip_m, joints)) return false;
    axes.template head<3>() = joints;
    return true;
  }
  constexpr S kNear_m = S(1e-5), kMostStep_m = S(0.02);
  const Jacobian3<S> at_home = home_posture().jacobian.leftCols(axes_);
  const Directions home_ways = directions_of(at_home.template cast<float>());
  const float least = ForceFade::kLost * home_ways.value[0];
  Matrix3<S> ways = Matrix3<S>::Zero();
  for (int i = 0; i < 3 && home_ways.value[i] > 1e-3F * home_ways.value[0]; ++i)
    ways += (home_ways.along.col(i) * home_ways.along.col(i).transpose()).template cast<S>();
  PerAxis<S> found = home();
  Posture<S> posture = home_posture();
  for (int step = 0; step < kInverseSteps; ++step) {
    Vector3<S> left_m = ways * (tip_m - posture.tip_m);
    const S distance_m = std::sqrt(left_m.squaredNorm());
    if (!(distance_m < S(1e3))) return false;  // NaN: the links do not meet there
    if (distance_m < kNear_m) {
      axes = found;
      return true;
    }
    if (distance_m > kMostStep_m) left_m *= kMostStep_m / distance_m;
    const Jacobian3<S> now = posture.jacobian.leftCols(axes_);
    found += directions_of(now.template cast<float>())
                 .speeds_for(left_m.template cast<float>(), least)
                 .template cast<S>();
    move_to(found, posture);
  }
  return false;
}

template bool Arm<float>::inverse(const Vector3<float>&, PerAxis<float>&) const noexcept;
template bool Arm<double>::inverse(const Vector3<double>&, PerAxis<double>&) const noexcept;

}  // namespace thimble::kinematics
