#include "board/sim/mechanics/arm_frames.h"

#include <Eigen/LU>
#include <cmath>

#include "kinematics/trig.h"

namespace thimble::board {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using kinematics::sin_cos;
using kinematics::SinCos;

double of(float value) { return static_cast<double>(value); }

Matrix3d turned_by(const Vector3d& axis, double angle) {
  const SinCos<double> half = sin_cos(0.5 * angle);
  const Vector3d v = half.sin * axis;
  return Eigen::Quaterniond(half.cos, v.x(), v.y(), v.z()).toRotationMatrix();
}

Matrix3d about_z(const Vector2d& x) {
  Matrix3d R = Matrix3d::Identity();
  R.topLeftCorner<2, 2>() << x.x(), -x.y(), x.y(), x.x();
  return R;
}

Vector2d square_to(const Vector2d& v) { return {-v.y(), v.x()}; }

void find_chain(const kinematics::ChainGeometry& chain, Eigen::Index first, const JointVector& q,
                const JointVector& qd, ArmFrames& frames) {
  MovingFrame frame = frames.plate;
  frames.chain.clear();
  for (int k = 0; k < chain.count; ++k) {
    const kinematics::ChainJoint& joint = chain.joint.at(static_cast<std::size_t>(k));
    const Eigen::Index j = first + k;
    frame.shift(joint.origin_m.cast<double>(), qd);
    frame.rotation = (frame.rotation * joint.rotation.cast<double>()).eval();
    const Vector3d axis = joint.axis.cast<double>().normalized();
    if (joint.kind == kinematics::JointKind::kRevolute) {
      frame.revolve(axis, turned_by(axis, q[j]), j, qd);
    } else {
      frame.slide(axis, q[j], j, qd);
    }
    frames.chain.push_back(frame);
  }
  frames.tip = frame;
  frames.tip.shift(chain.tip_m.cast<double>(), qd);
}

// Both links turn from the shoulder: the angle of the forearm is absolute.
void find_two_link(const kinematics::TwoLinkGeometry& links, const JointVector& q, const JointVector& qd,
                   MovingFrame& plate) {
  MovingFrame frame = MovingFrame::fixed({0, 0, of(links.base_height_m)}, Matrix3d::Identity(), q.size());
  frame.revolve(Vector3d::UnitZ(), turned_by(Vector3d::UnitZ(), q[0]), 0, qd);
  const MovingFrame shoulder = frame;
  frame.revolve(-Vector3d::UnitY(), turned_by(-Vector3d::UnitY(), q[1]), 1, qd);
  const MovingPoint elbow = frame.point({of(links.upper_link_m), 0, 0}, qd);
  frame = shoulder;
  frame.revolve(-Vector3d::UnitY(), turned_by(-Vector3d::UnitY(), q[2]), 2, qd);
  frame.origin = elbow;
  plate.origin = frame.point({0, 0, -of(links.forearm_m)}, qd);
}

bool find_five_bar(const kinematics::FiveBarGeometry& links, const JointVector& q, const JointVector& qd,
                   ArmFrames& frames) {
  frames.inner.clear();
  frames.outer.clear();
  std::array<MovingPoint, 2> elbow;
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto leg = static_cast<std::size_t>(i);
    MovingFrame frame =
        MovingFrame::fixed({i == 0 ? 0.0 : of(links.base_distance_m), 0, 0}, Matrix3d::Identity(), q.size());
    frame.revolve(Vector3d::UnitZ(), turned_by(Vector3d::UnitZ(), q[i]), i, qd);
    frames.inner.push_back(frame);
    elbow[leg] = frame.point({of(links.inner_m.at(leg)), 0, 0}, qd);
  }
  // The triangle of the elbows and the tip, by the angle at the first elbow.
  const double L1 = of(links.outer_m[0]), L2 = of(links.outer_m[1]);
  const Vector2d between = (elbow[1].at_m - elbow[0].at_m).head<2>();
  const double distance = between.norm();
  const double cosine = (L1 * L1 + distance * distance - L2 * L2) / (2 * L1 * distance);
  if (!(std::abs(cosine) < 1)) return false;
  const double sine = (links.up ? 1 : -1) * std::sqrt(1 - cosine * cosine);
  const Vector2d ahead = between / distance;
  std::array<Vector2d, 2> along;
  along[0] = cosine * ahead + sine * square_to(ahead);
  along[1] = (L1 * along[0] - between) / L2;
  // elbow 1 + L1 along 1 = elbow 2 + L2 along 2, once and twice differentiated, gives the outer links' turns.
  Eigen::Matrix2d turns;
  turns << L1 * square_to(along[0]), -L2 * square_to(along[1]);
  if (!(std::abs(turns.determinant()) > 1e-6 * L1 * L2)) return false;
  frames.spread = std::abs(turns.determinant()) / (L1 * L2);
  const Eigen::Matrix2d solve = turns.inverse();
  const Eigen::Matrix<double, 2, Eigen::Dynamic> by_joint =
      solve * (elbow[1].by_joint - elbow[0].by_joint).topRows<2>();
  const Vector2d speed = by_joint * qd;
  const Vector2d bias = solve * ((elbow[1].bias - elbow[0].bias).head<2>() +
                                 L1 * speed[0] * speed[0] * along[0] - L2 * speed[1] * speed[1] * along[1]);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto leg = static_cast<std::size_t>(i);
    MovingFrame frame{elbow[leg], about_z(along[leg]), ByJoint::Zero(3, q.size()), {0, 0, bias[i]}};
    frame.turn.row(2) = by_joint.row(i);
    frames.outer.push_back(frame);
  }
  frames.plate.origin = frames.outer[0].point({L1, 0, 0}, qd);
  return true;
}

