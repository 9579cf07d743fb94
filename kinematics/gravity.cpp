#include "kinematics/gravity.h"

namespace thimble::kinematics {
namespace {

template <typename S>
using Vector2 = Eigen::Matrix<S, 2, 1>;

// The links of a five-bar move in the plane z = 0, so their weight is felt where the base is tilted. up: upwards in the base frame, m/s2.
template <typename S>
void add_five_bar(const FiveBarGeometry& links, const Body& body, const AxisVector<S>& q,
                  const MechanismPose<S>& pose, const Vector3<S>& up, AxisVector<S>& by_joint) noexcept {
  const bool outer = body.link == BodyLink::kOuter;
  const auto leg = static_cast<std::size_t>(body.joint);
  const SinCos<S> turn = sin_cos(S(q[body.joint]));
  const Vector2<S> along(turn.cos, turn.sin), across(-turn.sin, turn.cos);
  const Vector2<S> centre = body.centre_m.template head<2>().template cast<S>();
  const Vector2<S> up2 = up.template head<2>();
  const S mass = S(body.mass_kg);
  if (!outer) {
    by_joint[body.joint] += mass * up2.dot(across * centre.x() - along * centre.y());
    return;
  }
  // An outer link turns by what the velocity of the tip across it is more than that of its elbow.
  const S inner = S(links.inner_m[leg]), length = S(links.outer_m[leg]);
  const Vector2<S> base(leg == 0 ? S(0) : S(links.base_distance_m), S(0));
  const Vector2<S> x = (pose.plate_m.template head<2>() - base - inner * along) / length, y(-x.y(), x.x());
  for (int j = 0; j < 2; ++j) {
    const Vector2<S> elbow = j == body.joint ? Vector2<S>(inner * across) : Vector2<S>::Zero();
    const S turns = y.dot(pose.plate_jacobian.col(j).template head<2>() - elbow) / length;
    by_joint[j] += mass * up2.dot(elbow + turns * (y * centre.x() - x * centre.y()));
  }
}

template <typename S>
void add_thighs(const DeltaGeometry& delta, const Body& body, const AxisVector<S>& q, const Vector3<S>& up,
                AxisVector<S>& by_joint) noexcept {
  for (int i = 0; i < 3; ++i) {
    const SinCos<S> leg = sin_cos(S(delta.leg_angle_rad[static_cast<std::size_t>(i)]));
    const SinCos<S> turn = sin_cos(S(q[i]));
    const S x = S(body.centre_m.x()), z = S(body.centre_m.z());
    const S outwards = -x * turn.sin - z * turn.cos, upwards = x * turn.cos - z * turn.sin;
    by_joint[i] += S(body.mass_kg) * up.dot(Vector3<S>(leg.cos * outwards, leg.sin * outwards, upwards));
  }
}

template <typename S>
void add_chain_link(const Geometry& geometry, const Body& body, const MechanismPose<S>& pose,
                    const Vector3<S>& up, AxisVector<S>& by_joint) noexcept {
  const int platform = platform_joints(geometry);
  const auto link = static_cast<std::size_t>(body.joint);
  const Vector3<S> centre =
      pose.chain.link_m[link] + pose.chain.link[link] * body.centre_m.template cast<S>();
  const S mass = S(body.mass_kg);
  for (int j = 0; j < platform; ++j) by_joint[j] += mass * up.dot(pose.plate_jacobian.col(j));
  for (int k = 0; k <= body.joint; ++k)
    by_joint[platform + k] +=
        mass * up.dot(velocity_by_joint<S>(geometry.chain, pose.chain, k, body.joint + 1, centre));
}

}  // namespace

template <typename S>
AxisVector<S> gravity_torques(const Mechanism<S>& arm, const AxisVector<S>& axes,
                              const MechanismPose<S>& pose) noexcept {
  const Geometry& geometry = arm.geometry();
  const Vector3<S> up = arm.up() * S(kGravity_m_s2);
  const AxisVector<S> q = arm.joints(axes);
  AxisVector<S> by_joint = AxisVector<S>::Zero(arm.axes());
  for (int i = 0; i < geometry.body_count; ++i) {
    const Body& body = geometry.body[static_cast<std::size_t>(i)];
    const auto* bars = std::get_if<FiveBarGeometry>(&geometry.platform);
    const auto* delta = std::get_if<DeltaGeometry>(&geometry.platform);
    switch (body.link) {
      case BodyLink::kChain:
        add_chain_link(geometry, body, pose, up, by_joint);
        break;
      case BodyLink::kPlate:
        for (int j = 0; j < platform_joints(geometry); ++j)
          by_joint[j] += S(body.mass_kg) * up.dot(pose.plate_jacobian.col(j));
        break;
      case BodyLink::kThighs:
        if (delta != nullptr) add_thighs(*delta, body, q, up, by_joint);
        break;
      case BodyLink::kInner:
      case BodyLink::kOuter:
        if (bars != nullptr) add_five_bar(*bars, body, q, pose, up, by_joint);
        break;
    }
  }
  return arm.to_axes(by_joint);
}

template AxisVector<float> gravity_torques(const Mechanism<float>&, const AxisVector<float>&,
                                           const MechanismPose<float>&) noexcept;
template AxisVector<double> gravity_torques(const Mechanism<double>&, const AxisVector<double>&,
                                            const MechanismPose<double>&) noexcept;

}  // namespace thimble::kinematics
