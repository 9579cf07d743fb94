// Two fingers grip a block: when it holds, and when it slips.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

std::string block_on_table(const std::string& motion, double friction) {
  return R"("gravity_m_s2": [0, 0, -9.81], "objects": [
    {"name": "table", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.02}}, "material": {"stiffness_N_m": 1000, "static_friction": 0.5}},
    {"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}},
     "material": {"stiffness_N_m": 1000, "damping_N_s_m": 2, "static_friction": )" +
         std::to_string(friction) + R"(, "dynamic_friction": )" + std::to_string(.7 * friction) +
         R"(}, "body": {"motion": ")" + motion + R"(", "mass_kg": 0.1}}])";
}

struct Lift {
  double height_m = 0;  // of the block, after the lift
  double down_N = 0;    // what both fingers feel of its weight, mean over the last half second
  int slips = 0;        // drops of a finger's force along the block by more than 0.05 N in a tick
  double turned_rad = 0;
};

// Squeezes by normal_N a side and lifts by 40 mm in a second.
Lift lift(const std::string& motion, double friction, double normal_N) {
  BodyRun run(block_on_table(motion, friction), {{-.021, 0, 0}, {.021, 0, 0}});
  const double depth = normal_N / 1000;
  Lift result;
  int samples = 0;
  std::array<double, 2> before{};
  while (run.time_s() < 2.2) {
    const double t = run.time_s();
    const double in = std::min(t / .2, 1.0) * (.001 + depth);
    const double part = std::clamp((t - .3) / 1.0, 0.0, 1.0);
    const double up = .04 * part * part * (3 - 2 * part);
    run.tick({{-.021 + in, 0, up}, {.021 - in, 0, up}});
    const double down = -run.force_N(0).z() - run.force_N(1).z();
    for (std::size_t i = 0; i < 2; ++i) {
      if (t > .3 && std::abs(run.force_N(i).z()) < before[i] - .05) ++result.slips;
      before[i] = std::abs(run.force_N(i).z());
    }
    if (t > 1.7) {
      result.down_N += down;
      ++samples;
    }
  }
  result.down_N /= samples;
  result.height_m = run.position_m(0).z();
  result.turned_rad = Eigen::AngleAxisd(run.rotation(0)).angle();
  return result;
}

TEST(Grasp, ABlockIsLiftedWhenFrictionCarriesItAndSlipsWhenNot) {
  constexpr double kWeight_N = .1 * 9.81;
  for (const std::string motion : {"translate", "free"}) {
    // mu F_n of both fingers against the weight: 2 * 0.5 * 1.5 = 1.5 N holds, 2 * 0.5 * 0.8 = 0.8 N does not.
    const Lift held = lift(motion, .5, 1.5);
    const Lift slipped = lift(motion, .5, .8);
    figure(motion + ", mu F_n 1.5 N for 0.98 N: block's height, mm", 1e3 * held.height_m, "39 to 40");
    figure(motion + ", held: weight on the fingers, N", held.down_N, "0.981, 1 %");
    figure(motion + ", held: slips", held.slips, "0");
    figure(motion + ", mu F_n 0.8 N: block's height, mm", 1e3 * slipped.height_m, "< 1");
    figure(motion + ", mu F_n 0.8 N: slips, felt as drops of the force", slipped.slips, "> 50");
    EXPECT_GT(held.height_m, .038);
    EXPECT_NEAR(held.down_N, kWeight_N, .01 * kWeight_N);
    EXPECT_EQ(held.slips, 0);
    EXPECT_LT(slipped.height_m, 1e-3);
    EXPECT_GT(slipped.slips, 50);
    EXPECT_LT(held.turned_rad, .05);
  }
}

TEST(Grasp, TwoFingersTurnABlock) {
  // Held in the middle, the fingers go round each other by a quarter turn in a second: the block goes with
  // them.
  BodyRun run(R"("objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}},
     "material": {"stiffness_N_m": 1000, "damping_N_s_m": 2, "static_friction": 1}, "body": {"motion": "free", "mass_kg": 0.1}}])",
              {{-.021, 0, 0}, {.021, 0, 0}});
  while (run.time_s() < 1.6) {
    const double t = run.time_s();
    const double angle = 1.5707963 * std::clamp((t - .3) / 1.0, 0.0, 1.0);
    const double r = .021 - std::min(t / .2, 1.0) * .004;
    const Vector3d out(-r * std::cos(angle), 0, r * std::sin(angle));
    run.tick({out, -out});
  }
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(1.5707963, Vector3d::UnitY()));
  const double off = run.rotation(0).angularDistance(expected);
  figure("block turned by 90 degrees between two fingers: off by, degrees", off * 57.2958, "< 3");
  EXPECT_LT(off * 57.2958, 3);
  EXPECT_LT(run.position_m(0).norm(), 1e-3);
}

