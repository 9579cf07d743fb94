// What the families of platforms have in common: where the plate is, in the base frame, and how it moves with the joints.
#pragma once

#include <Eigen/Core>

namespace thimble::kinematics {

template <typename S, int kJoints>
struct Plate {
  Eigen::Matrix<S, 3, 1> position_m;
  Eigen::Matrix<S, 3, kJoints> jacobian;  // d position_m / d joints
};

}  // namespace thimble::kinematics
