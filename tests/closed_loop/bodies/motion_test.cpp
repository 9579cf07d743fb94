// Masses that a fingertip pushes: Newton's laws in numbers.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

// A block of m kg on nothing, pushed from the left.
std::string block(const std::string& motion, double mass_kg, const std::string& more = "") {
  return R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}},
    "material": {"stiffness_N_m": 1000, "damping_N_s_m": 15, "static_friction": 0.5},
    "body": {"motion": ")" +
         motion + R"(", "mass_kg": )" + std::to_string(mass_kg) + more + "}}]";
}

TEST(Motion, ForceIsMassTimesAccelerationAtTheTip) {
  for (const std::string motion : {"free", "translate", "plane", "slide"}) {
    for (const double mass : {.05, .2, 1.0}) {
      BodyRun run(block(motion, mass, motion == "slide" ? R"(, "axis": [1, 0, 0])" : ""), {{-.021, 0, 0}});
      constexpr double kAcceleration = .5;
      while (run.time_s() < .8) {
        run.tick({{-.02 + .5 * kAcceleration * run.time_s() * run.time_s(), 0, 0}});
      }
      const double felt = -run.force_N(0).x();
      figure(motion + ", " + std::to_string(mass) + " kg pushed at 0.5 m/s2: felt, N", felt,
             std::to_string(mass * kAcceleration) + ", 1 %");
      EXPECT_NEAR(felt, mass * kAcceleration, .01 * mass * kAcceleration);
    }
  }
}

TEST(Motion, TheBodyGetsExactlyWhatTheHandsDoNot) {
  // Two fingers that wrestle with a free block and a spinning one: momentum of the blocks = impulse of the hands, angular too.
  // With friction the fingertips exert a moment about their normals too, up to mu F_n 3.3 mm, which a hand at a point
  // does not feel.
  for (const double friction : {0.0, .6}) {
    BodyRun run(R"("objects": [
    {"name": "a", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}}, "pose": {"position_m": [0, 0, 0]}, "material": "m",
     "body": {"motion": "free", "mass_kg": 0.3}}],
    "materials": {"m": {"stiffness_N_m": 800, "damping_N_s_m": 2, "static_friction": )" +
                    std::to_string(friction) + R"(, "dynamic_friction": )" + std::to_string(friction / 1.5) +
                    "}}",
                {{-.03, .005, 0}, {.03, -.008, .004}});
    Vector3d impulse = Vector3d::Zero();
    Vector3d angular = Vector3d::Zero();
    double pushed = 0;
    const Vector3d inertia = Vector3d::Constant(.3 * .04 * .04 / 6);
    double worst = 0;
    double worst_angular = 0;
    double moment = 0;  // of the fingertips, times the time
    for (int tick = 0; tick < 8000; ++tick) {
      const double t = run.time_s();
      const double squeeze = std::min(.012, .03 * t);
      run.tick(
          {{-.03 + squeeze + .004 * std::sin(9 * t), .005 + .01 * std::sin(5 * t), .01 * std::sin(3 * t)},
           {.03 - squeeze + .004 * std::sin(8 * t), -.008, .004 + .006 * std::sin(4 * t)}});
      for (std::size_t i = 0; i < 2; ++i) {
        impulse -= run.period_s() * run.force_N(i);
        angular -= run.period_s() * run.god_m(i).cross(run.force_N(i));
        moment += run.period_s() * friction * run.force_N(i).norm() * 3.3e-3;
        pushed += run.period_s() * run.force_N(i).norm();
      }
      const Vector3d momentum = .3 * run.velocity_m_s(0);
      const Vector3d spin =
          inertia.cwiseProduct(run.body(0).spin_rad_s.cast<double>()) + run.position_m(0).cross(momentum);
      worst = std::max(worst, (momentum - impulse).norm());
      worst_angular = std::max(worst_angular, (spin - angular).norm());
    }
    figure("two hands on a block: impulse given, N s", pushed, "> 1");
    figure("momentum less impulse, N s", worst, "< 2e-5");
    const double most_angular = 2e-6 + moment;
    figure("friction " + std::to_string(friction) + ": angular momentum less its impulse, N m s",
           worst_angular, "< " + std::to_string(most_angular));
    EXPECT_GT(pushed, 1);
    EXPECT_LT(worst, 2e-5);
    EXPECT_LT(worst_angular, most_angular);
  }
}

TEST(Motion, AThrownBlockFliesAParabola) {
  BodyRun run(R"("gravity_m_s2": [0, 0, -9.81], )" + block("free", .1, R"(, "velocity_m_s": [0.8, 0.3, 2])"));
  run.run(.4);
  const double t = run.time_s();
  const Vector3d expected(.8 * t, .3 * t, 2 * t - .5 * 9.81 * t * t);
  figure("parabola after 0.4 s: error, mm", 1e3 * (run.position_m(0) - expected).norm(),
         "< 0.6, g t T / 2 = 0.49");
  EXPECT_LT((run.position_m(0) - expected).norm(), 6e-4);
}

