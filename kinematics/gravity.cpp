#include "kinematics/gravity.h"

namespace thimble::kinematics {
namespace {

template <typename S>
using Vector2 = Eigen::Matrix<S, 2, 1>;

// The links of a five-bar move in the plane z = 0.
template <typename S>
void move_five_bar(const FiveBarGeometry& links, const Body& body, const AxisVector<S>& q,
                   const MechanismPose<S>& pose, Jacobian3<S>& by_joint) noexcept {
  const bool outer = body.link == BodyLink::kOuter;
  const auto leg = static_cast<std::size_t>(body.joint);
  const SinCos<S> turn = sin_cos(S(q[body.joint]));
  const Vector2<S> along(turn.cos, turn.sin), across(-turn.sin, turn.cos);
  const Vector2<S> centre = body.centre_m.template head<2>().template cast<S>();
  if (!outer) {
    by_joint.col(body.joint).template head<2>() = across * centre.x() - along * centre.y();
    return;
  }
  // An outer link turns by what the velocity of the tip across it is more than that of its elbow.
  const S inner = S(links.inner_m[leg]), length = S(links.outer_m[leg]);
  const Vector2<S> base(leg == 0 ? S(0) : S(links.base_distance_m), S(0));
  const Vector2<S> x = (pose.plate_m.template head<2>() - base - inner * along) / length, y(-x.y(), x.x());
  for (int j = 0; j < 2; ++j) {
    const Vector2<S> elbow = j == body.joint ? Vector2<S>(inner * across) : Vector2<S>::Zero();
    const S turns = y.dot(pose.plate_jacobian.col(j).template head<2>() - elbow) / length;
    by_joint.col(j).template head<2>() = elbow + turns * (y * centre.x() - x * centre.y());
  }
}

// Of the thigh of one leg.
template <typename S>
void move_thigh(const DeltaGeometry& delta, const Body& body, int i, const AxisVector<S>& q,
                Jacobian3<S>& by_joint) noexcept {
  const SinCos<S> leg = sin_cos(S(delta.leg_angle_rad[static_cast<std::size_t>(i)]));
  const SinCos<S> turn = sin_cos(S(q[i]));
  const S x = S(body.centre_m.x()), z = S(body.centre_m.z());
  const S outwards = -x * turn.sin - z * turn.cos, upwards = x * turn.cos - z * turn.sin;
  by_joint.col(i) << leg.cos * outwards, leg.sin * outwards, upwards;
}

template <typename S>
void move_chain_link(const Geometry& geometry, const Body& body, const MechanismPose<S>& pose,
                     Jacobian3<S>& by_joint) noexcept {
  const int platform = platform_joints(geometry);
  const auto link = static_cast<std::size_t>(body.joint);
  const Vector3<S> centre =
      pose.chain.link_m[link] + pose.chain.link[link] * body.centre_m.template cast<S>();
  by_joint.leftCols(platform) = pose.plate_jacobian;
  for (int k = 0; k <= body.joint; ++k)
    by_joint.col(platform + k) = velocity_by_joint<S>(geometry.chain, pose.chain, k, body.joint + 1, centre);
}

// Calls add(mass in kg, velocity of the centre by the speeds of the joints, in the base frame) for each body.
template <typename S, typename Add>
void for_each_body(const Mechanism<S>& arm, const AxisVector<S>& axes, const MechanismPose<S>& pose,
                   Add add) noexcept {
  const Geometry& geometry = arm.geometry();
  const AxisVector<S> q = arm.joints(axes);
  for (int i = 0; i < geometry.body_count; ++i) {
    const Body& body = geometry.body[static_cast<std::size_t>(i)];
    const auto* bars = std::get_if<FiveBarGeometry>(&geometry.platform);
    const auto* delta = std::get_if<DeltaGeometry>(&geometry.platform);
    const bool thighs = body.link == BodyLink::kThighs;
    for (int leg = 0; leg < (thighs ? 3 : 1); ++leg) {
      Jacobian3<S> by_joint = Jacobian3<S>::Zero(3, arm.axes());
      switch (body.link) {
        case BodyLink::kChain:
          move_chain_link(geometry, body, pose, by_joint);
          break;
        case BodyLink::kPlate:
          by_joint.leftCols(platform_joints(geometry)) = pose.plate_jacobian;
          break;
        case BodyLink::kThighs:
          if (delta != nullptr) move_thigh(*delta, body, leg, q, by_joint);
          break;
        case BodyLink::kInner:
        case BodyLink::kOuter:
          if (bars != nullptr) move_five_bar(*bars, body, q, pose, by_joint);
          break;
      }
      add(S(body.mass_kg), by_joint);
    }
  }
}

}  // namespace

template <typename S>
AxisVector<S> gravity_torques(const Mechanism<S>& arm, const AxisVector<S>& axes,
                              const MechanismPose<S>& pose) noexcept {
  const Vector3<S> up = arm.up() * S(kGravity_m_s2);
  AxisVector<S> by_joint = AxisVector<S>::Zero(arm.axes());
  for_each_body(arm, axes, pose, [&by_joint, &up](S mass, const Jacobian3<S>& centre) {
    by_joint += mass * (centre.transpose() * up);
  });
  return arm.to_axes(by_joint);
}

template <typename S>
S moving_mass(const Mechanism<S>& arm, const AxisVector<S>& axes, const MechanismPose<S>& pose,
              const AxisVector<S>& axis_speeds) noexcept {
  const AxisVector<S> speeds = arm.joint_speeds(axis_speeds);
  S sum = 0;
  for_each_body(arm, axes, pose, [&sum, &speeds](S mass, const Jacobian3<S>& centre) {
    sum += mass * (centre * speeds).squaredNorm();
  });
  return sum;
}

template AxisVector<float> gravity_torques(const Mechanism<float>&, const AxisVector<float>&,
                                           const MechanismPose<float>&) noexcept;
template AxisVector<double> gravity_torques(const Mechanism<double>&, const AxisVector<double>&,
                                            const MechanismPose<double>&) noexcept;
template float moving_mass(const Mechanism<float>&, const AxisVector<float>&, const MechanismPose<float>&,
                           const AxisVector<float>&) noexcept;
template double moving_mass(const Mechanism<double>&, const AxisVector<double>&, const MechanismPose<double>&,
                            const AxisVector<double>&) noexcept;

}  // namespace thimble::kinematics
