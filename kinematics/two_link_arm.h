// An arm that is a two-link parallelogram and no more (kinematics/two_link.h), in closed form: the path of the tick for the arms that are built in, and
// what the simulated arm of that family integrates. TwoLinkArm<float> runs in the tick, TwoLinkArm<double> in the simulated arm and in tests.
//
//   const TwoLinkArm<float> arm(data);
//   const TwoLinkPosture<float> posture = arm.at(joints_rad);
//   posture.tip_m;  posture.jacobian * joint_speeds_rad_s;          // position and velocity, world frame
//   posture.jacobian.transpose() * force_N;                         // joint torques, N m
//
// Units: m, rad, N, N m. at() cannot fail; an angle that is not finite or beyond kMaxAngle gives NaN. inverse() is not for the tick.
#pragma once

#include <cmath>
#include <variant>

#include "kinematics/arm_data.h"
#include "kinematics/base_pose.h"
#include "kinematics/trig.h"
#include "kinematics/two_link.h"

namespace thimble::kinematics {

template <typename S>
struct TwoLinkAngles {
  SinCos<S> q1, q2, q3;
};

template <typename S>
struct TwoLinkPosture : TwoLinkAngles<S> {
  Vector3<S> tip_m;     // world frame
  Matrix3<S> jacobian;  // d tip_m / d joints
};

// Whether its axes are the joints of a two-link platform, in their order.
[[nodiscard]] inline bool is_two_link(const Geometry& geometry) noexcept {
  return std::holds_alternative<TwoLinkGeometry>(geometry.platform) && geometry.chain.count == 0 &&
         geometry.joints_per_axis.topLeftCorner<3, 3>() == Eigen::Matrix3f::Identity() &&
         geometry.joint_offset.head<3>() == Eigen::Vector3f::Zero() && geometry.driven[0] &&
         geometry.driven[1] && geometry.driven[2];
}

template <typename S>
class TwoLinkArm {
 public:
  // data: for which is_two_link() holds; else it stands at the world's origin.
  explicit TwoLinkArm(const ArmData& data, const BasePose& base = {}) noexcept
      : home_(data.geometry.home.head<3>().template cast<S>()) {
    if (const auto* links = std::get_if<TwoLinkGeometry>(&data.geometry.platform)) links_ = *links;
    R_WB_ = base.rotation.template cast<S>() * data.geometry.rotation.template cast<S>();
    p_WB_.setZero();
    p_WB_ = base.home_m.template cast<S>() - at(home()).tip_m;
  }

  [[nodiscard]] const Vector3<S>& home() const noexcept { return home_; }

  [[nodiscard]] TwoLinkPosture<S> at(const Vector3<S>& q) const noexcept {
    TwoLinkPosture<S> posture;
    at(q, posture);
    return posture;
  }

  // Posture: TwoLinkAngles with a tip_m, and a jacobian of at least three columns.
  template <typename Joints, typename Posture>
  void at(const Joints& q, Posture& p) const noexcept {
    p.q1 = sin_cos(S(q[0]));
    p.q2 = sin_cos(S(q[1]));
    p.q3 = sin_cos(S(q[2]));
    Plate<S, 3> plate;
    two_link<S>(links_, p.q1, p.q2, p.q3, plate);
    p.tip_m = p_WB_ + R_WB_ * plate.position_m;
    p.jacobian.template leftCols<3>() = R_WB_ * plate.jacobian;
  }

  // Jdot qd: acceleration of the tip at zero joint acceleration, m/s2, world frame.
  [[nodiscard]] Vector3<S> acceleration_bias(const TwoLinkAngles<S>& p, const Vector3<S>& qd) const noexcept {
    const S l1 = S(links_.upper_link_m), l2 = S(links_.forearm_m);
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
    const S l0 = S(links_.base_height_m), l1 = S(links_.upper_link_m), l2 = S(links_.forearm_m);
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
  TwoLinkGeometry links_{};
  Vector3<S> home_;
  Matrix3<S> R_WB_;
  Vector3<S> p_WB_;
};

}  // namespace thimble::kinematics
