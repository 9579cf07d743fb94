// Torques that hold the weight: against KDL for chains with couplings and tilted bases, and for closed mechanisms against differences of the potential
// energy, with centres of mass that are found another way. Then of whole arms of every family whose bases are mounted at a tilt.
#include "kinematics/gravity.h"

#include <gtest/gtest.h>

#include <kdl/chain.hpp>
#include <kdl/chaindynparam.hpp>
#include <vector>

#include "kinematics/arm.h"
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
double energy_J(const Geometry& geometry, const Eigen::Matrix3d& R_WB, const AxisVector<double>& q,
                const Vector3d& plate_m) {
  const auto height = [&R_WB](const Vector3d& at_m) { return (R_WB * at_m).z(); };
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
        return energy_J(one.geometry, one.geometry.rotation.cast<double>(), axes, moved.plate_m);
      };
      worst = std::max(worst, std::abs(torques[j] - (energy_at(kStep) - energy_at(-kStep)) / (2 * kStep)));
    }
  }
  test::figure("gravity of closed mechanisms against differences of energy, N m", worst, "1e-8");
  EXPECT_LT(worst, 1e-8);
}

// Where a mass is on a two-link arm: on its upper link or its forearm, or at the crank that drives the forearm from the shoulder.
struct LinkMass {
  enum class On : std::uint8_t { kUpperLink, kForearm, kCrank } on;
  double mass_kg, from_joint_m;  // behind the joint where it is negative: a counterweight
};

// What the arm and its masses are made of, apart from its ArmData.
struct HeavyArm {
  ArmData data;
  BasePose base;
  std::vector<LinkMass> masses;
  AxisVector<double> axes;
  [[nodiscard]] Eigen::Matrix3d R_WB() const {
    return base.rotation.cast<double>() * data.geometry.rotation.cast<double>();
  }
};

// Their coefficients, as kinematics/arm_data.h defines them for a level base.
void add_link_masses(Random& random, HeavyArm& arm) {
  const TwoLinkGeometry links{0.05F, 0.2F, 0.17F};
  arm.data.geometry.platform = links;
  arm.data.has_inertia = true;
  double g2 = 0, g3 = 0;
  for (const LinkMass::On on : {LinkMass::On::kUpperLink, LinkMass::On::kForearm, LinkMass::On::kCrank}) {
    const LinkMass mass{on, random.uniform(0.1, 1), random.uniform(-0.2, 0.2)};
    arm.masses.push_back(mass);
    const double weight_N = mass.mass_kg * static_cast<double>(kGravity_m_s2);
    (on == LinkMass::On::kUpperLink ? g2 : g3) += weight_N * mass.from_joint_m;
    if (on == LinkMass::On::kForearm) g2 += weight_N * static_cast<double>(links.upper_link_m);
  }
  arm.data.inertia.g2 = static_cast<float>(g2);
  arm.data.inertia.g3 = static_cast<float>(g3);
}

// family 0: chain, 1: two-link, 2: two-link with a wrist and a coupling, 3: five-bar, 4: delta.
HeavyArm some_heavy_arm(Random& random, int family) {
  HeavyArm arm;
  Geometry& geometry = arm.data.geometry;
  if (family == 0) geometry = some_heavy_chain(random);
  if (family == 1 || family == 2) {
    if (family == 2) {
      const Geometry wrist = some_heavy_chain(random);
      geometry.chain.count = std::min(wrist.chain.count, kMaxJoints - 3);
      geometry.chain.joint = wrist.chain.joint;
      for (int i = 0; i < wrist.body_count; ++i)
        if (const Body& body = wrist.body.at(static_cast<std::size_t>(i)); body.joint < geometry.chain.count)
          geometry.body.at(static_cast<std::size_t>(geometry.body_count++)) = body;
      geometry.joints_per_axis = wrist.joints_per_axis;
      for (int k = 0; k < kMaxJoints; ++k)
        if (geometry.joints_per_axis(k, k) == 0) geometry.joints_per_axis(k, k) = 1;
    }
    add_link_masses(random, arm);
  }
  if (family < 3) arm.axes = 1.5 * AxisVector<double>::Random(axes_of(geometry));
  if (family >= 3) {
    Case one;
    Vector3d place_m;
    if (family == 4) one = some_delta_case(random, place_m);
    while (family == 3 && !some_five_bar_case(random, one)) {
    }
    add_bodies(random, one.geometry);
    geometry = one.geometry;
    arm.axes = one.axes;
  }
  geometry.driven.fill(true);
  geometry.rotation = random.below(3) == 0 ? Eigen::Matrix3f::Identity() : some_tilt(random);
  if (random.below(4) != 0) arm.base.rotation = some_tilt(random);  // otherwise often level
  arm.base.home_m = random.in_box(Vector3d::Ones()).cast<float>();
  return arm;
}

