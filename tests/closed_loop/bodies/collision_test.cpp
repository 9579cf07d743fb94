// Collisions of bodies with each other and with fixed objects: impacts, stacks, slopes.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

std::string puck(const std::string& name, double x, double y, double mass, const std::string& velocity,
                 double restitution, double friction = 0) {
  return R"({"name": ")" + name +
         R"(", "shape": {"cylinder": {"radius_m": 0.015, "height_m": 0.01}}, "pose": {"position_m": [)" +
         std::to_string(x) + ", " + std::to_string(y) +
         R"(, 0]}, "material": {"stiffness_N_m": 1000, "static_friction": )" + std::to_string(friction) +
         R"(}, "body": {"motion": "plane", "mass_kg": )" + std::to_string(mass) + R"(, "velocity_m_s": )" +
         velocity + R"(, "restitution": )" + std::to_string(restitution) + "}}";
}

TEST(Collision, TwoPucksKeepTheirMomentumAndTheEnergyOfTheirRestitution) {
  struct Case {
    double mass, restitution, offset;
  };
  for (const Case c : {Case{.1, 1, 0}, Case{.3, 1, 0}, Case{.1, .5, 0}, Case{.2, 0, 0}, Case{.1, 1, .01},
                       Case{.4, .7, .02}}) {
    BodyRun run("\"objects\": [" + puck("a", -.05, 0, .1, "[0.6, 0, 0]", c.restitution) + "," +
                puck("b", 0, c.offset, c.mass, "[0, 0, 0]", 0) + "]");
    run.run(.2);
    const Vector3d momentum = .1 * run.velocity_m_s(0) + c.mass * run.velocity_m_s(1);
    const double energy =
        .05 * run.velocity_m_s(0).squaredNorm() + .5 * c.mass * run.velocity_m_s(1).squaredNorm();
    // Along the line between the centres at impact: the speed of separation is e times that of approach.
    const double sine = c.offset / .03;
    const double along = .6 * std::sqrt(1 - sine * sine);
    const double reduced = .1 * c.mass / (.1 + c.mass);
    const double expected = .05 * .36 - .5 * reduced * (1 - c.restitution * c.restitution) * along * along;
    const std::string what = "pucks of 0.1 and " + std::to_string(c.mass) + " kg, e " +
                             std::to_string(c.restitution) + ", offset " + std::to_string(c.offset);
    figure(what + ": momentum, N s", (momentum - Vector3d(.06, 0, 0)).norm(), "0, 1e-7");
    figure(what + ": energy, mJ", 1e3 * energy, std::to_string(1e3 * expected) + ", 0.5 %");
    EXPECT_LT((momentum - Vector3d(.06, 0, 0)).norm(), 1e-7);
    EXPECT_NEAR(energy, expected, .005 * expected);
    // The one that was hit leaves along that line, for nothing rubs.
    EXPECT_NEAR(run.velocity_m_s(1).y() / run.velocity_m_s(1).x(), sine / std::sqrt(1 - sine * sine), .02);
  }
}

TEST(Collision, ABlockBouncesWithItsRestitution) {
  for (const std::string motion : {"translate", "free"}) {
    for (const double e : {.3, .6, .9}) {
      BodyRun run(R"("gravity_m_s2": [0, 0, -9.81], "objects": [
        {"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": {"stiffness_N_m": 1000}},
        {"name": "block", "shape": {"box": {"size_m": [0.03, 0.03, 0.03]}}, "pose": {"position_m": [0, 0, 0.115]},
         "material": {"stiffness_N_m": 1000}, "body": {"motion": ")" +
                  motion + R"(", "mass_kg": 0.1, "restitution": )" + std::to_string(e) +
                  R"(, "velocity_m_s": [0.2, 0, 0]}}])");
      double highest = 0;
      bool landed = false;
      while (run.time_s() < .14 + 2 * e * .142) {
        run.tick();
        landed = landed || run.velocity_m_s(0).z() > 0;
        if (landed) highest = std::max(highest, run.position_m(0).z() - .015);
      }
      figure(motion + " block, e " + std::to_string(e) + ": rebound over fall", highest / .1,
             std::to_string(e * e) + ", 2 %");
      figure(motion + " block: speed along, m/s", run.velocity_m_s(0).x(), "0.2");
      EXPECT_NEAR(highest / .1, e * e, .02 * e * e + .002);
      EXPECT_NEAR(run.velocity_m_s(0).x(), .2, 1e-5);
    }
  }
}

TEST(Collision, AStackOfThreeStands) {
  constexpr int kStood_s = kUnderSanitizers ? 2 : 10;
  for (const std::string motion : {"translate", "free"}) {
    std::string text =
        R"("gravity_m_s2": [0, 0, -9.81], "materials": {"wood": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}},
      "objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": "wood"})";
    for (int i = 0; i < 3; ++i) {
      // A little off each other, and dropped by half a millimetre.
      text += R"(, {"name": "block )" + std::to_string(i) +
              R"(", "shape": {"box": {"size_m": [0.03, 0.03, 0.03]}}, "pose": {"position_m": [)" +
              std::to_string(.003 * (i % 2)) + ", " + std::to_string(-.002 * i) + ", " +
              std::to_string(.0155 + .0305 * i) + R"(]}, "material": "wood", "body": {"motion": ")" + motion +
              R"(", "mass_kg": 0.1}})";
    }
    BodyRun run(text + "]");
    run.run(.5);
    std::vector<Vector3d> at;
    for (std::size_t i = 0; i < 3; ++i) at.push_back(run.position_m(i));
    run.run(kStood_s);
    double moved = 0;
    double turned = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      moved = std::max(moved, (run.position_m(i) - at[i]).norm());
      turned = std::max(turned, Eigen::AngleAxisd(run.rotation(i)).angle());
      EXPECT_NEAR(run.position_m(i).z(), .015 + .03 * static_cast<double>(i), 1e-4) << motion << i;
    }
    const std::string what = "stack of three, " + motion + ", " + std::to_string(kStood_s) + " s: ";
    figure(what + "moved, um", 1e6 * moved, "< 20");
    figure(what + "turned, mrad", 1e3 * turned, "< 2");
    EXPECT_LT(moved, 2e-5);
    EXPECT_LT(turned, 2e-3);
  }
}

