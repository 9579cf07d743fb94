// Torques that hold the weight: against KDL for chains with couplings and tilted bases, and for closed mechanisms against differences of the potential
// energy, with centres of mass that are found another way.
#include "kinematics/gravity.h"

#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>

#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::kinematics {
namespace {

KDL::Vector peer(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Eigen::Matrix3f some_tilt(Random& random) {
  return Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix().cast<float>();
}

Geometry some_heavy_chain(Random& random) {
  Geometry geometry;
  geometry.chain.count = 1 + static_cast<int>(random.below(kMaxJoints));
  for (int k = 0; k < geometry.chain.count; ++k) {
    ChainJoint& joint = geometry.chain.joint.at(static_cast<std::size_t>(k));
    joint.kind = random.below(4) == 0 ? JointKind::kPrismatic : JointKind::kRevolute;
    joint.origin_m = (0.15 * random.in_box(Vector3d::Ones())).cast<float>();
    joint.axis = random.direction().cast<float>();
    for (int j = 0; j < geometry.chain.count; ++j)
      geometry.joints_per_axis(k, j) = static_cast<float>(random.uniform(-0.3, 0.3) + (j == k ? 1.0 : 0.0));
    if (random.below(4) == 0) continue;
    geometry.body.at(static_cast<std::size_t>(geometry.body_count++)) = {
        BodyLink::kChain, k, static_cast<float>(random.uniform(0.01, 1)),
        (0.1 * random.in_box(Vector3d::Ones())).cast<float>()};
  }
  geometry.rotation = some_tilt(random);
  return geometry;
}

// Each link carries the bodies behind its joint.
KDL::Chain heavy_peer(const Geometry& geometry) {
  KDL::Chain chain;
  for (int k = 0; k < geometry.chain.count; ++k) {
    const ChainJoint& joint = geometry.chain.joint.at(static_cast<std::size_t>(k));
    chain.addSegment(
        KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(peer(joint.origin_m.cast<double>()))));
    KDL::RigidBodyInertia inertia = KDL::RigidBodyInertia::Zero();
    for (int i = 0; i < geometry.body_count; ++i) {
      const Body& body = geometry.body.at(static_cast<std::size_t>(i));
      if (body.joint == k)
        inertia = inertia + KDL::RigidBodyInertia(static_cast<double>(body.mass_kg),
                                                  peer(body.centre_m.cast<double>()));
    }
    const auto kind = joint.kind == JointKind::kRevolute ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), peer(joint.axis.cast<double>()), kind),
                                  KDL::Frame(), inertia));
  }
  return chain;
}

TEST(Gravity, OfChainsIsAsKdlHasIt) {
  Random random(8);
  double worst = 0, largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const Geometry geometry = some_heavy_chain(random);
    const int n = geometry.chain.count;
    const Mechanism<double> arm(geometry);
    MechanismPose<double> pose = arm.home_pose();
    const AxisVector<double> axes = 2 * AxisVector<double>::Random(n);
    ASSERT_TRUE(arm.at(axes, pose));
    const AxisVector<double> torques = gravity_torques(arm, axes, pose);

    const Eigen::MatrixXd C = geometry.joints_per_axis.topLeftCorner(n, n).cast<double>();
    const Vector3d down =
        geometry.rotation.cast<double>().transpose() * Vector3d(0, 0, -static_cast<double>(kGravity_m_s2));
    const KDL::Chain chain = heavy_peer(geometry);
    KDL::ChainDynParam dynamics(chain, peer(down));
    KDL::JntArray q(static_cast<unsigned>(n)), held(static_cast<unsigned>(n));
    q.data = C * axes;
    ASSERT_GE(dynamics.JntToGravity(q, held), 0);
    worst = std::max(worst, (torques - C.transpose() * held.data).cwiseAbs().maxCoeff());
    largest = std::max(largest, torques.cwiseAbs().maxCoeff());
  }
  test::figure("gravity of chains against KDL, N m", worst, "1e-9");
  EXPECT_GT(largest, 1.0);
  EXPECT_LT(worst, 1e-9);
}

