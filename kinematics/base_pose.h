// The mounting of an arm, and vectors of the kinematics.
//
// World frame: +x to the user's right, +y away from the user, +z up. The base of the arm is behind the workspace, and the arm points towards the
// user. Units: m.
#pragma once

#include <Eigen/Core>

namespace thimble::kinematics {

template <typename S>
using Vector3 = Eigen::Matrix<S, 3, 1>;
template <typename S>
using Matrix3 = Eigen::Matrix<S, 3, 3>;

// The world position of the tip at home, and the rotation of the base from how the arm's geometry has it.
struct BasePose {
  Vector3<float> home_m = Vector3<float>::Zero();
  Matrix3<float> rotation = Matrix3<float>::Identity();
};

}  // namespace thimble::kinematics
