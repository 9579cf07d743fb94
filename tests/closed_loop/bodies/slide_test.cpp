// Dry friction of free bodies: where they break away, and how they slide.
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

constexpr double kStatic = .6;
constexpr double kDynamic = .4;

struct Sample {
  std::string name;
  std::string shape;
  std::string turn_deg = "[0, 0, 0]";  // before the slope turns it
  double height_m = 0;                 // of its centre over the floor
  double mass_kg = .1;
};

std::string body(const std::string& name, const std::string& shape, const Vector3d& at,
                 const std::string& turn, const std::string& material, double mass_kg) {
  return R"(, {"name": ")" + name + R"(", "shape": {)" + shape + R"(}, "pose": {"position_m": )" + list(at) +
         R"(, "rotation_deg": )" + turn + R"(}, "material": ")" + material +
         R"(", "body": {"motion": "free", "mass_kg": )" + std::to_string(mass_kg) + "}}";
}

// The floor stays level and the gravity leans: by `tangent` along the direction of `heading_deg`. Unlike materials whose
// geometric means are kStatic and kDynamic.
std::string leaning(double tangent, double heading_deg, const std::string& objects) {
  const double down = 9.81 / std::sqrt(1 + tangent * tangent);
  const double heading = heading_deg * kDegree;
  return R"("gravity_m_s2": )" +
         list({tangent * down * std::cos(heading), tangent * down * std::sin(heading), -down}) +
         R"(, "materials": {
      "rubber": {"stiffness_N_m": 1000, "static_friction": 0.9, "dynamic_friction": 0.8},
      "steel": {"stiffness_N_m": 1000, "static_friction": 0.4, "dynamic_friction": 0.2}},
    "objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": "rubber"})" +
         objects + "]";
}

const Sample kSamples[] = {
    {"cube", R"("box": {"size_m": [0.03, 0.03, 0.03]})", "[0, 0, 0]", .015},
    {"light cube, turned", R"("box": {"size_m": [0.03, 0.03, 0.03]})", "[0, 0, 25]", .015, .01},
    {"heavy brick", R"("box": {"size_m": [0.06, 0.03, 0.02]})", "[0, 0, 0]", .01, 2},
    {"cylinder, standing", R"("cylinder": {"radius_m": 0.015, "height_m": 0.02})", "[0, 0, 0]", .01},
    {"cylinder, lying along the slope", R"("cylinder": {"radius_m": 0.01, "height_m": 0.04})", "[0, 90, 0]",
     .01},
    {"capsule, lying along the slope", R"("capsule": {"radius_m": 0.01, "height_m": 0.04})", "[0, 90, 0]",
     .01, .3},
};

double slid_m(double tangent, double heading_deg, const Sample& sample, double duration_s) {
  BodyRun run(
      leaning(tangent, heading_deg,
              body("body", sample.shape, {0, 0, sample.height_m}, sample.turn_deg, "steel", sample.mass_kg)));
  run.run(duration_s);
  return run.position_m(0).head<2>().norm();
}

TEST(Slide, BodiesBreakAwayAtTheirStaticFriction) {
  for (const Sample& sample : kSamples) {
    for (const double heading_deg : {0.0, 180.0}) {
      const double held = slid_m(.98 * kStatic, heading_deg, sample, 1);
      const double gone = slid_m(1.02 * kStatic, heading_deg, sample, 1);
      const std::string what = sample.name + ", heading " + std::to_string(static_cast<int>(heading_deg));
      figure(what + ": slid in 1 s at 98 % of the static friction, um", 1e6 * held, "< 5");
      // With the dynamic friction, after the moment it takes to begin.
      figure(what + ": at 102 %, mm", 1e3 * gone, "> 700");
      EXPECT_LT(1e6 * held, 5) << what;
      EXPECT_GT(1e3 * gone, 700) << what;
    }
  }
}

// A plate on three balls that stand still: three patches that share the load unlike.
TEST(Slide, ATripodBreaksAwayAtItsStaticFriction) {
  for (const double part : {.98, 1.02}) {
    const auto ball = [](const std::string& name, double x, double y) {
      return R"(, {"name": ")" + name +
             R"(", "shape": {"sphere": {"radius_m": 0.01}}, "pose": {"position_m": )" + list({x, y, .01}) +
             R"(}, "material": "rubber"})";
    };
    BodyRun run(leaning(part * kStatic, 20,
                        ball("a", .03, .002) + ball("b", -.02, .025) + ball("c", -.018, -.03) +
                            body("plate", R"("box": {"size_m": [0.2, 0.2, 0.004]})", {.004, -.003, .022},
                                 "[0, 0, 0]", "steel", .2)));
    const Vector3d from = run.position_m(0);
    run.run(.3);
    const double slid = (run.position_m(0) - from).head<2>().norm();
    figure("plate on three balls at " + std::to_string(part) + " of its static friction: slid in 0.3 s, um",
           1e6 * slid, part < 1 ? "< 5" : "> 30000");
    if (part < 1) {
      EXPECT_LT(1e6 * slid, 5);
    } else {
      EXPECT_GT(1e6 * slid, 30000);
    }
  }
}