// Heights of the centres of mass of a closed mechanism, from its closed pose.
double energy_J(const Geometry& geometry, const AxisVector<double>& q, const Vector3d& plate_m) {
  const auto height = [&geometry](const Vector3d& at_m) {
    return (geometry.rotation.cast<double>() * at_m).z();
  };
  double energy = 0;
  for (int i = 0; i < geometry.body_count; ++i) {
    const Body& body = geometry.body.at(static_cast<std::size_t>(i));
    const double weight_N = static_cast<double>(body.mass_kg) * static_cast<double>(kGravity_m_s2);
    const Vector3d centre = body.centre_m.cast<double>();
    if (body.link == BodyLink::kPlate) energy += weight_N * height(plate_m);
    if (const auto* delta = std::get_if<DeltaGeometry>(&geometry.platform);
        delta != nullptr && body.link == BodyLink::kThighs) {
      for (int leg = 0; leg < 3; ++leg)
        energy +=
            weight_N * height(Eigen::AngleAxisd(
                                  static_cast<double>(delta->leg_angle_rad.at(static_cast<std::size_t>(leg))),
                                  Vector3d::UnitZ()) *
                              Eigen::AngleAxisd(-q[leg], Vector3d::UnitY()) * centre);
    }
    const auto* bars = std::get_if<FiveBarGeometry>(&geometry.platform);
    if (bars == nullptr) continue;
    const Eigen::AngleAxisd turn(q[body.joint], Vector3d::UnitZ());
    const Vector3d base(body.joint == 0 ? 0.0 : static_cast<double>(bars->base_distance_m), 0, 0);
    const Vector3d elbow =
        base +
        turn * Vector3d(static_cast<double>(bars->inner_m.at(static_cast<std::size_t>(body.joint))), 0, 0);
    const Vector3d out = plate_m - elbow;
    if (body.link == BodyLink::kInner) energy += weight_N * height(base + turn * centre);
    if (body.link == BodyLink::kOuter)
      energy += weight_N *
                height(elbow + Eigen::AngleAxisd(std::atan2(out.y(), out.x()), Vector3d::UnitZ()) * centre);
  }
  return energy;
}

void add_bodies(Random& random, Geometry& geometry) {
  const bool delta = std::holds_alternative<DeltaGeometry>(geometry.platform);
  for (const Body& kind : delta ? std::vector<Body>{{BodyLink::kPlate}, {BodyLink::kThighs}}
                                : std::vector<Body>{{BodyLink::kInner, 0},
                                                    {BodyLink::kInner, 1},
                                                    {BodyLink::kOuter, 0},
                                                    {BodyLink::kOuter, 1}}) {
    Body& body = geometry.body.at(static_cast<std::size_t>(geometry.body_count++));
    body = kind;
    body.mass_kg = static_cast<float>(random.uniform(0.01, 0.5));
    if (kind.link != BodyLink::kPlate) body.centre_m = (0.05 * random.in_box(Vector3d::Ones())).cast<float>();
    if (!delta) body.centre_m.z() = 0;
  }
  geometry.rotation = some_tilt(random);
}

TEST(Gravity, OfClosedMechanismsIsTheGradientOfTheirEnergy) {
  constexpr double kStep = 1e-6;
  Random random(9);
  double worst = 0;
  for (int i = 0; i < 2000; ++i) {
    Case one;
    Vector3d place_m;
    if (i % 2 == 0) {
      one = some_delta_case(random, place_m);
    } else if (!some_five_bar_case(random, one)) {
      continue;
    }
    add_bodies(random, one.geometry);
    const Mechanism<double> arm(one.geometry);
    MechanismPose<double> pose = arm.home_pose();
    if (!arm.at(one.axes, pose) || pose.plate_jacobian.norm() > 0.5) continue;
    const AxisVector<double> torques = gravity_torques(arm, one.axes, pose);
    for (int j = 0; j < arm.axes(); ++j) {
      const auto energy_at = [&](double step) {
        AxisVector<double> axes = one.axes;
        axes[j] += step;
        MechanismPose<double> moved = pose;
        EXPECT_TRUE(arm.at(axes, moved));
        return energy_J(one.geometry, axes, moved.plate_m);
      };
      worst = std::max(worst, std::abs(torques[j] - (energy_at(kStep) - energy_at(-kStep)) / (2 * kStep)));
    }
  }
  test::figure("gravity of closed mechanisms against differences of energy, N m", worst, "1e-8");
  EXPECT_LT(worst, 1e-8);
}

}  // namespace
}  // namespace thimble::kinematics
