// Forward kinematics: joint angles to tip position and Jacobian, which also maps a tip force to joint
// torques. One Arm per physical arm; Arm<float> runs in the tick, Arm<double> in the simulated arm and in
// tests.
//
//   const Arm<float> arm(*find_arm_model("premium-1.5"));
//   const Posture<float> posture = arm.at(joints_rad);              // once per tick
//   posture.tip_m;  posture.jacobian * joint_speeds_rad_s;          // position and velocity, world frame
//   posture.jacobian.transpose() * force_N;                         // joint torques, N m
//
// World frame: +x to the user's right, +y away from the user, +z up. The base of the arm is behind the
// workspace, and the arm points towards the user. Home: the tip is at BasePose::home_m. Units: m, rad, N, N
// m. at() cannot fail; an angle that is not finite or beyond kMaxAngle gives NaN. inverse() is for tests and
// for set-up, not for the tick.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>

#include "kinematics/arm_model.h"
#include "kinematics/trig.h"

namespace thimble::kinematics {

template <typename S>
using Vector3 = Eigen::Matrix<S, 3, 1>;
template <typename S>
using Matrix3 = Eigen::Matrix<S, 3, 3>;

// Mounting of an arm: the world position of its tip at home, and the rotation of the base from the default
// orientation (pointing to -y). gravity_torques() is valid only for a rotation about z.
struct BasePose {
  Vector3<float> home_m = Vector3<float>::Zero();
  Matrix3<float> rotation = Matrix3<float>::Identity();
};

template <typename S>
struct Posture {
  SinCos<S> q1, q2, q3;
  Vector3<S> tip_m;     // world frame
  Matrix3<S> jacobian;  // d tip_m / d joints
};

enum class WorkspaceLimit : std::uint8_t { kNone, kJoint1, kJoint2, kJoint3, kElbow };

// The first limit that these joint angles violate; kNone if none. margin_rad > 0 narrows every limit. NaN
// violates a limit.
template <typename S>
[[nodiscard]] constexpr WorkspaceLimit workspace_limit(const ArmModel& model, const Vector3<S>& q,
                                                       S margin_rad = 0) noexcept {
  for (int j = 0; j < 3; ++j) {
    const JointModel& joint = model.joint[static_cast<std::size_t>(j)];
    if (!(q[j] >= S(joint.lower_rad) + margin_rad && q[j] <= S(joint.upper_rad) - margin_rad)) {
      return static_cast<WorkspaceLimit>(j + 1);
    }
  }
  const S elbow = q[1] - q[2];
  if (!(elbow >= S(model.min_elbow_rad) + margin_rad && elbow <= S(model.max_elbow_rad) - margin_rad)) {
    return WorkspaceLimit::kElbow;
  }
  return WorkspaceLimit::kNone;
}

template <typename S>
class Arm {
 public:
  explicit Arm(const ArmModel& model, const BasePose& base = {}) noexcept : model_(&model) {
    // Base x is the direction in which the arm points (-y of the world), base y is the user's right.
    R_WB_ << 0, 1, 0,  //
        -1, 0, 0,      //
        0, 0, 1;
    R_WB_ = (base.rotation.template cast<S>() * R_WB_).eval();
    p_WB_.setZero();
    p_WB_ = base.home_m.template cast<S>() - at(home()).tip_m;
  }

  [[nodiscard]] const ArmModel& model() const noexcept { return *model_; }

  [[nodiscard]] Vector3<S> home() const noexcept {
    return {S(model_->home_rad[0]), S(model_->home_rad[1]), S(model_->home_rad[2])};
  }

  [[nodiscard]] Posture<S> at(const Vector3<S>& q) const noexcept {
    const S l0 = S(model_->base_height_m), l1 = S(model_->upper_link_m), l2 = S(model_->forearm_m);
    Posture<S> p;
    p.q1 = sin_cos(q[0]);
    p.q2 = sin_cos(q[1]);
    p.q3 = sin_cos(q[2]);
    const S reach = l1 * p.q2.cos + l2 * p.q3.sin;
    p.tip_m =
        p_WB_ + R_WB_ * Vector3<S>(p.q1.cos * reach, p.q1.sin * reach, l0 + l1 * p.q2.sin - l2 * p.q3.cos);
    Matrix3<S> J_B;
    J_B << -p.q1.sin * reach, -p.q1.cos * l1 * p.q2.sin, p.q1.cos * l2 * p.q3.cos,  //
        p.q1.cos * reach, -p.q1.sin * l1 * p.q2.sin, p.q1.sin * l2 * p.q3.cos,      //
        0, l1 * p.q2.cos, l2 * p.q3.sin;
    p.jacobian = R_WB_ * J_B;
    return p;
  }

  // Jdot qd: acceleration of the tip at zero joint acceleration, m/s2, world frame.
  [[nodiscard]] Vector3<S> acceleration_bias(const Posture<S>& p, const Vector3<S>& qd) const noexcept {
    const S l1 = S(model_->upper_link_m), l2 = S(model_->forearm_m);
    const S reach = l1 * p.q2.cos + l2 * p.q3.sin;
    const S reach_d = -l1 * p.q2.sin * qd[1] + l2 * p.q3.cos * qd[2];
    const S out = -l1 * p.q2.cos * qd[1] * qd[1] - l2 * p.q3.sin * qd[2] * qd[2] - reach * qd[0] * qd[0];
    const S round = 2 * reach_d * qd[0];
    const S up = -l1 * p.q2.sin * qd[1] * qd[1] + l2 * p.q3.cos * qd[2] * qd[2];
    return R_WB_ * Vector3<S>(p.q1.cos * out - p.q1.sin * round, p.q1.sin * out + p.q1.cos * round, up);
  }

  // Inverse kinematics: joint angles for the tip position p_W (world frame), with the elbow up and joint 1
  // facing p_W. False (q unchanged) if p_W is out of reach. Joint limits are not checked; see
  // workspace_limit().
  [[nodiscard]] bool inverse(const Vector3<S>& p_W, Vector3<S>& q) const noexcept {
    const S l0 = S(model_->base_height_m), l1 = S(model_->upper_link_m), l2 = S(model_->forearm_m);
    const Vector3<S> p = R_WB_.transpose() * (p_W - p_WB_);
    const S reach = std::sqrt(p.x() * p.x() + p.y() * p.y()), up = p.z() - l0;
    const S distance2 = reach * reach + up * up, distance = std::sqrt(distance2);
    if (!(distance < l1 + l2 && distance > std::abs(l1 - l2))) return false;
    const S q2 = std::atan2(up, reach) + std::acos((l1 * l1 + distance2 - l2 * l2) / (2 * l1 * distance));
    const SinCos<S> upper = sin_cos(q2);
    const S forearm = std::atan2(up - l1 * upper.sin, reach - l1 * upper.cos);  // above the horizontal
    q = {std::atan2(p.y(), p.x()), q2, forearm + S(1.57079632679489662)};
    return true;
  }

 private:
  const ArmModel* model_;
  Matrix3<S> R_WB_;
  Vector3<S> p_WB_;
};

}  // namespace thimble::kinematics