TEST(Slide, ASlidingBodyIsSlowedByItsDynamicFriction) {
  for (const Sample& sample : kSamples) {
    std::string text = leaning(
        0, 0, body("body", sample.shape, {0, 0, sample.height_m}, sample.turn_deg, "steel", sample.mass_kg));
    text.insert(text.rfind("}}"), R"(, "velocity_m_s": [0.6, 0, 0])");
    BodyRun run(text);
    run.run(.02);
    const double from = run.velocity_m_s(0).x();
    run.run(.1);
    const double slowed = (from - run.velocity_m_s(0).x()) / .1;
    const double aside = std::abs(run.velocity_m_s(0).y());
    figure(sample.name + ": slowed, m/s2", slowed, std::to_string(kDynamic * 9.81) + ", 1 %");
    EXPECT_NEAR(slowed, kDynamic * 9.81, .01 * kDynamic * 9.81) << sample.name;
    EXPECT_LT(aside, 5e-3) << sample.name;
    run.run(.2);
    EXPECT_LT(run.velocity_m_s(0).norm(), 1e-5) << sample.name;
  }
}

TEST(Slide, FrictionIsOppositeToTheMotion) {
  // A brick pushed off its axes: unlike moments of inertia about both, and its way stays straight.
  std::string text = leaning(
      0, 0, body("brick", R"("box": {"size_m": [0.06, 0.02, 0.02]})", {0, 0, .01}, "[0, 0, 0]", "steel", .2));
  text.insert(text.rfind("}}"), R"(, "velocity_m_s": [0.5, 0.5, 0])");
  BodyRun brick(text);
  brick.run(.08);
  const Vector3d v = brick.velocity_m_s(0);
  figure("brick that slides at 45 degrees to its axes: heading off by, degrees",
         (std::atan2(v.y(), v.x()) / kDegree) - 45, "< 1");
  EXPECT_NEAR(std::atan2(v.y(), v.x()) / kDegree, 45, 1);
}

TEST(Slide, ABallRollsDownASlope) {
  // 5/7 g sin a without slip.
  for (const double radius : {.004, .02}) {
    BodyRun run(leaning(.3, 35,
                        body("ball", R"("sphere": {"radius_m": )" + std::to_string(radius) + "}",
                             {0, 0, radius}, "[0, 0, 0]", "steel", .05)));
    run.run(.2);
    const double rolled = run.velocity_m_s(0).head<2>().norm() / .2;
    const double expected = 5.0 / 7.0 * 9.81 * .3 / std::sqrt(1.09);
    figure("ball of " + std::to_string(1e3 * radius) + " mm: rolls with, m/s2", rolled,
           std::to_string(expected) + ", 0.2 %");
    const double spin = run.body(0).spin_rad_s.cast<double>().norm();
    figure("its spin, rad/s", spin, std::to_string(rolled * .2 / radius));
    EXPECT_NEAR(rolled, expected, .002 * expected);
    EXPECT_NEAR(spin, rolled * .2 / radius, .002 * spin);
  }
}

// Its friction is far more than both weights.
TEST(Slide, AControlThatFrictionHoldsDoesNotCreepUnderALoad) {
  const auto box = [](const std::string& name, double height_m, const std::string& body) {
    return R"({"name": ")" + name +
           R"(", "shape": {"box": {"size_m": [0.03, 0.03, 0.02]}}, "pose": {"position_m": )" +
           list({0, 0, height_m}) +
           R"(}, "material": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}, "body": {)" +
           body + "}}";
  };
  for (const bool turns : {false, true}) {
    const std::string control =
        turns
            ? R"("motion": "turn", "axis": [0, 1, 0], "pivot_m": [0.1, 0, 0], "mass_kg": 0.5, "control": {"friction_N_m": 3, "low_deg": -20, "high_deg": 20})"
            : R"("motion": "slide", "axis": [0, 0, 1], "mass_kg": 0.5, "control": {"friction_N": 30, "low_m": -0.02, "high_m": 0.02})";
    BodyRun run(std::string(kGravity) + R"("objects": [)" + box("lift", 0, control) + ", " +
                box("load", .02, R"("motion": "free", "mass_kg": 0.05)") + "]");
    run.run(5);
    const double sunk_m = -run.position_m(0).z();
    figure(std::string(turns ? "lever" : "lift") + " that friction holds: sinks under a load in 5 s, um",
           1e6 * sunk_m, "0");
    EXPECT_EQ(sunk_m, 0);
    EXPECT_NEAR(run.position_m(1).z(), .02, 5e-5) << "the load lies on it";
  }
}

}  // namespace
}  // namespace thimble::test
