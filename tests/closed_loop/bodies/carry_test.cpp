// A moving object carries the god object along and never passes through it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

constexpr int kThrongs = kUnderSanitizers ? 4 : 24;

double box_depth(const Vector3d& p, const Vector3d& half) { return (half - p.cwiseAbs()).minCoeff(); }

struct Solid {
  std::string shape;
  std::function<double(const Vector3d&)> depth;  // above 0 inside
};

std::vector<Solid> solids() {
  return {{R"("sphere": {"radius_m": 0.02})", [](const Vector3d& p) { return .02 - p.norm(); }},
          {R"("box": {"size_m": [0.04, 0.03, 0.02]})",
           [](const Vector3d& p) {
             return box_depth(p, {.02, .015, .01});
           }},
          {R"("cylinder": {"radius_m": 0.02, "height_m": 0.02})",
           [](const Vector3d& p) { return std::min(.02 - p.head<2>().norm(), .01 - std::abs(p.z())); }},
          {R"("capsule": {"radius_m": 0.01, "height_m": 0.03})",
           [](const Vector3d& p) {
             const Vector3d on_axis(0, 0, std::clamp(p.z(), -.015, .015));
             return .01 - (p - on_axis).norm();
           }},
          {R"("cone": {"radius_m": 0.015, "height_m": 0.03})", [](const Vector3d& p) {
             const double side = (.0225 - p.z() - 2.0 * p.head<2>().norm()) / std::sqrt(5.0);
             return std::min(side, p.z() + .0075);
           }}};
}

std::string number(double value) { return std::to_string(value); }

// A floor, a wall, and one of each solid on a spring, thrown about: by its start, by springs, by the finger.
std::string throng(Random& random, const std::string& motion, double friction) {
  std::string text = R"("gravity_m_s2": [0, 0, -2], "objects": [
    {"name": "floor", "material": "m", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.05}}},
    {"name": "wall", "material": "m", "shape": {"plane": {"normal": [-1, 0, 0.2], "offset_m": -0.05}}})";
  for (const Solid& solid : solids()) {
    const Vector3d at = random.in_box({.06, .06, .03});
    const Vector3d v = random.uniform(0, 10) * random.direction();
    const Vector3d w = random.uniform(0, 40) * random.direction();
    text += R"(, {"name": ")" + std::to_string(text.size()) + R"(", "material": "m", "shape": {)" +
            solid.shape + R"(}, "pose": {"position_m": )" + list(at) + R"(}, "body": {"motion": ")" + motion +
            R"(", "mass_kg": 0.05, "spring_N_m": )" + number(random.uniform(5, 400)) +
            R"(, "velocity_m_s": )" + list(v) + (motion == "free" ? R"(, "spin_rad_s": )" + list(w) : "") +
            "}}";
  }
  return text + R"(], "materials": {"m": {"stiffness_N_m": 1000, "damping_N_s_m": 1, "static_friction": )" +
         number(friction) + "}}";
}

TEST(Carry, NoMovingBodyGetsPastAFingertip) {
  double deepest = -1;
  long touched = 0;
  long ticks = 0;
  double fastest = 0;
  const std::vector<Solid> shapes = solids();
  for (int scene = 0; scene < kThrongs; ++scene) {
    Random random(static_cast<std::uint64_t>(100 + scene));
    BodyRun run(throng(random, scene % 2 == 0 ? "free" : "translate", scene % 4 < 2 ? 0.0 : .6),
                {{-.1, -.1, .1}, {-.1, .1, .1}});
    std::vector<Vector3d> tips = run.tips();
    std::vector<Vector3d> targets = tips;
    for (int tick = 0; tick < 5000; ++tick) {
      for (std::size_t i = 0; i < tips.size(); ++i) {
        if (random.below(100) == 0) targets[i] = random.in_box({.08, .08, .06});
        const Vector3d way = targets[i] - tips[i];
        tips[i] +=
            std::min(1.0, 2.5e-4 / std::max(way.norm(), 1e-9)) * way + 2e-6 * random.in_box(Vector3d::Ones());
      }
      run.tick(tips);
      ++ticks;
      for (std::size_t i = 0; i < tips.size(); ++i) {
        ASSERT_TRUE(run.force_N(i).allFinite()) << scene << " " << tick;
        touched += run.contacts(i) > 0 ? 1 : 0;
        deepest = std::max(deepest, -.05 - run.god_m(i).z());
        for (std::size_t k = 0; k < shapes.size(); ++k) {
          const control::BodyState& body = run.before(k);
          fastest = std::max(fastest, static_cast<double>(body.velocity_m_s.norm()));
          const Vector3d local =
              body.rotation.cast<double>().conjugate() * (run.god_m(i) - body.position_m.cast<double>());
          const double depth = shapes[k].depth(local);
          deepest = std::max(deepest, depth);
          ASSERT_LT(depth, 1e-6) << "scene " << scene << " tick " << tick << " finger " << i << " body " << k;
        }
      }
    }
  }
  figure("no tunnel: god object's deepest in any body or floor, um", 1e6 * deepest, "< 1");
  figure("no tunnel: finger ticks in contact, %",
         50.0 * static_cast<double>(touched) / static_cast<double>(ticks), "> 5");
  figure("no tunnel: fastest body, m/s", fastest, "> 5");
  EXPECT_LT(deepest, 1e-6);
  EXPECT_GT(10 * touched, ticks);
  EXPECT_GT(fastest, 5);
}