// Of all masses, by their heights in the world.
double energy_of(const HeavyArm& arm, const AxisVector<double>& axes, const Vector3d& closed_plate_m) {
  const Geometry& geometry = arm.data.geometry;
  const int n = axes_of(geometry);
  const AxisVector<double> q = geometry.joints_per_axis.topLeftCorner(n, n).cast<double>() * axes;
  const Eigen::Matrix3d R_WB = arm.R_WB();
  const auto g = static_cast<double>(kGravity_m_s2);
  double energy = 0;
  Eigen::Isometry3d place = Eigen::Isometry3d::Identity();  // of the link, in the base frame
  int first = 0;
  if (const auto* links = std::get_if<TwoLinkGeometry>(&geometry.platform)) {
    const Eigen::AngleAxisd yaw(q[0], Vector3d::UnitZ());
    const Vector3d upper = yaw * Vector3d(std::cos(q[1]), 0, std::sin(q[1]));
    const Vector3d fore = yaw * Vector3d(std::sin(q[2]), 0, -std::cos(q[2]));
    const Vector3d shoulder(0, 0, static_cast<double>(links->base_height_m));
    const Vector3d elbow = shoulder + static_cast<double>(links->upper_link_m) * upper;
    for (const LinkMass& mass : arm.masses) {
      const Vector3d& joint = mass.on == LinkMass::On::kForearm ? elbow : shoulder;
      const Vector3d& along = mass.on == LinkMass::On::kUpperLink ? upper : fore;
      energy += mass.mass_kg * g * (R_WB * (joint + mass.from_joint_m * along)).z();
    }
    place.translation() = elbow + static_cast<double>(links->forearm_m) * fore;
    first = 3;
  } else if (geometry.platform.index() != 0) {
    return energy_J(geometry, R_WB, q, closed_plate_m);
  }
  for (int k = 0; k < geometry.chain.count; ++k) {
    const ChainJoint& joint = geometry.chain.joint.at(static_cast<std::size_t>(k));
    place.translate(Vector3d(joint.origin_m.cast<double>()));
    const Vector3d axis = joint.axis.cast<double>();
    if (joint.kind == JointKind::kRevolute) place.rotate(Eigen::AngleAxisd(q[first + k], axis));
    if (joint.kind == JointKind::kPrismatic) place.translate(Vector3d(q[first + k] * axis));
    for (int i = 0; i < geometry.body_count; ++i)
      if (const Body& body = geometry.body.at(static_cast<std::size_t>(i)); body.joint == k)
        energy += static_cast<double>(body.mass_kg) * g *
                  (R_WB * (place * Vector3d(body.centre_m.cast<double>()))).z();
  }
  return energy;
}

// The torques that the firmware adds, against what the weight of the same masses does in the world.
TEST(Gravity, OfAMountedArmIsTheGradientOfItsEnergyInTheWorld) {
  constexpr double kStep = 1e-5;
  Random random(10);
  std::array<double, 5> worst{}, largest{};
  double worst_in_float = 0;
  int level = 0;
  for (int i = 0; i < 5000; ++i) {
    const auto family = static_cast<std::size_t>(i % 5);
    const HeavyArm heavy = some_heavy_arm(random, static_cast<int>(family));
    const Arm<double> arm(heavy.data, heavy.base);
    const int n = arm.axes();
    ASSERT_EQ(arm.is_two_link(), family == 1);
    PerAxis<double> axes = PerAxis<double>::Zero();
    axes.head(n) = heavy.axes;
    Posture<double> posture = arm.home_posture();
    arm.move_to(axes, posture);
    if (!posture.tip_m.allFinite() || posture.jacobian.norm() > 5) continue;  // singular
    level += family == 1 && heavy.R_WB().isIdentity();
    const PerAxis<double> torques = arm.gravity_torques(posture);
    for (int j = 0; j < n; ++j) {
      const auto energy_at = [&](double step) {
        PerAxis<double> moved_axes = axes;
        moved_axes[j] += step;
        Posture<double> moved = posture;
        arm.move_to(moved_axes, moved);
        return energy_of(heavy, moved_axes.head(n), moved.plate_m);
      };
      const double by_energy = (energy_at(kStep) - energy_at(-kStep)) / (2 * kStep);
      worst.at(family) = std::max(worst.at(family), std::abs(torques[j] - by_energy));
      largest.at(family) = std::max(largest.at(family), std::abs(by_energy));
    }
    const Arm<float> in_float(heavy.data, heavy.base);  // as in the tick
    Posture<float> near = in_float.home_posture();
    in_float.move_to(axes.cast<float>(), near);
    if (near.tip_m.allFinite() && posture.jacobian.norm() < 1)
      worst_in_float =
          std::max(worst_in_float,
                   (in_float.gravity_torques(near).cast<double>() - torques).head(n).cwiseAbs().maxCoeff());
  }
  constexpr std::array kFamilies{"chain", "two-link", "two-link with a wrist", "five-bar", "delta"};
  for (std::size_t family = 0; family < kFamilies.size(); ++family) {
    test::figure(std::string("weight of a mounted ") + kFamilies.at(family) + " against its energy, N m",
                 worst.at(family), "1e-5: its axes are in float");
    EXPECT_GT(largest.at(family), 0.1) << kFamilies.at(family);
    EXPECT_LT(worst.at(family), 1e-5) << kFamilies.at(family);
  }
  test::figure("weight in float against double, N m", worst_in_float, "1e-3");
  EXPECT_LT(worst_in_float, 1e-3);
  EXPECT_GT(level, 10);
}

}  // namespace
}  // namespace thimble::kinematics
