// The simulator's rigid-body model: against KDL for chains; for all families the tip's Jacobian and acceleration against differences, and against the
// controller's kinematics, which it shares no code with; and a free arm keeps its energy.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>

#include "board/sim/mechanics/arm_dynamics.h"
#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::board {
namespace {

using kinematics::Body;
using kinematics::BodyLink;
using kinematics::Geometry;
using test::Random;
using Vector3d = Eigen::Vector3d;

KDL::Vector kdl_vector(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

void add_chain(Random& random, int count, kinematics::ChainGeometry& chain) {
  chain.count = count;
  chain.force_joint = static_cast<int>(random.below(static_cast<std::uint64_t>(count) + 1));
  for (int k = 0; k < count; ++k) {
    kinematics::ChainJoint& joint = chain.joint.at(static_cast<std::size_t>(k));
    joint.kind = random.below(4) == 0 ? kinematics::JointKind::kPrismatic : kinematics::JointKind::kRevolute;
    joint.origin_m = (0.15 * random.in_box(Vector3d::Ones())).cast<float>();
    joint.axis = random.direction().cast<float>();
  }
  chain.tip_m = (0.15 * random.in_box(Vector3d::Ones())).cast<float>();
}

void couple(Random& random, Geometry& geometry) {
  const int n = kinematics::axes_of(geometry);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      geometry.joints_per_axis(i, j) = static_cast<float>((i == j ? 1.0 : 0.0) + random.uniform(-0.2, 0.2));
}

struct SomeArm {
  Geometry geometry;
  ArmInertia inertia;
  JointVector axes, speeds;
};

void add_body(Random& random, BodyLink link, int joint, SomeArm& arm) {
  const auto index = static_cast<std::size_t>(arm.geometry.body_count++);
  Body& body = arm.geometry.body.at(index);
  body = {link, joint, static_cast<float>(random.uniform(0.05, 0.5)),
          (0.05 * random.in_box(Vector3d::Ones())).cast<float>()};
  arm.inertia.body_kg_m2.at(index) = 1e-4 * (Vector3d::Ones() + 0.4 * random.in_box(Vector3d::Ones()));
}

// A chain, a two-link arm, a five-bar or a delta, the last two sometimes with a wrist; all with bodies on each link, rotors and a tilted base.
SomeArm some_arm(Random& random, int family) {
  SomeArm arm;
  if (family == 0) {
    add_chain(random, 1 + static_cast<int>(random.below(7)), arm.geometry.chain);
  } else if (family == 1) {
    arm.geometry.platform = kinematics::TwoLinkGeometry{0.05F, 0.2F, 0.17F};
  } else if (family == 2) {
    kinematics::Case one;
    while (!kinematics::some_five_bar_case(random, one)) {
    }
    arm.geometry = one.geometry;
    for (int i = 0; i < 4; ++i) add_body(random, i < 2 ? BodyLink::kInner : BodyLink::kOuter, i % 2, arm);
  } else {
    Vector3d place_m;
    arm.geometry = kinematics::some_delta_case(random, place_m).geometry;
    add_body(random, BodyLink::kPlate, 0, arm);
    add_body(random, BodyLink::kThighs, 0, arm);
  }
  const int platform = kinematics::platform_joints(arm.geometry);
  if (family > 1 && random.below(2) == 0)
    add_chain(random, 1 + static_cast<int>(random.below(3)), arm.geometry.chain);
  for (int k = 0; k < arm.geometry.chain.count; ++k) add_body(random, BodyLink::kChain, k, arm);
  if (family == 0) couple(random, arm.geometry);
  arm.geometry.rotation =
      Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix().cast<float>();
  const int n = platform + arm.geometry.chain.count;
  arm.inertia.rotor_kg_m2 = JointVector::Constant(n, 1e-4);
  arm.axes = arm.geometry.home.head(n).cast<double>() + 0.2 * JointVector::Random(n);
  arm.speeds = 2 * JointVector::Random(n);
  return arm;
}

struct Terms {
  bool closed = false;
  ArmFrames frames;
  ArmTerms terms;
};
Terms terms_of(const SomeArm& arm, const JointVector& axes, const JointVector& speeds) {
  const ArmDynamics dynamics(arm.geometry, arm.inertia);
  Terms found{false, frames_at_rest(arm.geometry), {}};
  found.closed = dynamics.at(axes, speeds, found.frames, found.terms);
  return found;
}

TEST(Dynamics, OfChainsIsAsKdlHasIt) {
  Random random(1);
  double mass = 0, bias = 0;
  for (int i = 0; i < 1000; ++i) {
    SomeArm arm = some_arm(random, 0);
    arm.geometry.joints_per_axis.setIdentity();
    arm.inertia.rotor_kg_m2.setZero();
    KDL::Chain chain;
    for (int k = 0; k < arm.geometry.chain.count; ++k) {
      const kinematics::ChainJoint& joint = arm.geometry.chain.joint.at(static_cast<std::size_t>(k));
      const Body& body = arm.geometry.body.at(static_cast<std::size_t>(k));
      const Vector3d& inertia = arm.inertia.body_kg_m2.at(static_cast<std::size_t>(k));
      chain.addSegment(
          KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(kdl_vector(joint.origin_m.cast<double>()))));
      const auto kind =
          joint.kind == kinematics::JointKind::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
      chain.addSegment(KDL::Segment(
          KDL::Joint(KDL::Vector::Zero(), kdl_vector(joint.axis.cast<double>()), kind), KDL::Frame(),
          KDL::RigidBodyInertia(static_cast<double>(body.mass_kg), kdl_vector(body.centre_m.cast<double>()),
                                KDL::RotationalInertia(inertia.x(), inertia.y(), inertia.z()))));
    }
    const auto n = static_cast<unsigned>(arm.axes.size());
    const Vector3d down = arm.geometry.rotation.cast<double>().transpose() *
                          Vector3d(0, 0, -static_cast<double>(kinematics::kGravity_m_s2));
    KDL::ChainDynParam peer(chain, kdl_vector(down));
    KDL::JntArray q(n), qd(n), coriolis(n), weight(n);
    KDL::JntSpaceInertiaMatrix inertia(static_cast<int>(n));
    q.data = arm.axes;
    qd.data = arm.speeds;
    ASSERT_TRUE(peer.JntToMass(q, inertia) >= 0 && peer.JntToCoriolis(q, qd, coriolis) >= 0 &&
                peer.JntToGravity(q, weight) >= 0);
    const Terms ours = terms_of(arm, arm.axes, arm.speeds);
    mass = std::max(mass, (ours.terms.mass - inertia.data).cwiseAbs().maxCoeff());
    bias = std::max(bias, (ours.terms.bias - coriolis.data - weight.data).cwiseAbs().maxCoeff());
  }
  test::figure("mass matrix of chains against KDL, kg m2", mass, "1e-9");
  test::figure("Coriolis and weight of chains against KDL, N m", bias, "1e-9");
  EXPECT_LT(mass, 1e-9);
  EXPECT_LT(bias, 1e-9);
}

// The controller's kinematics and the simulator's are written apart: where they agree neither is wrong.
TEST(Dynamics, TheTipIsWhereTheControllerHasIt) {
  Random random(2);
  double tip_m = 0, jacobian = 0, force_point = 0;
  int cases = 0;
  for (int i = 0; i < 4000; ++i) {
    const SomeArm arm = some_arm(random, i % 4);
    const Terms ours = terms_of(arm, arm.axes, arm.speeds);
    const kinematics::Mechanism<double> mechanism(arm.geometry);
    kinematics::MechanismPose<double> pose = mechanism.home_pose();
    const Vector3d home_m = pose.plate_m + pose.chain.tip_m;
    if (!ours.closed || !mechanism.closes_at_home() || !mechanism.at(arm.axes, pose)) continue;
    if (pose.jacobian.norm() > 5) continue;  // near a singularity
    ++cases;
    const Eigen::Matrix3d R = arm.geometry.rotation.cast<double>();
    tip_m = std::max(tip_m, (R * (ours.terms.tip.at_m - home_m) - pose.tip_m).norm());
    jacobian =
        std::max(jacobian, (R * ours.terms.tip.by_joint - pose.jacobian.topRows(3)).cwiseAbs().maxCoeff());
    force_point = std::max(force_point,
                           (R * ours.terms.force_point.by_joint - pose.force_jacobian).cwiseAbs().maxCoeff());
  }
  test::figure("simulator's tip against the controller's, m", tip_m, "1e-9");
  test::figure("its Jacobian", std::max(jacobian, force_point), "1e-8");
  EXPECT_GT(cases, 3000);
  EXPECT_LT(tip_m, 1e-9);
  EXPECT_LT(jacobian, 1e-8);
  EXPECT_LT(force_point, 1e-8);
}

TEST(Dynamics, TheTipsAccelerationIsTheDerivativeOfItsVelocity) {
  constexpr double kStep_s = 1e-5;
  Random random(3);
  double worst = 0;
  for (int i = 0; i < 4000; ++i) {
    const SomeArm arm = some_arm(random, i % 4);
    const Terms now = terms_of(arm, arm.axes, arm.speeds);
    const Terms ahead = terms_of(arm, arm.axes + kStep_s * arm.speeds, arm.speeds);
    const Terms behind = terms_of(arm, arm.axes - kStep_s * arm.speeds, arm.speeds);
    if (!now.closed || !ahead.closed || !behind.closed || now.terms.tip.by_joint.norm() > 1) continue;
    const auto velocity = [&arm](const Terms& at) -> Vector3d { return at.terms.tip.by_joint * arm.speeds; };
    const Vector3d slope = (velocity(ahead) - velocity(behind)) / (2 * kStep_s);
    worst = std::max(worst, (slope - now.terms.tip.bias).norm() / (1 + now.terms.tip.bias.norm()));
  }
  test::figure("acceleration of the tip against differences, relative", worst, "1e-6");
  EXPECT_LT(worst, 1e-6);
}

// Runge-Kutta 4 without torques: what moves keeps kinetic and potential energy.
TEST(Dynamics, AFreeArmKeepsItsEnergy) {
  constexpr double kStep_s = 5e-5;
  Random random(4);
  double worst = 0;
  int arms = 0;
  for (int i = 0; i < 200; ++i) {
    SomeArm arm = some_arm(random, i % 4);
    const ArmDynamics dynamics(arm.geometry, arm.inertia);
    ArmFrames frames = frames_at_rest(arm.geometry);
    ArmTerms terms;
    bool closed = true;
    const auto acceleration = [&](const JointVector& a, const JointVector& ad) -> JointVector {
      closed = closed && dynamics.at(a, ad, frames, terms) && terms.tip.by_joint.norm() < 1;
      if (!closed) return JointVector::Zero(a.size());
      return terms.mass.llt().solve(-terms.bias);
    };
    const auto energy_J = [&](const JointVector& a, const JointVector& ad) {
      closed = closed && dynamics.at(a, ad, frames, terms);
      return closed ? 0.5 * ad.dot(terms.mass * ad) + terms.potential_J : 0.0;
    };
    JointVector a = arm.axes, ad = arm.speeds;
    const double before_J = energy_J(a, ad);
    double most_J = 0;
    for (int step = 0; closed && step < 1000; ++step) {
      const JointVector k1 = acceleration(a, ad), v2 = ad + 0.5 * kStep_s * k1;
      const JointVector k2 = acceleration(a + 0.5 * kStep_s * ad, v2), v3 = ad + 0.5 * kStep_s * k2;
      const JointVector k3 = acceleration(a + 0.5 * kStep_s * v2, v3), v4 = ad + kStep_s * k3;
      const JointVector k4 = acceleration(a + kStep_s * v3, v4);
      a += kStep_s / 6 * (ad + 2 * v2 + 2 * v3 + v4);
      ad += kStep_s / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
      most_J = std::max(most_J, 0.5 * ad.dot(terms.mass * ad));
    }
    const double after_J = energy_J(a, ad);
    if (!closed) continue;
    ++arms;
    worst = std::max(worst, std::abs(after_J - before_J) / most_J);
  }
  test::figure("arms that moved freely for 50 ms", arms, "> 80");
  test::figure("energy that one lost or gained, of its kinetic energy", worst, "1e-6");
  EXPECT_GT(arms, 80);
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace thimble::board
