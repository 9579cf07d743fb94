// Serial chains of one to seven joints, revolute and prismatic, at random, with random couplings: poses and Jacobians against KDL.
#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::kinematics {
namespace {

KDL::Vector kdl(const Eigen::Vector3f& v) {
  const Vector3d d = v.cast<double>();
  return {d.x(), d.y(), d.z()};
}
KDL::Rotation kdl(const Eigen::Matrix3f& m) {
  const Eigen::Matrix3d d = m.cast<double>();
  return {d(0, 0), d(0, 1), d(0, 2), d(1, 0), d(1, 1), d(1, 2), d(2, 0), d(2, 1), d(2, 2)};
}

Eigen::Matrix3f some_rotation(Random& random) {
  return Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix().cast<float>();
}

Geometry some_chain(Random& random) {
  Geometry geometry;
  ChainGeometry& chain = geometry.chain;
  chain.count = 1 + static_cast<int>(random.below(kMaxJoints));
  chain.force_joint = static_cast<int>(random.below(static_cast<std::uint64_t>(chain.count) + 1));
  for (int k = 0; k < chain.count; ++k) {
    ChainJoint& joint = chain.joint.at(static_cast<std::size_t>(k));
    joint.kind = random.below(4) == 0 ? JointKind::kPrismatic : JointKind::kRevolute;
    joint.origin_m = (0.15 * random.in_box(Vector3d::Ones())).cast<float>();
    joint.rotation = some_rotation(random);
    joint.axis = random.direction().cast<float>();
    geometry.driven.at(static_cast<std::size_t>(k)) = random.below(3) != 0;
    const double unit = joint.kind == JointKind::kPrismatic ? 0.05 : 1.0;  // m or rad
    for (int j = 0; j < chain.count; ++j)
      geometry.joints_per_axis(k, j) =
          static_cast<float>(unit * (random.uniform(-0.3, 0.3) + (j == k ? 1.0 : 0.0)));
    geometry.joint_offset[k] = static_cast<float>(random.uniform(-1, 1));
    geometry.home[k] = static_cast<float>(random.uniform(-1, 1));
  }
  chain.tip_m = (0.15 * random.in_box(Vector3d::Ones())).cast<float>();
  geometry.rotation = some_rotation(random);
  return geometry;
}

// With a segment that ends at the origin of joint `segments`, or at the tip. Axes are not of length 1 to all bits, so KDL normalises them.
KDL::Chain peer_of(const ChainGeometry& chain, int joints) {
  KDL::Chain peer;
  for (int k = 0; k < joints; ++k) {
    const ChainJoint& joint = chain.joint.at(static_cast<std::size_t>(k));
    peer.addSegment(
        KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(kdl(joint.rotation), kdl(joint.origin_m))));
    const auto kind = joint.kind == JointKind::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    peer.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), kdl(joint.axis), kind), KDL::Frame()));
  }
  const Eigen::Vector3f end_m =
      joints == chain.count ? chain.tip_m : chain.joint.at(static_cast<std::size_t>(joints)).origin_m;
  peer.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(kdl(end_m))));
  return peer;
}

struct Peer {
  Eigen::Matrix3d rotation;
  Vector3d position_m;
  Eigen::MatrixXd jacobian;
};
Peer ask(const KDL::Chain& chain, const Eigen::VectorXd& q) {
  KDL::JntArray joints(chain.getNrOfJoints());
  joints.data = q.head(static_cast<Eigen::Index>(chain.getNrOfJoints()));
  KDL::Frame frame;
  KDL::Jacobian jacobian(chain.getNrOfJoints());
  EXPECT_GE(KDL::ChainFkSolverPos_recursive(chain).JntToCart(joints, frame), 0);
  EXPECT_GE(KDL::ChainJntToJacSolver(chain).JntToJac(joints, jacobian), 0);
  Peer peer;
  for (int i = 0; i < 3; ++i) {
    peer.position_m[i] = frame.p(i);
    for (int j = 0; j < 3; ++j) peer.rotation(i, j) = frame.M(i, j);
  }
  peer.jacobian = jacobian.data;
  return peer;
}

struct Worst {
  double position_m = 0, rotation = 0, jacobian = 0, force_jacobian = 0, torque_N_m = 0;
};

