// A serial chain of up to kMaxJoints joints, by origin and axis of each joint as URDF has them:
//
//   T = prod Trans(origin_k) R(rotation_k) Rot(axis_k, q_k), or Trans(axis_k q_k) for a prismatic joint
//   columns of the Jacobian: revolute [axis x (p - origin); axis], prismatic [axis; 0], all in the frame in which the chain begins
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "kinematics/geometry.h"
#include "kinematics/trig.h"

namespace thimble::kinematics {

// Rotation about an axis of length 1 (Rodrigues).
template <typename S>
[[nodiscard]] Eigen::Matrix<S, 3, 3> rotation_about(const Eigen::Matrix<S, 3, 1>& axis,
                                                    const SinCos<S>& turn) noexcept {
  Eigen::Matrix<S, 3, 3> R = (S(1) - turn.cos) * axis * axis.transpose();
  R.diagonal().array() += turn.cos;
  const Eigen::Matrix<S, 3, 1> s = turn.sin * axis;
  R(0, 1) -= s.z();
  R(1, 0) += s.z();
  R(0, 2) += s.y();
  R(2, 0) -= s.y();
  R(1, 2) -= s.x();
  R(2, 1) += s.x();
  return R;
}

// Where the joints and links of a chain are, in the frame in which it begins.
template <typename S>
struct ChainPose {
  using Vector3 = Eigen::Matrix<S, 3, 1>;
  std::array<Vector3, kMaxJoints> origin_m;             // of the joints
  std::array<Vector3, kMaxJoints> axis;                 // of length 1
  std::array<Eigen::Matrix<S, 3, 3>, kMaxJoints> link;  // orientation of the link behind each joint
  std::array<Vector3, kMaxJoints> link_m;  // and its frame's origin, which a prismatic joint moves
  Vector3 tip_m;
  Eigen::Matrix<S, 3, 3> rotation;  // of the last link
};

// q: a vector of chain.count joints. NaN where an angle is not finite or beyond kMaxAngle.
template <typename S, typename Joints>
void chain_pose(const ChainGeometry& chain, const Joints& q, ChainPose<S>& pose) noexcept {
  using Vector3 = Eigen::Matrix<S, 3, 1>;
  Vector3 p = Vector3::Zero();
  Eigen::Matrix<S, 3, 3> R = Eigen::Matrix<S, 3, 3>::Identity();
  for (int k = 0; k < chain.count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    const ChainJoint& joint = chain.joint[at];
    p += R * joint.origin_m.template cast<S>();
    R = (R * joint.rotation.template cast<S>()).eval();
    // As long as 1 to all bits of S, as peers have it.
    Vector3 axis = joint.axis.template cast<S>();
    if constexpr (sizeof(S) > sizeof(float)) axis.normalize();
    pose.origin_m[at] = p;
    pose.axis[at] = R * axis;
    if (joint.kind == JointKind::kRevolute) {
      R = (R * rotation_about<S>(axis, sin_cos(S(q[k])))).eval();
    } else {
      p += S(q[k]) * pose.axis[at];
    }
    pose.link[at] = R;
    pose.link_m[at] = p;
  }
  pose.tip_m = p + R * chain.tip_m.template cast<S>();
  pose.rotation = R;
}

// The velocity of a point that moves with the link behind joint `last - 1`, by the speed of joint k of the chain; 0 for k >= last.
template <typename S>
[[nodiscard]] Eigen::Matrix<S, 3, 1> velocity_by_joint(const ChainGeometry& chain, const ChainPose<S>& pose,
                                                       int k, int last,
                                                       const Eigen::Matrix<S, 3, 1>& point_m) noexcept {
  const auto at = static_cast<std::size_t>(k);
  if (k >= last) return Eigen::Matrix<S, 3, 1>::Zero();
  if (chain.joint[at].kind == JointKind::kPrismatic) return pose.axis[at];
  return pose.axis[at].cross(point_m - pose.origin_m[at]);
}

}  // namespace thimble::kinematics