// A free block of 40 mm and 0.1 kg, pinched by 1.5 N a side, `off` in front of its centre.
std::string pinched(const std::string& gravity, const std::string& body, double damping) {
  return R"("gravity_m_s2": )" + gravity +
         R"(, "objects": [{"name": "block", "shape": {"box": {"size_m": [0.04, 0.04, 0.04]}},
     "material": {"stiffness_N_m": 1000, "damping_N_s_m": )" +
         std::to_string(damping) + R"(, "static_friction": 0.5}, "body": {"motion": "free", "mass_kg": 0.1)" +
         body + "}}]";
}

// From 21 mm on either side to 18.5 mm in 20 ms.
void pinch(BodyRun& run, double y_m) {
  for (int i = 0; i <= 80; ++i) {
    const double x = .021 - .0025 * i / 80;
    run.tick({{-x, y_m, 0}, {x, y_m, 0}});
  }
}

TEST(Grasp, ABlockBetweenTwoFingertipsIsHeldAgainstItsSpin) {
  // The moment of two fingertips: 2 mu F_n 3.3 mm. It slows a spin about the line between them, and holds a moment
  // of the weight up to it.
  constexpr double kMoment_N_m = 2 * .5 * 1.5 * 3.3e-3;
  constexpr double kInertia_kg_m2 = .1 * .04 * .04 / 6;
  BodyRun spun(pinched("[0, 0, 0]", R"(, "spin_rad_s": [8, 0, 0])", 2), {{-.021, 0, 0}, {.021, 0, 0}});
  pinch(spun, 0);
  const double from = static_cast<double>(spun.body(0).spin_rad_s.x());
  spun.run(.02);
  const double slowed = (from - static_cast<double>(spun.body(0).spin_rad_s.x())) / .02;
  figure("pinched block that spins: slowed, rad/s2", slowed,
         std::to_string(kMoment_N_m / kInertia_kg_m2) + ", 2 %");
  EXPECT_NEAR(slowed, kMoment_N_m / kInertia_kg_m2, .02 * kMoment_N_m / kInertia_kg_m2);
  spun.run(.1);
  EXPECT_LT(spun.body(0).spin_rad_s.norm(), 1e-3);
  for (const double off : {.8, 1.2}) {
    const double y = off * kMoment_N_m / .981;
    BodyRun held(pinched("[0, 0, -9.81]", "", 2), {{-.021, y, 0}, {.021, y, 0}});
    pinch(held, y);
    held.run(.1);
    const Eigen::Quaterniond from_q = held.rotation(0);
    held.run(1);
    const double turned = held.rotation(0).angularDistance(from_q);
    figure("pinched at " + std::to_string(off) + " of the moment that holds: turned in 1 s, rad", turned,
           off < 1 ? "< 0.001" : "> 0.2: it swings down");
    if (off < 1) {
      EXPECT_LT(turned, 1e-3);
    } else {
      EXPECT_GT(turned, .2);
    }
  }
}

TEST(Grasp, AHeldBlockComesToRest) {
  // Struck along the surface, it swings on the springs of two fingertips with 22 Hz. Damped by B of each it decays with
  // exp(-2 B t / (2 m)): to 0.0025 in 0.3 s.
  for (const double damping : {0.0, 2.0}) {
    BodyRun run(pinched("[0, 0, 0]", R"(, "velocity_m_s": [0, 0, 0.014])", damping),
                {{-.021, 0, 0}, {.021, 0, 0}});
    pinch(run, 0);
    const auto fastest = [&](double until_s) {
      double most = 0;
      while (run.time_s() < until_s) {
        run.tick();
        most = std::max(most, std::abs(run.velocity_m_s(0).z()));
      }
      return most;
    };
    const double first = fastest(.07);
    fastest(.37);
    const double later = fastest(.42);
    const std::string what = "held block, damping " + std::to_string(damping) + ": ";
    figure(what + "swings with, mm/s", 1e3 * first, "> 5");
    figure(what + "share of it 0.3 s later", later / first, damping > 0 ? "0.0025, at most 0.004" : "> 0.95");
    EXPECT_GT(first, .005);
    if (damping > 0) {
      EXPECT_LT(later, .004 * first);
    } else {
      EXPECT_GT(later, .95 * first);
    }
  }
}

TEST(Grasp, APressedBlockOnTheFloorIsFeltAsMassAndFriction) {
  // Pushed from the side at 50 mm/s over the floor: mu m g.
  BodyRun run(block_on_table("translate", .4), {{-.021, 0, 0}});
  double sum = 0;
  int samples = 0;
  while (run.time_s() < 1.2) {
    run.tick({{-.021 + .05 * run.time_s(), 0, 0}});
    if (run.time_s() > .6) {
      sum -= run.force_N(0).x();
      ++samples;
    }
  }
  const double expected = std::sqrt(.7 * .4 * .5) * .981;
  figure("a block pushed over the floor: mean force, N", sum / samples, std::to_string(expected) + ", 3 %");
  EXPECT_NEAR(sum / samples, expected, .03 * expected);
}

}  // namespace
}  // namespace thimble::test