template <typename S>
void compare(Random& random, Worst& worst) {
  const Geometry geometry = some_chain(random);
  const int n = geometry.chain.count;
  BasePose base;
  base.rotation = some_rotation(random);
  base.home_m = random.in_box(Vector3d::Ones()).cast<float>();
  const Mechanism<S> arm(geometry, base);
  const AxisVector<S> axes = 2.0 * AxisVector<double>::Random(n).template cast<S>();
  MechanismPose<S> pose = arm.home_pose();
  ASSERT_TRUE(arm.at(axes, pose));

  const Eigen::MatrixXd C = geometry.joints_per_axis.topLeftCorner(n, n).cast<double>();
  const auto joints = [&](const Eigen::VectorXd& a) -> Eigen::VectorXd {
    return C * a + geometry.joint_offset.head(n).cast<double>();
  };
  const Eigen::Matrix3d R_WB = base.rotation.cast<double>() * geometry.rotation.cast<double>();
  const KDL::Chain chain = peer_of(geometry.chain, n);
  const Vector3d home_m = ask(chain, joints(arm.home().template cast<double>())).position_m;
  const auto in_world = [&](const Vector3d& p) -> Vector3d {
    return base.home_m.cast<double>() + R_WB * (p - home_m);
  };
  const Eigen::VectorXd q = joints(axes.template cast<double>());
  const Peer tip = ask(chain, q);
  const Peer force = ask(peer_of(geometry.chain, geometry.chain.force_joint), q);
  Eigen::MatrixXd twist(6, n), velocity = Eigen::MatrixXd::Zero(3, n);
  twist << R_WB * tip.jacobian.topRows(3) * C, R_WB * tip.jacobian.bottomRows(3) * C;
  velocity = R_WB * force.jacobian.topRows(3) * C.topRows(geometry.chain.force_joint);

  const auto most = [](double& value, double error) { value = std::max(value, error); };
  most(worst.position_m, (pose.tip_m.template cast<double>() - in_world(tip.position_m)).norm());
  most(worst.position_m, (pose.force_point_m.template cast<double>() - in_world(force.position_m)).norm());
  most(worst.rotation, (pose.rotation.template cast<double>() - R_WB * tip.rotation).norm());
  most(worst.jacobian, (pose.jacobian.template cast<double>() - twist).cwiseAbs().maxCoeff());
  most(worst.force_jacobian, (pose.force_jacobian.template cast<double>() - velocity).cwiseAbs().maxCoeff());
  const Vector3d force_N = 5 * random.direction();
  const AxisVector<S> torques = arm.torques(pose, force_N.cast<S>());
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << force_N, random.in_box(Vector3d::Ones());
  const AxisVector<S> of_wrench = arm.torques_of_wrench(pose, wrench.cast<S>());
  for (int i = 0; i < n; ++i) {
    const bool driven = geometry.driven.at(static_cast<std::size_t>(i));
    const auto error = [&](S torque, double wanted) {
      return std::abs(static_cast<double>(torque) - (driven ? wanted : 0.0));
    };
    most(worst.torque_N_m, error(torques[i], velocity.col(i).dot(force_N)));
    most(worst.torque_N_m, error(of_wrench[i], twist.col(i).dot(wrench)));
  }
}

template <typename S>
Worst sweep(int chains) {
  Worst worst;
  Random random(16);
  for (int i = 0; i < chains; ++i) compare<S>(random, worst);
  test::figure("chains against KDL: position, m", worst.position_m, "");
  test::figure("chains against KDL: rotation", worst.rotation, "");
  test::figure("chains against KDL: Jacobian", worst.jacobian, "");
  return worst;
}

TEST(Chain, InDoubleIsAsKdlHasIt) {
  const Worst worst = sweep<double>(5000);
  EXPECT_LT(worst.position_m, 1e-9);
  EXPECT_LT(worst.rotation, 1e-9);
  EXPECT_LT(worst.jacobian, 1e-9);
  EXPECT_LT(worst.force_jacobian, 1e-9);
  EXPECT_LT(worst.torque_N_m, 1e-9);
}

TEST(Chain, InFloatIsWithinAMicrometre) {
  const Worst worst = sweep<float>(5000);
  EXPECT_LT(worst.position_m, 2e-6);
  EXPECT_LT(worst.jacobian, 5e-6);
}

}  // namespace
}  // namespace thimble::kinematics