TEST(Motion, AFreeTopKeepsItsAngularMomentum) {
  const Vector3d inertia(.8e-4, 1.0e-4, 1.5e-4);
  const Vector3d spin(20, 1, 12);  // not about a principal axis: it tumbles
  BodyRun run(block("free", .1, R"(, "inertia_kg_m2": [0.8e-4, 1.0e-4, 1.5e-4], "spin_rad_s": [20, 1, 12])"));
  const Vector3d momentum = inertia.cwiseProduct(spin);
  const double energy = .5 * spin.dot(momentum);
  double worst = 0;
  double worst_energy = 0;
  double turned = 0;
  for (int tick = 0; tick < 40000; ++tick) {
    run.tick({});
    const Eigen::Quaterniond q = run.rotation(0);
    const Vector3d local = q.conjugate() * run.body(0).spin_rad_s.cast<double>();
    const Vector3d now = q * inertia.cwiseProduct(local).eval();
    worst = std::max(worst, (now - momentum).norm() / momentum.norm());
    worst_energy = std::max(worst_energy, std::abs(.5 * local.dot(inertia.cwiseProduct(local)) / energy - 1));
    turned = std::max(turned, (local - spin).norm() / spin.norm());
  }
  figure("free top, 10 s: angular momentum, relative", worst, "< 1e-3");
  figure("free top, 10 s: energy, relative", worst_energy, "< 1e-3");
  figure("free top, 10 s: its spin turns in its own frame, relative", turned, "> 0.2: it does tumble");
  EXPECT_LT(worst, 1e-3);
  EXPECT_LT(worst_energy, 1e-3);
  EXPECT_GT(turned, .2);
}

TEST(Motion, SpringAndDamperToGround) {
  // m x'' + B x' + K x = 0 from a start with speed v.
  BodyRun run(
      block("slide", .2,
            R"(, "axis": [0, 1, 0], "spring_N_m": 50, "damping_N_s_m": 0.4, "velocity_m_s": [0, 0.3, 0])"));
  const double w0 = std::sqrt(50 / .2);
  const double d = .4 / (2 * .2);
  const double w = std::sqrt(w0 * w0 - d * d);
  double worst = 0;
  while (run.time_s() < 1.0) {
    run.tick({});
    const double expected = .3 / w * std::exp(-d * run.time_s()) * std::sin(w * run.time_s());
    worst = std::max(worst, std::abs(run.position_m(0).y() - expected));
  }
  figure("spring and damper, 1 s: worst error, mm of 18", 1e3 * worst, "< 0.1");
  EXPECT_LT(worst, 1e-4);
}

TEST(Motion, ATurningKnobHasTheInertiaOfItsShape) {
  // Pushed at its rim by a constant force: angle = F r t^2 / (2 I), I = m r^2 / 2.
  BodyRun run(R"("objects": [{"name": "knob", "shape": {"cylinder": {"radius_m": 0.02, "height_m": 0.02}},
     "material": {"stiffness_N_m": 500}, "body": {"motion": "turn", "axis": [0, 0, 2], "mass_kg": 0.5, "spin_rad_s": [0, 0, 1], "angular_damping_N_m_s": 1e-4}}])");
  run.run(1.0);
  const double inertia = .5 * .5 * .02 * .02;
  const double expected = std::exp(-1e-4 / inertia);
  figure("knob left to its damping for 1 s: spin, rad/s", static_cast<double>(run.body(0).spin_rad_s.z()),
         std::to_string(expected) + ", 0.1 %");
  EXPECT_NEAR(static_cast<double>(run.body(0).spin_rad_s.z()), expected, 1e-3 * expected);
  const double angle = Eigen::AngleAxisd(run.rotation(0)).angle();
  EXPECT_NEAR(angle, inertia / 1e-4 * (1 - expected), 1e-3);
}

// Fifteen balls far away that never rest: with little work, a step of the bodies takes several ticks.
std::string far_away() {
  std::string others;
  for (int i = 0; i < 15; ++i)
    others +=
        R"(, {"name": ")" + std::to_string(i) +
        R"(", "shape": {"sphere": {"radius_m": 0.01}}, "pose": {"position_m": [0, 1, )" +
        std::to_string(.03 * i) +
        R"(]}, "material": {"stiffness_N_m": 1000}, "body": {"motion": "free", "mass_kg": 1, "velocity_m_s": [0, 0.001, 0]}})";
  return others;
}

