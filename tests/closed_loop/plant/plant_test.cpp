// The simulated arm against closed forms and conservation laws.
#include "board/sim/plant.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <vector>

#include "board/sim/hand_path.h"
#include "kinematics/built_in_arms.h"
#include "kinematics/dynamics.h"
#include "kinematics/workspace.h"

namespace thimble::board {
namespace {

constexpr double kTick_s = 1.0 / 4000.0;

PlantParameters variant(const char* name) {
  const PlantVariant* found = find_plant_variant(name);
  EXPECT_NE(found, nullptr) << name;
  return PlantParameters::from(*found);
}

TEST(Plant, VariantsByName) {
  for (const char* name : {"premium-1.5", "premium-1.5-frictionless", "wooden"}) {
    const PlantParameters p = variant(name);
    ASSERT_EQ(kinematics::name_of(p.model), find_plant_variant(name)->arm);
    const Plant plant(p);
    EXPECT_LT(plant.tip_m().norm(), 1e-7) << "home is the origin";
  }
  EXPECT_GT(variant("premium-1.5").coulomb_N_m.minCoeff(), 0);
  EXPECT_EQ(variant("premium-1.5-frictionless").coulomb_N_m, Vector3d::Zero());
  EXPECT_EQ(variant("premium-1.5-frictionless").viscous_N_m_s_rad, Vector3d::Zero());
  EXPECT_EQ(find_plant_variant("premium"), nullptr);
}

// Links, rotors and undamped cables, thrown and left alone.
TEST(Plant, AFreeFrictionlessArmKeepsItsEnergy) {
  PlantParameters p = variant("premium-1.5-frictionless");
  p.cable_damping_N_m_s_rad.setZero();
  Plant plant(p);
  plant.place({.1, .1, .02}, {2.0, .5, -.2});
  const double start = plant.energy_J();
  const double kinetic =
      start - kinematics::gravity_energy(p.model.inertia,
                                         kinematics::TwoLinkArm<double>(p.model).at(plant.joints_rad()));
  double worst = 0;
  for (int k = 0; k < 800; ++k) {
    plant.step(kTick_s);
    ASSERT_EQ(kinematics::workspace_limit(p.model, plant.joints_rad()), 0) << "hit a stop";
    worst = std::max(worst, std::abs(plant.energy_J() - start));
  }
  std::printf("energy drift in 0.2 s: %.3g of %.3g J\n", worst, kinetic);
  EXPECT_LT(worst, 1e-6 * kinetic);
}

// The same with a hand of mass and spring, no damper.
TEST(Plant, AnUndampedHandKeepsTheEnergyToo) {
  PlantParameters p = variant("premium-1.5-frictionless");
  p.cable_damping_N_m_s_rad.setZero();
  Plant plant(p, {.1, 300, 0});
  plant.set_hand_target({.03, -.02, .02}, Vector3d::Zero());
  const double start = plant.energy_J();
  double worst = 0;
  for (int k = 0; k < 4000; ++k) {
    plant.step(kTick_s);
    worst = std::max(worst, std::abs(plant.energy_J() - start));
  }
  std::printf("energy drift in 1 s: %.3g J of %.3g J\n", worst, .5 * 300 * .0017);
  EXPECT_LT(worst, 1e-5);
}

TEST(Plant, ForceOnTheHandIsNewtonsThirdLaw) {
  // A hand that only holds (no mass): what the arm exerts on it is the motors' force, at rest.
  PlantParameters p = variant("premium-1.5-frictionless");
  Plant plant(p, {0, 2000, 20});
  const kinematics::TwoLinkArm<double> arm(p.model);
  const kinematics::TwoLinkPosture<double> posture = arm.at(arm.home());
  const Vector3d wanted(1.0, -.5, .7);
  Vector3d current;
  const Vector3d torque =
      posture.jacobian.transpose() * wanted + kinematics::gravity_torques(p.model.inertia, posture);
  for (int j = 0; j < 3; ++j)
    current[j] =
        torque[j] / static_cast<double>(p.model.axis[static_cast<std::size_t>(j)].torque_per_ampere());
  plant.command_current(current, true);
  plant.step(1.0);
  std::printf("force on the hand: %.4f %.4f %.4f N\n", plant.hand_force_N().x(), plant.hand_force_N().y(),
              plant.hand_force_N().z());
  EXPECT_LT((plant.hand_force_N() - wanted).norm(),
            .01);  // the tip gave way by half a millimetre, so gravity changed
}

TEST(Motor, VoltageStepIsTheClosedForm) {
  const kinematics::MotorModel m = kinematics::built_in_arm("premium-1.5").axis[0].motor;
  const double R = static_cast<double>(m.resistance_ohm), L = static_cast<double>(m.inductance_H);
  Motor motor;
  const double h = 25e-6;
  double worst = 0;
  for (int k = 1; k <= 40; ++k) {
    motor.step_winding(m, 12.0, 0.0, h);
    const double exact = 12.0 / R * (1 - std::exp(-R / L * k * h));
    worst = std::max(worst, std::abs(motor.current_A - exact));
  }
  std::printf("locked motor, 12 V step: worst error %.3g A of %.3g A\n", worst, 12 / R);
  EXPECT_LT(worst, 1e-5);
  EXPECT_NEAR(motor.current_A, 12 / R, 1e-3);  // nine time constants later
}

TEST(Motor, BackEmfLimitsTheSpeed) {
  const kinematics::MotorModel m = kinematics::built_in_arm("premium-1.5").axis[0].motor;
  Motor motor;
  const double no_load_rad_s = 12.0 / static_cast<double>(m.torque_constant_N_m_A);
  for (int k = 0; k < 200; ++k) motor.step_winding(m, 12.0, no_load_rad_s, 25e-6);
  EXPECT_NEAR(motor.current_A, 0, 1e-9);
}

// Two nodes at constant current: the copper's resistance grows linearly with its temperature, so the system
// stays linear,
//   d/dt (T_w, T_h) = A (T_w, T_h) + b,
// and its matrix exponential is the closed form.
TEST(Motor, HeatIsTheClosedForm) {
  const kinematics::MotorModel m = kinematics::built_in_arm("premium-1.5").axis[0].motor;
  const double current = 1.24, ambient = 25, alpha = .00393;
  const double R = static_cast<double>(m.resistance_ohm), r1 = static_cast<double>(m.winding_to_housing_K_W),
               r2 = static_cast<double>(m.housing_to_ambient_K_W);
  const double c1 = static_cast<double>(m.winding_time_constant_s) / r1,
               c2 = static_cast<double>(m.housing_time_constant_s) / r2;
  Eigen::Matrix2d A;
  const double heat = current * current * R;
  A << (heat * alpha - 1 / r1) / c1, 1 / (r1 * c1), 1 / (r1 * c2), -(1 / r1 + 1 / r2) / c2;
  const Eigen::Vector2d b(heat * (1 - alpha * 25) / c1, ambient / (r2 * c2));
  const Eigen::Vector2d settled = -A.inverse() * b;
  // exp(A t) = e^(mean t) (cosh(q t) I + sinh(q t) / q (A - mean I)): Cayley and Hamilton, for two nodes.
  const double mean = A.trace() / 2, q = std::sqrt(mean * mean - A.determinant());
  Motor motor;
  const double h = 1e-3;
  double worst = 0;
  for (int second = 1; second <= 1000; ++second) {
    for (int k = 0; k < 1000; ++k) {
      motor.current_A = current;
      motor.step_heat(m, ambient, h);
    }
    const Eigen::Vector2d from = Eigen::Vector2d(25, 25) - settled;
    const Eigen::Vector2d exact =
        settled + std::exp(mean * second) *
                      (std::cosh(q * second) * from + std::sinh(q * second) / q * (A * from - mean * from));
    worst = std::max({worst, std::abs(motor.winding_C - exact[0]), std::abs(motor.housing_C - exact[1])});
  }
  std::printf("1.24 A for 1000 s: winding %.2f C (settles at %.1f C), worst error %.3g K\n", motor.winding_C,
              settled[0], worst);
  EXPECT_LT(worst, .01);
  EXPECT_NEAR(settled[0], 100, 3);  // the rated current is what brings the winding to its limit
}

TEST(Plant, SupplyLimitsTheCurrentOfARunningMotor) {
  PlantParameters p = variant("premium-1.5-frictionless");
  Plant plant(p);
  // Joint 1 turns so fast that back-EMF eats most of the supply.
  const double speed = 70;
  plant.place({0, 0, 0}, {speed, 0, 0});
  plant.command_current({5, 0, 0}, true);
  plant.step(5e-4);
  const kinematics::MotorModel& m = p.model.axis[0].motor;
  const double limit = (static_cast<double>(p.model.supply_V) -
                        static_cast<double>(m.torque_constant_N_m_A) * 13.3 * plant.joint_speeds_rad_s()[0]) /
                       static_cast<double>(m.resistance_ohm);
  std::printf("asked 5 A at %.0f rad/s: %.3f A, supply allows %.3f A\n", speed, plant.motors()[0].current_A,
              limit);
  EXPECT_LT(plant.motors()[0].current_A, limit + .05);
  EXPECT_LT(limit, 4.0);
  plant.place({0, 0, 0});
  plant.command_current({50, 0, 0}, true);
  plant.step(2e-4);
  EXPECT_LE(plant.motors()[0].current_A, static_cast<double>(m.peak_current_A));
}

TEST(Plant, OpenMotorsCarryNothing) {
  Plant plant(variant("premium-1.5"));
  plant.command_current({3, 3, 3}, true);
  plant.step(kTick_s);
  EXPECT_GT(plant.motors()[1].current_A, 1);
  plant.command_current({3, 3, 3}, false);
  plant.step(kTick_s);
  for (const Motor& motor : plant.motors()) EXPECT_EQ(motor.current_A, 0);
}

TEST(Plant, CoulombFrictionHoldsAndLetsGo) {
  const PlantParameters p = variant("premium-1.5");
  const double coulomb = p.coulomb_N_m[0];
  for (const double part : {.5, .98}) {
    Plant plant(p);
    plant.command_current({part * coulomb / static_cast<double>(p.model.axis[0].torque_per_ampere()), 0, 0},
                          true);
    plant.step(1.0);
    EXPECT_EQ(plant.rotors_rad()[0], 0.0) << "crept under " << part << " of its friction";
  }
  Plant plant(p);
  plant.command_current({1.02 * coulomb / static_cast<double>(p.model.axis[0].torque_per_ampere()), 0, 0},
                        true);
  plant.step(1.0);
  std::printf("joint 1 under 1.02 of its friction: %.3g rad in 1 s\n", plant.rotors_rad()[0]);
  EXPECT_GT(plant.rotors_rad()[0], .01);
}

// A coasting joint loses energy to friction as the closed form says: speed falls by coulomb / inertia per
// second.
TEST(Plant, CoulombFrictionBrakesLinearly) {
  PlantParameters p = variant("premium-1.5-frictionless");
  p.coulomb_N_m[0] = .01;
  Plant plant(p);
  plant.place({0, 0, 0}, {1, 0, 0});
  const kinematics::TwoLinkArm<double> arm(p.model);
  // Gravity is carried, so that joints 2 and 3 stay; the inertia then stays too.
  const Vector3d gravity = kinematics::gravity_torques(p.model.inertia, arm.at(Vector3d::Zero()));
  plant.command_current({0, gravity[1] / static_cast<double>(p.model.axis[1].torque_per_ampere()),
                         gravity[2] / static_cast<double>(p.model.axis[2].torque_per_ampere())},
                        true);
  plant.step(.05);
  const double inertia = kinematics::mass_matrix(p.model.inertia, arm.at(Vector3d::Zero()))(0, 0) +
                         static_cast<double>(p.model.axis[0].reflected_rotor_inertia());
  const double expected = 1 - .01 * .05 / inertia;
  std::printf("joint 1 after 50 ms of friction: %.5f rad/s, expected %.5f\n", plant.joint_speeds_rad_s()[0],
              expected);
  EXPECT_NEAR(plant.joint_speeds_rad_s()[0], expected, .01 * (1 - expected));
}

// Motors locked by friction, tip plucked: each axis rings at sqrt(k / m) / 2 pi.
TEST(Plant, StructuralResonance) {
  PlantParameters p = variant("premium-1.5");
  p.coulomb_N_m.setConstant(100);  // locked
  const kinematics::TwoLinkArm<double> arm(p.model);
  const Eigen::Matrix3d M = kinematics::mass_matrix(p.model.inertia, arm.at(Vector3d::Zero()));
  const char* axis[] = {"sideways", "up", "out"};
  for (int j = 0; j < 3; ++j) {
    Plant plant(p);
    Vector3d q = Vector3d::Zero();
    plant.place(q, .05 * Vector3d::Unit(j));
    // place() sets rotors moving too; the lock stops them at once.
    std::vector<double> crossings;
    double before = plant.joint_speeds_rad_s()[j];
    const double h = 1e-4;
    for (int k = 1; k < 4000 && crossings.size() < 9; ++k) {
      plant.step(h);
      const double now = plant.joint_speeds_rad_s()[j];
      if (before > 0 && now <= 0) crossings.push_back(h * (k - now / (now - before)));
      before = now;
    }
    ASSERT_GE(crossings.size(), 4U);
    const double frequency =
        static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
    const double expected = std::sqrt(p.cable_stiffness_N_m_rad[j] / M(j, j)) / (2 * M_PI);
    std::printf("resonance %s: %.2f Hz, expected %.2f Hz\n", axis[j], frequency, expected);
    EXPECT_NEAR(frequency, expected, .01 * expected);
  }
}

TEST(Plant, StructuralStiffnessAtTheTip) {
  PlantParameters p = variant("premium-1.5");
  p.coulomb_N_m.setConstant(100);
  Plant still(p);
  still.step(2.0);
  for (int axis = 0; axis < 3; ++axis) {
    Plant plant(p);
    plant.push(Vector3d::Unit(axis));
    plant.step(2.0);
    const double yield = (plant.tip_m() - still.tip_m())[axis];
    std::printf("tip stiffness along axis %d: %.0f N/m\n", axis, 1 / yield);
    EXPECT_NEAR(1 / yield, 3500, 35);
  }
}

TEST(Plant, EncodersQuantiseAndSeedsDiffer) {
  PlantParameters p = variant("premium-1.5");
  Plant plant(p);
  const auto home = plant.encoder_counts();
  for (const std::uint32_t c : home) EXPECT_LE(c, 0xFFFFU);
  plant.place({.1, -.2, .3});
  const auto there = plant.encoder_counts();
  const double moved[] = {.1, -.2, .3};
  for (std::size_t j = 0; j < 3; ++j) {
    const auto counts = static_cast<std::int16_t>(static_cast<std::uint16_t>(there[j] - home[j]));
    EXPECT_NEAR(counts, moved[j] / static_cast<double>(p.model.axis[j].rad_per_count()), 1.0);
  }
  p.seed = 2;
  EXPECT_NE(Plant(p).encoder_counts(), home);
  EXPECT_EQ(Plant(variant("premium-1.5")).encoder_counts(), home);
}

TEST(Plant, StopsHoldAFallingArm) {
  Plant plant(variant("premium-1.5"));
  plant.push({0, 0, -3});
  plant.step(3.0);
  const double over = .1;  // the rubber gives
  const kinematics::ArmData& m = plant.parameters().model;
  EXPECT_LT(plant.joints_rad()[2] - plant.joints_rad()[1], static_cast<double>(-m.sum[0].lower) + over);
  EXPECT_GT(plant.joints_rad()[1], static_cast<double>(m.axis[1].lower) - over);
  EXPECT_LT(plant.joint_speeds_rad_s().norm(), 1e-2);
}

TEST(Plant, DeterministicToTheBitAndFasterThanRealTime) {
  const auto run = [](std::uint64_t seed) {
    PlantParameters p = variant("premium-1.5");
    p.seed = seed;
    Plant plant(p, Hand{});
    std::vector<unsigned char> bytes;
    for (int k = 0; k < 8000; ++k) {
      const double t = k * kTick_s;
      plant.set_hand_target({.02 * std::sin(7 * t), .01 * std::cos(3 * t), .02 * std::sin(t)},
                            Vector3d::Zero());
      plant.command_current({.5 * std::sin(40 * t), -.3, .2 * std::cos(90 * t)}, true);
      plant.step(kTick_s);
      const Vector3d tip = plant.tip_m();
      const auto counts = plant.encoder_counts();
      const auto* a = reinterpret_cast<const unsigned char*>(tip.data());
      bytes.insert(bytes.end(), a, a + 3 * sizeof(double));
      const auto* b = reinterpret_cast<const unsigned char*>(counts.data());
      bytes.insert(bytes.end(), b, b + 3 * sizeof(std::uint32_t));
    }
    return bytes;
  };
  const auto begin = std::chrono::steady_clock::now();
  const auto first = run(7);
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("2 s of arm in %.3f s\n", wall);
  EXPECT_EQ(first, run(7));
  EXPECT_NE(first, run(8));  // the encoders stand elsewhere
}

TEST(HandPath, LinesBetweenPoints) {
  const HandPath path({{1, {0, 0, 0}, 0}, {2, {.1, 0, 0}, 0}, {4, {.1, .4, 0}, 0}});
  EXPECT_EQ(path.at(0).position_m, Vector3d(0, 0, 0));
  EXPECT_EQ(path.at(0).velocity_m_s, Vector3d(0, 0, 0));
  EXPECT_NEAR((path.at(1.5).position_m - Vector3d(.05, 0, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((path.at(1).velocity_m_s - Vector3d(.1, 0, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((path.at(2).velocity_m_s - Vector3d(0, .2, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((path.at(4).velocity_m_s - Vector3d(0, .2, 0)).norm(), 0, 1e-15);
  EXPECT_NEAR((path.at(4).position_m - Vector3d(.1, .4, 0)).norm(), 0, 1e-15);
  EXPECT_EQ(path.at(5).velocity_m_s, Vector3d(0, 0, 0));
  EXPECT_THROW(HandPath({}), std::invalid_argument);
  EXPECT_THROW(HandPath({{1, {0, 0, 0}, 0}, {1, {0, 0, 0}, 0}}), std::invalid_argument);
  EXPECT_THROW(HandPath({{1, {std::numeric_limits<double>::quiet_NaN(), 0, 0}, 0}}), std::invalid_argument);
}

}  // namespace
}  // namespace thimble::board