TEST(Carry, AThinPlateNeverChangesTheSideOfAFinger) {
  // 0.2 mm thick, 200 mm wide: at 10 m/s it goes 2.5 mm a tick.
  for (const double speed : {.1, 1.0, 10.0}) {
    for (const double friction : {0.0, .5}) {
      BodyRun run(
          R"("objects": [{"name": "plate", "shape": {"box": {"size_m": [0.3, 0.3, 0.0002]}}, "pose": {"position_m": [0, 0, -0.02]},
        "material": {"stiffness_N_m": 500, "static_friction": )" +
              number(friction) + R"(},
        "body": {"motion": "free", "mass_kg": 0.2, "spring_N_m": 300, "velocity_m_s": [0, 0, )" +
              number(speed) + R"(], "spin_rad_s": [)" + number(speed) + R"(, 0, 0]}}])",
          {{0, 0, .001}});
      Random random(7);
      Vector3d tip(0, 0, .001);
      Vector3d target = tip;
      int changes = 0;
      bool was_over = false;
      double last_z = 1;
      int met = 0;
      for (int tick = 0; tick < 6000; ++tick) {
        if (tick % 400 == 0) target = random.in_box({.03, .03, .03});
        tip += std::min(1.0, 1e-4 / std::max((target - tip).norm(), 1e-9)) * (target - tip);
        run.tick({tip});
        met += run.contacts(0);
        const Vector3d local = run.before(0).rotation.cast<double>().conjugate() *
                               (run.god_m(0) - run.before(0).position_m.cast<double>());
        // Flung beyond the rim it may come back on either side.
        const bool over = local.cwiseAbs().head<2>().maxCoeff() < .149;
        if (over && was_over && std::signbit(local.z()) != std::signbit(last_z)) ++changes;
        if (over && std::abs(local.z()) < 1e-4 - 1e-6) ++changes;
        was_over = over;
        last_z = local.z();
      }
      figure("plate started at " + number(speed) + " m/s, friction " + number(friction) +
                 ": ticks on the wrong side",
             changes, "0");
      EXPECT_EQ(changes, 0);
      EXPECT_GT(met, 100);
    }
  }
}

TEST(Carry, FrictionDragsAFingerAlongAndItDragsABlock) {
  // A block on rails goes by under a fingertip that presses on it: the god object goes with it until friction
  // gives way.
  BodyRun run(
      R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.1, 0.1, 0.02]}}, "pose": {"position_m": [0, 0, -0.01]},
      "material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4},
      "body": {"motion": "slide", "axis": [1, 0, 0], "mass_kg": 100, "velocity_m_s": [0.02, 0, 0]}}])",
      {{0, 0, -.002}});
  run.tick({{0, 0, .001}});
  run.tick({{0, 0, -.002}});
  // Pressed by 2 mm it sticks up to 1 mm: 50 ms at 20 mm/s.
  run.run(.045);
  figure("drag after 45 ms at 20 mm/s: stretch, mm", 1e3 * run.god_m(0).x(), "0.9");
  figure("drag after 45 ms: sideways force, N", run.force_N(0).x(), "0.9");
  EXPECT_NEAR(run.god_m(0).x(), .9e-3, 1e-5);
  EXPECT_NEAR(run.force_N(0).x(), .9, .01);
  double most = 0;
  double least = 1;
  for (int tick = 0; tick < 2000; ++tick) {
    run.tick();
    most = std::max(most, run.force_N(0).x());
    least = std::min(least, run.force_N(0).x());
  }
  figure("stick-slip under a moving block: most, N", most, "1.0 = mu_s K d");
  figure("stick-slip under a moving block: least, N", least, "0.8 = mu_d K d");
  EXPECT_NEAR(most, 1.0, .02);
  EXPECT_NEAR(least, .8, .02);
}

TEST(Carry, AStuckFingerDoesNotCreepOverATumblingBody) {
  // Pressed into a turning ball at its centre: the god object is to stay where it is on the ball.
  BodyRun run(R"("objects": [{"name": "ball", "shape": {"sphere": {"radius_m": 0.03}},
      "material": {"stiffness_N_m": 100, "static_friction": 10},
      "body": {"motion": "turn", "axis": [3, 7, 5], "mass_kg": 100, "spin_rad_s": [3, 7, 5]}}])",
              {{0, 0, .031}});
  run.tick({{0, 0, .031}});
  run.tick({{0, 0, 0}});
  run.tick();
  const auto local = [&] {
    return Vector3d(run.before(0).rotation.cast<double>().conjugate() *
                    (run.god_m(0) - run.before(0).position_m.cast<double>()));
  };
  const Vector3d at = local();
  run.run(5.0);
  figure("5 s on a tumbling ball: creep over its surface, um", 1e6 * (local() - at).norm(), "< 1");
  EXPECT_LT((local() - at).norm(), 1e-6);
}

TEST(Carry, ABodyStopsRatherThanSqueezeAFingerThrough) {
  // A heavy block comes down on a finger that lies on the floor.
  BodyRun run(R"("gravity_m_s2": [0, 0, -9.81], "objects": [
      {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 1000}},
      {"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}}, "pose": {"position_m": [0, 0, 0.05]},
       "material": {"stiffness_N_m": 1000}, "body": {"motion": "translate", "mass_kg": 0.5}}])",
              {{0, 0, -.001}});
  run.tick({{0, 0, .001}});
  run.tick({{0, 0, -.001}});
  run.run(1.0);
  figure("a block on a finger on the floor: its lower side, um", 1e6 * (run.position_m(0).z() - .02),
         ">= -0.2");
  figure("the finger's god object, um", 1e6 * run.god_m(0).z(), ">= -0.2");
  EXPECT_GT(run.position_m(0).z(), .02 - 1e-6);
  EXPECT_GT(run.god_m(0).z(), -1e-6);
  EXPECT_LT(run.position_m(0).z(), .0225);
}

}  // namespace
}  // namespace thimble::test