// A block of 30 x 30 x height on a slope that tilts about y.
std::string on_slope(const std::string& motion, double degrees, double friction, double height) {
  const double a = degrees * kDegree;
  const double up = height / 2 + 1e-5;
  const std::string turn =
      motion == "free" ? R"(, "rotation_deg": [0, )" + std::to_string(degrees) + ", 0]" : "";
  return R"("gravity_m_s2": [0, 0, -9.81], "materials": {"m": {"stiffness_N_m": 1000, "static_friction": )" +
         std::to_string(friction) + R"(, "dynamic_friction": )" + std::to_string(friction) +
         R"(}}, "objects": [
      {"name": "slope", "shape": {"plane": {"normal": [)" +
         std::to_string(std::sin(a)) + ", 0, " + std::to_string(std::cos(a)) + R"(]}}, "material": "m"},
      {"name": "block", "shape": {"box": {"size_m": [0.03, 0.03, )" +
         std::to_string(height) + R"(]}}, "pose": {"position_m": [)" + std::to_string(up * std::sin(a)) +
         ", 0, " + std::to_string(up * std::cos(a)) + "]" + turn +
         R"(}, "material": "m", "body": {"motion": ")" + motion + R"(", "mass_kg": 0.1}}])";
}

TEST(Collision, ABlockOnASlopeSlidesWhereTheTangentIsItsFriction) {
  constexpr double kFriction = .4;  // 21.8 degrees
  for (const double degrees : {15.0, 21.3, 22.3, 30.0}) {
    BodyRun run(on_slope("free", degrees, kFriction, .03));
    run.run(.05);
    const Vector3d from = run.velocity_m_s(0);
    run.run(.3);
    const double a = degrees * kDegree;
    const double gained = (run.velocity_m_s(0) - from).norm() / .3;
    const double expected = std::max(9.81 * (std::sin(a) - kFriction * std::cos(a)), 0.0);
    figure("block on a slope of " + std::to_string(degrees) + " degrees, mu 0.4: m/s2", gained,
           std::to_string(expected));
    EXPECT_NEAR(gained, expected, .01 * expected + 1e-3);
  }
}

TEST(Collision, ABlockOnASlopeTipsWhenItsCornerIsPast) {
  // Twice as high as wide: its centre of mass is over the lower edge at atan(1/2), 26.6 degrees.
  for (const double degrees : {25.5, 27.5}) {
    BodyRun run(on_slope("free", degrees, 1.5, .06));
    run.run(1.0);
    const Eigen::Quaterniond start(Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitY()));
    const double turned = run.rotation(0).angularDistance(start) / kDegree;
    figure("tall block on a slope of " + std::to_string(degrees) + " degrees: turned, degrees", turned,
           degrees < 26.5 ? "< 0.2" : "> 45: it lies");
    if (degrees < 26.5) {
      EXPECT_LT(turned, .2);
    } else {
      EXPECT_GT(turned, 45);
    }
  }
}

TEST(Collision, EveryKindRestsOnEveryOtherAndNothingGainsEnergy) {
  // One of each falls into a tray with a box and a ball that stand still: all come to rest above the floor,
  // and stay.
  const std::vector<std::string> shapes = {R"("sphere": {"radius_m": 0.012})",
                                           R"("box": {"size_m": [0.03, 0.02, 0.02]})",
                                           R"("cylinder": {"radius_m": 0.012, "height_m": 0.02})",
                                           R"("capsule": {"radius_m": 0.008, "height_m": 0.02})",
                                           R"("cone": {"radius_m": 0.012, "height_m": 0.025})"};
  constexpr double kMass_kg = .05;
  // Of a homogeneous body of 1 kg: x, y, z. The capsule's: a cylinder and two half balls by their volumes.
  const double r = .008, h = .02;
  const double cylinder = h / (h + 4.0 / 3 * r);
  const double balls = 1 - cylinder;
  const double capsule_x =
      cylinder * (h * h / 12 + r * r / 4) + balls * (.4 * r * r + h * h / 4 + 3.0 / 8 * h * r);
  const double capsule_z = cylinder * r * r / 2 + balls * .4 * r * r;
  const std::vector<Vector3d> inertia_m2 = {
      Vector3d::Constant(.4 * .012 * .012),
      Vector3d(8e-4, 13e-4, 13e-4) / 12,
      {.012 * .012 / 4 + .02 * .02 / 12, .012 * .012 / 4 + .02 * .02 / 12, .012 * .012 / 2},
      {capsule_x, capsule_x, capsule_z},
      {.15 * .012 * .012 + .0375 * .025 * .025, .15 * .012 * .012 + .0375 * .025 * .025, .3 * .012 * .012}};
  for (int round = 0; round < (kUnderSanitizers ? 1 : 4); ++round) {
    Random random(static_cast<std::uint64_t>(round + 1));
    std::string text =
        R"("gravity_m_s2": [0, 0, -9.81], "materials": {"m": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}}, "objects": [
      {"name": "floor", "material": "m", "shape": {"plane": {"normal": [0, 0, 1]}}},
      {"name": "left", "material": "m", "shape": {"plane": {"normal": [1, 0, 0.3], "offset_m": -0.05}}},
      {"name": "right", "material": "m", "shape": {"plane": {"normal": [-1, 0, 0.3], "offset_m": -0.05}}},
      {"name": "front", "material": "m", "shape": {"plane": {"normal": [0, 1, 0.3], "offset_m": -0.05}}},
      {"name": "back", "material": "m", "shape": {"plane": {"normal": [0, -1, 0.3], "offset_m": -0.05}}},
      {"name": "step", "material": "m", "shape": {"box": {"size_m": [0.03, 0.03, 0.02]}}, "pose": {"position_m": [0.02, 0.02, 0.01]}},
      {"name": "knob", "material": "m", "shape": {"sphere": {"radius_m": 0.015}}, "pose": {"position_m": [-0.02, -0.02, 0.005]}})";
    for (int i = 0; i < 8; ++i) {
      const Vector3d angles = 180 * random.in_box(Vector3d::Ones());
      const Vector3d place = random.in_box({.03, .03, 0}) + Vector3d(0, 0, .05 + .035 * i);
      const auto list = [](const Vector3d& v) {
        std::string s("[");
        for (int k = 0; k < 3; ++k) s.append(k == 0 ? "" : ", ").append(std::to_string(v[k]));
        return s.append("]");
      };
      text.append(R"(, {"name": ")")
          .append(std::to_string(i))
          .append(R"(", "material": "m", "shape": {)")
          .append(shapes[static_cast<std::size_t>(i) % shapes.size()]);
      text.append(R"(}, "pose": {"position_m": )")
          .append(list(place))
          .append(R"(, "rotation_deg": )")
          .append(list(angles));
      text.append(
          R"(}, "body": {"motion": "free", "mass_kg": 0.05, "angular_damping_N_m_s": 2e-5, "restitution": 0.2}})");
    }
    BodyRun run(text + "]");
    double energy = 1e9;
    double gained = 0;
    double fastest = 0;
    double deepest = 0;
    while (run.time_s() < 3) {
      run.tick();
      double now = 0;
      fastest = 0;
      for (std::size_t i = 0; i < 8; ++i) {
        const Vector3d v = run.velocity_m_s(i);
        const Vector3d w = run.body(i).spin_rad_s.cast<double>();
        ASSERT_TRUE(v.allFinite() && w.allFinite());
        const Vector3d own = run.rotation(i).conjugate() * w;
        now += kMass_kg * (.5 * v.squaredNorm() + .5 * own.cwiseAbs2().dot(inertia_m2[i % shapes.size()]) +
                           9.81 * run.position_m(i).z());
        fastest = std::max(fastest, v.norm());
        deepest = std::max(deepest, .008 - run.position_m(i).z());
      }
      gained = std::max(gained, now - energy);
      energy = std::min(energy, now);
    }
    figure("tray " + std::to_string(round) + ", 3 s: fastest of 8 bodies, mm/s", 1e3 * fastest, "< 150");
    figure("tray " + std::to_string(round) + ": most that the energy rose again, mJ", 1e3 * gained, "< 1");
    figure("tray " + std::to_string(round) + ": deepest centre below where a body can lie, mm", 1e3 * deepest,
           "< 1");
    figure("tray " + std::to_string(round) + ": points left out", run.renderer().counters().contact_bound,
           "0");
    EXPECT_LT(fastest, .15);
    EXPECT_LT(gained, 1e-3);
    EXPECT_LT(deepest, 1e-3);
  }
}

}  // namespace
}  // namespace thimble::test
