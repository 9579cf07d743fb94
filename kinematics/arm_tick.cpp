// What every tick asks of an arm. The two-link's closed form is here, optimised for speed; the families that take the general way call arm.cpp.
#include "kinematics/arm.h"
#include "kinematics/dynamics.h"
#include "kinematics/workspace.h"

namespace thimble::kinematics {

template <typename S>
void Arm<S>::move_to(const PerAxis<S>& axes, Posture<S>& posture) const noexcept {
  if (is_two_link_) {
    two_link_.at(axes, posture);
  } else {
    move_mechanism(axes, posture);
  }
}

template <typename S>
PerAxis<S> Arm<S>::gravity_torques(const Posture<S>& posture) const noexcept {
  if (!is_two_link_) return posture.weight_N_m;
  PerAxis<S> torque;
  torque.template tail<kMaxJoints - 3>().setZero();
  torque.template head<3>() =
      is_level_ ? kinematics::gravity_torques<S>(data_->inertia, posture) : tilted_weight(posture);
  return torque;
}

template <typename S>
int Arm<S>::limit(const PerAxis<S>& axes, S margin) const noexcept {
  return workspace_limit(*data_, axes, margin, axes_);
}

template void Arm<float>::move_to(const PerAxis<float>&, Posture<float>&) const noexcept;
template void Arm<double>::move_to(const PerAxis<double>&, Posture<double>&) const noexcept;
template PerAxis<float> Arm<float>::gravity_torques(const Posture<float>&) const noexcept;
template PerAxis<double> Arm<double>::gravity_torques(const Posture<double>&) const noexcept;
template int Arm<float>::limit(const PerAxis<float>&, float) const noexcept;
template int Arm<double>::limit(const PerAxis<double>&, double) const noexcept;

}  // namespace thimble::kinematics