// A leg in its own frame: the knee, the direction from there in the plane of the thigh, and the shins' sway out of it. The end of the leg is
// knee + rho radial + b sin(sway) y, rho = ends + b cos(sway).
struct Leg {
  Matrix3d to_base;
  Vector3d thigh, across;  // directions of the thigh, and of its end's motion
  Vector3d radial, tangent;
  double rho, cosine, sine;  // of the sway
  double missing_m;          // by which rho is too long
  Vector3d normal;           // along which the shins pull
};

bool find_leg(const kinematics::DeltaGeometry& g, Eigen::Index i, double angle, const Vector3d& plate_m,
              Leg& leg) {
  leg.to_base = turned_by(Vector3d::UnitZ(), of(g.leg_angle_rad.at(static_cast<std::size_t>(i))));
  const SinCos<double> q = sin_cos(angle);
  leg.thigh = {q.cos, 0, q.sin};
  leg.across = {-q.sin, 0, q.cos};
  const Vector3d end = leg.to_base.transpose() * plate_m -
                       Vector3d(of(g.base_u_m) - of(g.plate_u_m), of(g.base_v_m) - of(g.plate_v_m), 0) -
                       of(g.thigh_m) * leg.thigh;
  leg.rho = std::sqrt(end.x() * end.x() + end.z() * end.z());
  leg.sine = end.y() / of(g.shin_m);
  if (!(leg.rho > 1e-6 && std::abs(leg.sine) < 1)) return false;
  leg.cosine = std::sqrt(1 - leg.sine * leg.sine);
  leg.radial = Vector3d(end.x(), 0, end.z()) / leg.rho;
  leg.tangent = {-leg.radial.z(), 0, leg.radial.x()};
  leg.normal = leg.cosine * leg.radial + leg.sine * Vector3d::UnitY();
  leg.missing_m = leg.rho - of(g.shin_end_m) - of(g.knee_end_m) - of(g.shin_m) * leg.cosine;
  return true;
}

