// Near a singularity a force is taken back along the direction that is lost. A Jacobian J of the driven axes gives torques J^T F for any force, and two
// things go wrong: where the tip cannot move along a direction, its force costs no torque and is not felt; where the tip moves without the
// axes (closed mechanisms), a small force costs any torque. Both are told by the singular values of J, beside those at home.
//
// Along a direction with less than kLost of the least singular value at home the force falls linearly to 0 with that value; along one with more than
// kLoose times the greatest it falls inversely. A direction that has no force at home either (the third axis of a five-bar) is left alone: J^T does
// not see it.
#pragma once

#include <Eigen/Core>

#include "kinematics/geometry.h"

namespace thimble::kinematics {

class ForceFade {
 public:
  static constexpr float kLost = 0.05F;
  static constexpr float kLoose = 20.0F;

  // home: the Jacobian of the force point by the axes at home; the columns of axes without a motor are 0.
  explicit ForceFade(const Jacobian3<float>& home) noexcept;

  // The force that is safe to render with this Jacobian, and whether that is less than all of it. Bounded; a Jacobian or a force with NaN gives NaN.
  struct Faded {
    Eigen::Vector3f force_N;
    bool faded;
  };
  [[nodiscard]] Faded of(const Jacobian3<float>& jacobian, const Eigen::Vector3f& force_N) const noexcept;

  [[nodiscard]] int force_dof() const noexcept { return dof_; }

 private:
  int dof_ = 0;
  float least_ = 0, most_ = 0;  // limits of singular values, m
};

}  // namespace thimble::kinematics
