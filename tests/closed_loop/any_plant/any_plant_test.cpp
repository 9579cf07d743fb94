// The simulated arm of any family: against the simulated two-link arm, against MuJoCo, and against conservation of energy, for every arm that
// comes with Thimble.
#include "board/sim/any_plant.h"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::board {
namespace {

constexpr double kTick_s = 1.0 / 4000;

host::ArmFile arm_named(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return host::read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

AnyPlantParameters parameters_of(const std::string& name) {
  const host::ArmFile file = arm_named(name);
  return AnyPlantParameters::from(host::arm_data(file), file.body_inertia_kg_m2);
}

// Motors, cables, friction, stops, counters, a hand that moves and pushes: everything that the two have, for a second.
TEST(AnyPlant, IsTheTwoLinkPlant) {
  for (const char* name : {"premium-1.5", "premium-1.5-frictionless"}) {
    const PlantParameters old = PlantParameters::from(*find_plant_variant(name));
    AnyPlantParameters given = parameters_of("premium-1.5");
    for (std::size_t j = 0; j < 3; ++j) {
      const auto i = static_cast<Eigen::Index>(j);
      given.axis[j].coulomb_N_m = old.coulomb_N_m[i];
      given.axis[j].viscous_N_m_s_rad = old.viscous_N_m_s_rad[i];
      EXPECT_NEAR(given.axis[j].stiffness_N_m_rad, old.cable_stiffness_N_m_rad[i], 1e-5);
      EXPECT_NEAR(given.axis[j].damping_N_m_s_rad, old.cable_damping_N_m_s_rad[i], 1e-6);
      given.axis[j].stiffness_N_m_rad = old.cable_stiffness_N_m_rad[i];
      given.axis[j].damping_N_m_s_rad = old.cable_damping_N_m_s_rad[i];
    }
    const Hand hand{.05, 300, 3};
    Plant one(old, hand);
    AnyPlant other(given, hand);
    double joints = 0, tip_m = 0, current_A = 0, force_N = 0, energy_J = 0, moved_m = 0;
    long counts = 0;
    for (int tick = 0; tick < 4000; ++tick) {
      const double t = kTick_s * tick;
      const Vector3d current(std::sin(9 * t), .7 * std::sin(17 * t + 1), .8 * std::sin(13 * t + 2));
      one.command_current(current, tick < 3800);
      other.command_current(JointVector(current), tick < 3800);
      one.set_hand_target({.05 * std::sin(5 * t), .04 * std::sin(4 * t), .06 * std::sin(3 * t)},
                          Vector3d::Zero());
      other.set_hand_target({.05 * std::sin(5 * t), .04 * std::sin(4 * t), .06 * std::sin(3 * t)},
                            Vector3d::Zero());
      const Vector3d push(tick > 3000 && tick < 3200 ? 4.0 : 0.0, 0, 0);
      one.push(push);
      other.push(push);
      one.step(kTick_s);
      other.step(kTick_s);
      joints = std::max({joints, (Vector3d(other.joints_rad()) - one.joints_rad()).norm(),
                         (Vector3d(other.rotors_rad()) - one.rotors_rad()).norm()});
      tip_m = std::max(tip_m, (other.tip_m() - one.tip_m()).norm());
      moved_m = std::max(moved_m, one.tip_m().norm());
      current_A = std::max(current_A, std::abs(other.motors()[1].current_A - one.motors()[1].current_A));
      force_N = std::max(force_N, (other.hand_force_N() - one.hand_force_N()).norm());
      energy_J = std::max(energy_J, std::abs(other.energy_J() - one.energy_J()));
      for (std::size_t j = 0; j < 3; ++j)
        counts += other.encoder_counts().at(j) != one.encoder_counts().at(j);
    }
    const std::string of = std::string(" of ") + name;
    test::figure("way of the tip" + of + ", m", moved_m, "> 0.03");
    test::figure("tip, m", tip_m, "1e-6");
    test::figure("joints and rotors, rad", joints, "1e-6");
    test::figure("current, A; force on the hand, N; energy, J", std::max({current_A, force_N, energy_J}),
                 "1e-5");
    EXPECT_TRUE(one.joints_rad().allFinite() && other.joints_rad().allFinite())
        << "the largest difference below leaves out what is not a number";
    EXPECT_GT(moved_m, .03);
    EXPECT_LT(tip_m, 1e-6);
    EXPECT_LT(joints, 1e-6);
    EXPECT_LT(current_A, 1e-5);
    EXPECT_LT(force_N, 1e-5);
    EXPECT_LT(energy_J, 1e-5);
    EXPECT_LE(counts, 3) << "counts that differ by one at their edge";
  }
}

class AnyArm : public testing::TestWithParam<const char*> {};

TEST_P(AnyArm, StartsAtHomeAndKeepsItsEnergy) {
  AnyPlantParameters p = parameters_of(GetParam());
  for (AxisTruth& axis : p.axis) {
    axis.coulomb_N_m = axis.viscous_N_m_s_rad = axis.damping_N_m_s_rad = 0;
    axis.lower = -20;  // no stops, which damp
    axis.upper = 20;
  }
  p.sum.clear();
  AnyPlant plant(p, {.1, 300, 0});
  EXPECT_LT(plant.tip_m().norm(), 1e-12);
  plant.set_hand_target({.02, -.01, .01}, Vector3d::Zero());
  const double start_J = plant.energy_J();
  double drift_J = 0, moving_J = 0;
  for (int k = 0; k < 1200; ++k) {
    plant.step(kTick_s);
    drift_J = std::max(drift_J, std::abs(plant.energy_J() - start_J));
    const JointVector& qd = plant.joint_speeds_rad_s();
    moving_J = std::max(moving_J, .5 * qd.dot(plant.mass_matrix() * qd));
  }
  ASSERT_TRUE(plant.closed());
  ASSERT_TRUE(plant.joints_rad().allFinite());
  test::figure(std::string("energy that ") + GetParam() + " lost or gained, of its kinetic energy",
               drift_J / moving_J, "1e-5");
  EXPECT_GT(moving_J, 1e-4);
  EXPECT_LT(drift_J, 1e-5 * moving_J);
}

// A steady current against a hand that holds: what it feels is the force that the torques were meant for.
TEST_P(AnyArm, PressesTheHandWithWhatItsMotorsGive) {
  AnyPlantParameters p = parameters_of(GetParam());
  JointVector driven = JointVector::Zero(static_cast<Eigen::Index>(p.axis.size()));
  for (std::size_t j = 0; j < p.axis.size(); ++j) {
    p.axis[j].coulomb_N_m = 0;
    driven[static_cast<Eigen::Index>(j)] = p.axis[j].driven ? 1 : 0;
  }
  if (driven.sum() > 3) return;  // of a redundant arm the hand does not feel all
  AnyPlant plant(p, {0, 4000, 40});
  const JointVector sensed = JointVector::Ones(plant.axes()) - driven;
  plant.set_grip(plant.joints_rad(), JointVector::Zero(plant.axes()), 20 * sensed, .01 * sensed);
  plant.step(1);
  const Vector3d before_N = plant.hand_force_N();
  const ByJoint J = plant.force_jacobian() * driven.asDiagonal();
  Vector3d wanted_N = J * JointVector(driven.cwiseProduct(JointVector::LinSpaced(plant.axes(), 1, 2)));
  wanted_N *= .2 / wanted_N.norm();
  JointVector current_A = J.transpose() * wanted_N;
  for (Eigen::Index j = 0; j < plant.axes(); ++j) {
    const AxisTruth& axis = p.axis[static_cast<std::size_t>(j)];
    if (axis.driven) current_A[j] /= axis.turns * static_cast<double>(axis.motor.torque_constant_N_m_A);
  }
  plant.command_current(current_A, true);
  plant.step(1);
  EXPECT_LT((plant.hand_force_N() - before_N - wanted_N).norm(), .005)
      << (plant.hand_force_N() - before_N).transpose() << " instead of " << wanted_N.transpose();
}

INSTANTIATE_TEST_SUITE_P(Arms, AnyArm,
                         testing::Values("premium-1.5", "wooden", "touch", "falcon", "pantograph", "paddle",
                                         "chain-7"),
                         [](const auto& arm) {
                           std::string name = arm.param;
                           std::erase_if(name, [](char c) { return std::isalnum(c) == 0; });
                           return name;
                         });

TEST(AnyPlant, AnOpenMotorShowsItsSpeedAndNoCurrent) {
  const AnyPlantParameters p = parameters_of("premium-1.5");
  AnyPlant plant(p);
  plant.set_open(0, true);
  plant.command_current(JointVector::Constant(3, .5), true);
  plant.step(.002);
  EXPECT_EQ(plant.motors()[0].current_A, 0);
  EXPECT_DOUBLE_EQ(plant.motor_voltage_V(0), 24);
  EXPECT_NEAR(plant.motors()[1].current_A, .5, .01);
  EXPECT_LT(std::abs(plant.motor_voltage_V(1)), 3);
  plant.place(JointVector::Zero(3), JointVector::Constant(3, 2));
  plant.command_current(JointVector::Zero(3), false);
  plant.step(kTick_s);
  const double emf_V = plant.rotor_speeds_rad_s()[0] * p.axis[0].turns *
                       static_cast<double>(p.axis[0].motor.torque_constant_N_m_A);
  EXPECT_NEAR(plant.motor_voltage_V(0), emf_V, .02 * emf_V);
}

// A grip holds the links where it is told, against gravity, and lets go.
TEST(AnyPlant, AGripTurnsOneAxis) {
  AnyPlant plant(parameters_of("premium-1.5"));
  plant.set_grip(JointVector::Zero(3), JointVector(Vector3d(0, .5, 0)), JointVector::Constant(3, 20),
                 JointVector::Constant(3, .2));
  plant.step(1);
  EXPECT_NEAR(plant.joints_rad()[1], .5, .02);
  EXPECT_NEAR(plant.joints_rad()[0], 0, 1e-3);
  EXPECT_NEAR(plant.joints_rad()[2], 0, .01);
}

// Three links, their rotors as bodies of their own, cables as tendons: MuJoCo integrates the same equations.
TEST(AnyPlant, IsAsMuJoCoHasAChainWithElasticTransmissions) {
  test::Random random(3);
  double worst = 0, moved = 0;
  for (int arms = 0; arms < 5; ++arms) {
    AnyPlantParameters p;
    p.geometry.chain.count = p.geometry.chain.force_joint = p.geometry.body_count = 3;
    std::array<std::string, 3> inertial;
    std::string rotors, tendons, open, close;
    for (std::size_t j = 0; j < 3; ++j) {
      kinematics::ChainJoint& joint = p.geometry.chain.joint.at(j);
      joint.origin_m = (.1 * random.in_box(Vector3d::Ones())).cast<float>();
      joint.axis = random.direction().cast<float>();
      kinematics::Body& body = p.geometry.body.at(j);
      body = {kinematics::BodyLink::kChain, static_cast<int>(j), static_cast<float>(random.uniform(.05, .2)),
              (.05 * random.in_box(Vector3d::Ones())).cast<float>()};
      p.body_kg_m2.at(j) = {2e-4, 3e-4, 4e-4};
      AxisTruth axis;
      axis.driven = true;
      axis.lower = -50;
      axis.upper = 50;
      axis.viscous_N_m_s_rad = .002;
      axis.stiffness_N_m_rad = random.uniform(5, 20);
      axis.damping_N_m_s_rad = .003;
      axis.rotor_kg_m2 = 1.5e-4;
      axis.turns = 10;
      axis.motor = kinematics::built_in_arm("premium-1.5").axis[0].motor;
      p.axis.push_back(axis);
      std::array<char, 1000> buffer{};
      const auto at = [](const Eigen::Vector3f& v, int i) { return static_cast<double>(v[i]); };
      std::snprintf(buffer.data(), buffer.size(),
                    R"(<body pos="%.17g %.17g %.17g"><joint name="q%zu" axis="%.17g %.17g %.17g"/>
<inertial pos="%.17g %.17g %.17g" mass="%.17g" diaginertia="2e-4 3e-4 4e-4"/>)",
                    at(joint.origin_m, 0), at(joint.origin_m, 1), at(joint.origin_m, 2), j, at(joint.axis, 0),
                    at(joint.axis, 1), at(joint.axis, 2), at(body.centre_m, 0), at(body.centre_m, 1),
                    at(body.centre_m, 2), static_cast<double>(body.mass_kg));
      open += buffer.data();
      close += "</body>";
      std::snprintf(buffer.data(), buffer.size(),
                    R"(<body><joint name="r%zu" axis="0 0 1" damping=".002"/>
<inertial pos="0 0 0" mass="1" diaginertia="1.5e-4 1.5e-4 1.5e-4"/></body>)",
                    j);
      rotors += buffer.data();
      std::snprintf(buffer.data(), buffer.size(),
                    R"(<fixed stiffness="%.17g" damping=".003" springlength="0">
<joint joint="r%zu" coef="1"/><joint joint="q%zu" coef="-1"/></fixed>)",
                    axis.stiffness_N_m_rad, j, j);
      tendons += buffer.data();
    }
    p.sum.clear();
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "any_plant.xml";
    std::ofstream(file) << R"(<mujoco><compiler angle="radian" balanceinertia="false"/>
<option gravity="0 0 -9.8100004196166992" timestep="2.5e-5" integrator="RK4"/><worldbody>)"
                        << open << close << rotors << "</worldbody><tendon>" << tendons
                        << "</tendon></mujoco>";
    std::array<char, 1000> error{};
    mjModel* model = mj_loadXML(file.c_str(), nullptr, error.data(), static_cast<int>(error.size()));
    ASSERT_NE(model, nullptr) << error.data();
    mjData* data = mj_makeData(model);
    AnyPlant plant(p);
    const JointVector speeds = JointVector(random.in_box(Vector3d::Constant(2)));
    plant.place(JointVector::Zero(3), speeds);
    for (int j = 0; j < 3; ++j) data->qvel[j] = data->qvel[3 + j] = speeds[j];
    for (int k = 0; k < 12000; ++k) mj_step(model, data);
    plant.step(.3);
    ASSERT_TRUE(plant.joints_rad().allFinite());
    for (int j = 0; j < 3; ++j) {
      worst = std::max({worst, std::abs(data->qpos[j] - plant.joints_rad()[j]),
                        std::abs(data->qpos[3 + j] - plant.rotors_rad()[j])});
      moved = std::max(moved, std::abs(data->qpos[j]));
    }
    mj_deleteData(data);
    mj_deleteModel(model);
  }
  test::figure("way of a joint, rad", moved, "> 0.5");
  test::figure("joints and rotors against MuJoCo after 0.3 s, rad", worst, "1e-6");
  EXPECT_GT(moved, .5);
  EXPECT_LT(worst, 1e-6);
}

}  // namespace
}  // namespace thimble::board