bool find_delta(const kinematics::DeltaGeometry& g, const JointVector& q, const JointVector& qd,
                ArmFrames& frames) {
  constexpr int kSteps = 20;
  constexpr double kClosed_m = 1e-13;
  Vector3d plate_m = frames.plate.origin.at_m;
  std::array<Leg, 3> legs;
  Matrix3d normals;
  double missing_m = 1;
  for (int step = 0; step < kSteps && missing_m > kClosed_m; ++step) {
    Vector3d missing;
    for (Eigen::Index i = 0; i < 3; ++i) {
      Leg& leg = legs[static_cast<std::size_t>(i)];
      if (!find_leg(g, i, q[i], plate_m, leg)) return false;
      normals.row(i) = (leg.to_base * leg.normal).transpose();
      missing[i] = leg.cosine * leg.missing_m;  // along the normal
    }
    if (!(std::abs(normals.determinant()) > 1e-4)) return false;
    plate_m -= normals.inverse() * missing;
    missing_m = missing.norm();
  }
  if (!(missing_m <= kClosed_m)) return false;

  frames.spread = std::abs(normals.determinant());
  // The ends of the legs move square to their normals but for what the thighs do.
  const Matrix3d solve = normals.inverse();
  Matrix3d by_joint = Matrix3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    by_joint.col(i) = solve.col(i) * of(g.thigh_m) * leg.normal.dot(leg.across);
  }
  const Vector3d velocity = by_joint * qd.head<3>();
  Vector3d pulls;
  frames.thigh.clear();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Leg& leg = legs[static_cast<std::size_t>(i)];
    const double a = of(g.thigh_m), b = of(g.shin_m);
    const Vector3d of_shins = leg.to_base.transpose() * velocity - a * qd[i] * leg.across;
    const double lift = leg.tangent.dot(of_shins) / leg.rho;
    const double sway = (leg.cosine * Vector3d::UnitY() - leg.sine * leg.radial).dot(of_shins) / b;
    const Vector3d bias = -a * qd[i] * qd[i] * leg.thigh - leg.rho * lift * lift * leg.radial -
                          b * sway * sway * leg.normal - 2 * b * leg.sine * sway * lift * leg.tangent;
    pulls[i] = leg.normal.dot(bias);
    MovingFrame frame = MovingFrame::fixed(
        leg.to_base * Vector3d(of(g.base_u_m) - of(g.plate_u_m), of(g.base_v_m) - of(g.plate_v_m), 0),
        leg.to_base, q.size());
    frame.revolve(-Vector3d::UnitY(), turned_by(-Vector3d::UnitY(), q[i]), i, qd);
    frames.thigh.push_back(frame);
  }
  frames.plate.origin = MovingPoint::fixed(plate_m, q.size());
  frames.plate.origin.by_joint.leftCols<3>() = by_joint;
  frames.plate.origin.bias = solve * pulls;
  return true;
}

}  // namespace

ArmFrames frames_at_rest(const kinematics::Geometry& geometry) {
  ArmFrames frames;
  const auto* delta = std::get_if<kinematics::DeltaGeometry>(&geometry.platform);
  frames.plate = MovingFrame::fixed({0, 0, delta == nullptr ? 0.0 : of(delta->home_axis_m)},
                                    Matrix3d::Identity(), kinematics::axes_of(geometry));
  return frames;
}

bool find_frames(const kinematics::Geometry& geometry, const JointVector& q, const JointVector& qd,
                 ArmFrames& frames) {
  const Vector3d before_m = frames.plate.origin.at_m;
  frames.plate = MovingFrame::fixed(Vector3d::Zero(), Matrix3d::Identity(), q.size());
  if (const auto* two = std::get_if<kinematics::TwoLinkGeometry>(&geometry.platform)) {
    find_two_link(*two, q, qd, frames.plate);
  } else if (const auto* bars = std::get_if<kinematics::FiveBarGeometry>(&geometry.platform)) {
    if (!find_five_bar(*bars, q, qd, frames)) return false;
  } else if (const auto* delta = std::get_if<kinematics::DeltaGeometry>(&geometry.platform)) {
    frames.plate.origin.at_m = before_m;
    if (!find_delta(*delta, q, qd, frames)) return false;
  }
  find_chain(geometry.chain, kinematics::platform_joints(geometry), q, qd, frames);
  return true;
}

}  // namespace thimble::board
