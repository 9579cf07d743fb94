#include "board/sim/mechanics/arm_dynamics.h"

#include <variant>

namespace thimble::board {
namespace {

using Eigen::Vector3d;
using kinematics::BodyLink;

constexpr auto kWeight_m_s2 = static_cast<double>(kinematics::kGravity_m_s2);

MovingPoint by_axes(MovingPoint point, const JointMatrix& joints_per_axis) {
  point.by_joint = (point.by_joint * joints_per_axis).eval();
  return point;
}

}  // namespace

ArmDynamics::ArmDynamics(const kinematics::Geometry& geometry, const ArmInertia& inertia)
    : geometry_(geometry),
      inertia_(inertia),
      joints_per_axis_(
          geometry.joints_per_axis.topLeftCorner(kinematics::axes_of(geometry), kinematics::axes_of(geometry))
              .cast<double>()),
      up_(geometry.rotation.cast<double>().row(2)) {}

void ArmDynamics::add_body(const MovingFrame& frame, std::size_t body, const JointVector& qd,
                           ArmTerms& terms) const {
  const kinematics::Body& known = geometry_.body.at(body);
  const auto mass_kg = static_cast<double>(known.mass_kg);
  const MovingPoint centre = frame.point(known.centre_m.cast<double>(), qd);
  const Eigen::Matrix3d inertia =
      frame.rotation * inertia_.body_kg_m2.at(body).asDiagonal() * frame.rotation.transpose();
  const Vector3d omega = frame.turn * qd;
  terms.mass += mass_kg * (centre.by_joint.transpose() * centre.by_joint) +
                frame.turn.transpose() * inertia * frame.turn;
  terms.bias += centre.by_joint.transpose() * (mass_kg * (centre.bias + kWeight_m_s2 * up_)) +
                frame.turn.transpose() * (inertia * frame.turn_bias + omega.cross(inertia * omega));
  terms.potential_J += mass_kg * kWeight_m_s2 * up_.dot(centre.at_m);
}

double ArmDynamics::spread(const JointVector& axes, ArmFrames& frames) const {
  const JointVector q = joints_per_axis_ * axes + geometry_.joint_offset.head(axes.size()).cast<double>();
  return find_frames(geometry_, q, JointVector::Zero(axes.size()), frames) ? frames.spread : 0;
}

ArmFrames ArmDynamics::frames_near(const JointVector& axes) const {
  constexpr double kStep_rad = .2;
  ArmFrames frames = frames_at_rest(geometry_);
  if (!std::holds_alternative<kinematics::DeltaGeometry>(geometry_.platform)) return frames;
  JointVector way = axes;
  for (Eigen::Index j = 0; j < axes.size(); ++j) way[j] -= static_cast<double>(geometry_.home[j]);
  const int steps = static_cast<int>(way.lpNorm<Eigen::Infinity>() / kStep_rad);
  for (int k = 0; k <= steps; ++k)
    static_cast<void>(spread(axes - way * (steps + 1 - k) / (steps + 1), frames));
  return frames;
}

bool ArmDynamics::at(const JointVector& axes, const JointVector& speeds, ArmFrames& frames,
                     ArmTerms& terms) const {
  const Eigen::Index n = axes.size();
  const JointVector q = joints_per_axis_ * axes + geometry_.joint_offset.head(n).cast<double>();
  const JointVector qd = joints_per_axis_ * speeds;
  if (!find_frames(geometry_, q, qd, frames)) return false;
  terms.mass = JointMatrix::Zero(n, n);
  terms.bias = JointVector::Zero(n);
  terms.potential_J = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(geometry_.body_count); ++i) {
    const kinematics::Body& body = geometry_.body.at(i);
    const auto joint = static_cast<std::size_t>(body.joint);
    switch (body.link) {
      case BodyLink::kChain:
        add_body(frames.chain.at(joint), i, qd, terms);
        break;
      case BodyLink::kPlate:
        add_body(frames.plate, i, qd, terms);
        break;
      case BodyLink::kThighs:
        for (const MovingFrame& thigh : frames.thigh) add_body(thigh, i, qd, terms);
        break;
      case BodyLink::kInner:
        add_body(frames.inner.at(joint), i, qd, terms);
        break;
      case BodyLink::kOuter:
        add_body(frames.outer.at(joint), i, qd, terms);
        break;
    }
  }
  terms.mass = (joints_per_axis_.transpose() * terms.mass * joints_per_axis_).eval();
  terms.bias = (joints_per_axis_.transpose() * terms.bias).eval();
  terms.mass.diagonal() += inertia_.rotor_kg_m2;
  terms.tip = by_axes(frames.tip.origin, joints_per_axis_);
  const kinematics::ChainGeometry& chain = geometry_.chain;
  const bool at_tip = chain.force_joint >= chain.count;
  if (at_tip) {
    terms.force_point = terms.tip;
  } else {
    const auto joint = static_cast<std::size_t>(chain.force_joint);
    const MovingFrame& before = joint == 0 ? frames.plate : frames.chain.at(joint - 1);
    terms.force_point =
        by_axes(before.point(chain.joint.at(joint).origin_m.cast<double>(), qd), joints_per_axis_);
  }
  return true;
}

}  // namespace thimble::board