TEST(Motion, APassiveBodyNeverGivesTheHandEnergy) {
  // Work of the hand on a block at rest, against the block's energy: kinetic, and what the contact's spring holds. Also where a step
  // takes several ticks, because there are others, far away.
  struct Case {
    std::string motion;
    double damping;
    std::uint32_t units;
  };
  std::vector<Case> cases;
  for (const std::string motion : {"free", "translate"})
    for (const double damping : {0.0, 3.0})
      for (const std::uint32_t units : {control::Work::kNoBound, 300U, 100U})
        cases.push_back({motion, damping, units});
  for (const auto& [motion, damping, units] : cases) {
    BodyRun run(R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}},
      "material": {"stiffness_N_m": 1000, "damping_N_s_m": )" +
                    std::to_string(damping) + R"(, "static_friction": 0.6, "dynamic_friction": 0.4},
      "body": {"motion": ")" +
                    motion + R"(", "mass_kg": 0.1}})" + far_away() + "]",
                {{-.025, .004, 0}});
    run.bound_work(units);
    int steps = 0;
    double work = 0;
    double least = 0;
    double balance = 0;
    double most = 0;
    Vector3d force = Vector3d::Zero();
    for (int tick = 0; tick < 12000; ++tick) {
      const double t = run.time_s();
      const Vector3d tip(-.025 + .02 * std::sin(6 * t) + .03 * t, .004 + .004 * std::sin(11 * t),
                         .003 * std::sin(7 * t));
      const Vector3d from = run.tips()[0];
      run.tick({tip});
      work -= .5 * (force + run.force_N(0)).dot(tip - from);
      force = run.force_N(0);
      steps += run.renderer().bodies_wait() ? 0 : 1;
      const Vector3d spin = run.body(0).spin_rad_s.cast<double>();
      const double kinetic =
          .5 * .1 * run.velocity_m_s(0).squaredNorm() + .5 * (.1 * .04 * .04 / 6) * spin.squaredNorm();
      const double stored = .5 * 1000 * (run.god_m(0) - tip).squaredNorm();
      most = std::max(most, kinetic);
      least = std::min(least, work);
      balance = std::max(balance, kinetic + stored - work);
    }
    figure(motion + ": ticks a step", 12000.0 / steps, "");
    figure(motion + ", B " + std::to_string(damping) + ": energy of the block, most, mJ", 1e3 * most, "> 1");
    figure(motion + ": block and spring above the hand's work, mJ", 1e3 * balance, "< 3 % of it");
    figure(motion + ": the hand's least work, mJ", 1e3 * least, "> -3 %");
    EXPECT_GT(most, 1e-3);
    EXPECT_LT(balance, .03 * most);
    EXPECT_GT(least, -.03 * most);
  }
}

// A step of several ticks: a hand that pushes in its first tick only has let go when the block moves, and must not have given it momentum.
TEST(Motion, AHandThatHasLetGoPushesNoMore) {
  BodyRun run(
      R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}}, "material": {"stiffness_N_m": 1000},
        "body": {"motion": "translate", "mass_kg": 0.05}})" +
          far_away() + "]",
      {{-.021, 0, 0}});
  run.bound_work(150);
  int pushes = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    const bool begins = !run.renderer().bodies_wait();
    run.tick({Vector3d(begins ? -.019 : -.021, 0, 0)});
    if (begins && run.force_N(0).norm() > .5 && run.renderer().bodies_wait()) ++pushes;
  }
  figure("pushes in the first tick of a step", pushes, "> 400");
  figure("speed of the block, mm/s", 1e3 * run.velocity_m_s(0).norm(), "0");
  EXPECT_GT(pushes, 400);
  EXPECT_LT(run.velocity_m_s(0).norm(), 1e-6);
}

// Along with the block, however slow its clock: its damper does not pull at a hand.
TEST(Motion, AHandThatGoesWithABodyFeelsNoDamper) {
  for (const std::uint32_t units : {control::Work::kNoBound, 400U, 150U}) {
    BodyRun run(
        R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}}, "material": {"stiffness_N_m": 1000,
        "damping_N_s_m": 5}, "body": {"motion": "translate", "mass_kg": 100, "velocity_m_s": [0.05, 0, 0]}})" +
            far_away() + "]",
        {{-.021, 0, 0}});
    run.bound_work(units);
    Vector3d tip = run.tips()[0];
    for (int i = 0; i < 20; ++i) run.tick({tip += Vector3d(1e-4, 0, 0)});
    double force_N = 0;
    double spring_N = 0;
    for (int tick = 0; tick < 2000; ++tick) {
      // As fast as the block in the mean of the last ten ticks or so, and 1 mm deep.
      tip.x() += .1 * (run.position_m(0).x() - .019 - tip.x());
      run.tick({tip});
      if (tick < 1000) continue;
      force_N += run.force_N(0).norm() / 1000;
      spring_N += 1000 * (run.god_m(0) - tip).norm() / 1000;
    }
    figure(std::to_string(units) + " units: force beside the spring's, N", force_N - spring_N, "0, 5e-3");
    EXPECT_NEAR(force_N, spring_N, 5e-3);
  }
}

}  // namespace
}  // namespace thimble::test
