// Impacts of single bodies, thrown on to a level floor with spin and friction: none gains energy.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

constexpr double kThrown_kg = .1;
constexpr double kFalls_m_s2 = 9.81;

struct Thrown {
  std::string shape;
  Vector3d inertia_kg_m2;
};

Thrown thrown(Random& random) {
  const auto size = [&] { return random.uniform(.01, .05); };
  const auto text = [](double value) { return std::to_string(value); };
  const double r = .5 * size();
  const double h = size();
  const double m = kThrown_kg;
  switch (random.below(4)) {
    case 0:
      return {R"("sphere": {"radius_m": )" + text(r) + "}", Vector3d::Constant(.4 * m * r * r)};
    case 1: {
      const Vector3d s(size(), size(), size());
      const Vector3d s2 = s.cwiseAbs2();
      return {R"("box": {"size_m": )" + list(s) + "}",
              m / 12 * Vector3d(s2.y() + s2.z(), s2.x() + s2.z(), s2.x() + s2.y())};
    }
    case 2: {
      const double across = m * (3 * r * r + h * h) / 12;
      return {R"("cylinder": {"radius_m": )" + text(r) + R"(, "height_m": )" + text(h) + "}",
              {across, across, .5 * m * r * r}};
    }
    default: {
      const double across = 3 * m * (r * r / 20 + h * h / 80);
      return {R"("cone": {"radius_m": )" + text(r) + R"(, "height_m": )" + text(h) + "}",
              {across, across, .3 * m * r * r}};
    }
  }
}

// Of body 0.
double thrown_energy_J(const BodyRun& run, const Vector3d& inertia_kg_m2) {
  const Vector3d spin = run.rotation(0).conjugate() * run.body(0).spin_rad_s.cast<double>();
  return kThrown_kg * (.5 * run.velocity_m_s(0).squaredNorm() + kFalls_m_s2 * run.position_m(0).z()) +
         .5 * inertia_kg_m2.dot(spin.cwiseAbs2());
}

std::string impact_scene(const std::string& floor, const std::string& body, double friction,
                         double restitution, const std::string& motion) {
  return kGravity + std::string(R"("materials": {"m": {"stiffness_N_m": 1000, "static_friction": )") +
         std::to_string(friction) + R"(}}, "objects": [{"name": "floor", "material": "m", "shape": {)" +
         floor + R"(}}, {"name": "body", "material": "m", "shape": {)" + body +
         R"(}, "body": {"motion": "free", "mass_kg": )" + std::to_string(kThrown_kg) +
         R"(, "restitution": )" + std::to_string(restitution) + motion + "]";
}

// Friction can push a body on only where its impulse does not fit the slip that it leaves.
TEST(Impact, NoThrownBodyGainsEnergy) {
  constexpr int kThrows = kUnderSanitizers ? 4 : 60;
  const TemporaryFolder folder;
  const std::string heights = (folder.path() / "flat.csv").string();
  std::ofstream file(heights);
  for (int row = 0; row < 13; ++row) file << "0,0,0,0,0,0,0,0,0,0,0,0,0\n";
  file.close();
  const std::string field = R"("height_field": {"file": ")" + heights +
                            R"(", "size_m": [0.6, 0.6], "height_m": 0.001, "thickness_m": 0.02})";
  Random random(13);
  for (const std::string& floor : {std::string(R"("plane": {"normal": [0, 0, 1]})"), field}) {
    for (const double restitution : {0.0, .5, .8, 1.0}) {
      double most = 0;
      double least_lost = 1;
      for (int i = 0; i < kThrows; ++i) {
        const Thrown body = thrown(random);
        BodyRun run(impact_scene(floor, body.shape, random.uniform(.2, 2.5), restitution,
                                 R"(, "velocity_m_s": )" + list(random.in_box(Vector3d::Constant(.5))) +
                                     R"(, "spin_rad_s": )" + list(random.in_box(Vector3d::Constant(20))) +
                                     R"(}, "pose": {"position_m": [0, 0, 0.1], "rotation_deg": )" +
                                     list(random.in_box(Vector3d::Constant(180))) + "}}"));
        const double thrown_J = thrown_energy_J(run, body.inertia_kg_m2);
        double before_J = thrown_J;
        while (run.time_s() < .5) {
          run.tick();
          const double now_J = thrown_energy_J(run, body.inertia_kg_m2);
          most = std::max(most, (now_J - before_J) / thrown_J);
          before_J = now_J;
        }
        least_lost = std::min(least_lost, 1 - before_J / thrown_J);
      }
      // At a bounce the energy of semi-implicit Euler changes by up to m g v T, and back on the way.
      const double limit = restitution < 1 ? 1e-3 : 5e-3;
      const std::string what =
          std::string(floor == field ? "field" : "plane") + ", e " + std::to_string(restitution);
      figure(what + ": most energy that a tick adds, of all, %", 100 * most,
             "< " + std::to_string(100 * limit));
      figure(what + ": least that the impacts take, %", 100 * least_lost, "> 1");
      EXPECT_LT(most, limit);
      EXPECT_GT(least_lost, restitution < 1 ? .01 : -limit);
    }
  }
}

// Semi-implicit Euler that mirrors the speed after a whole tick's fall adds m g T v with each bounce: 12 % in 10 s.
TEST(Impact, ABallOfRestitution1BouncesAsHighAgain) {
  const double radius_m = .02;
  BodyRun run(impact_scene(R"("plane": {"normal": [0, 0, 1]})", R"("sphere": {"radius_m": 0.02})", .5, 1,
                           R"(}, "pose": {"position_m": [0, 0, 0.12]}})"));
  double highest_m = 0;
  for (const double end = kUnderSanitizers ? 1 : 10; run.time_s() < end;) {
    run.tick();
    if (run.time_s() > end - .4) highest_m = std::max(highest_m, run.position_m(0).z() - radius_m);
  }
  figure("ball of restitution 1, after 10 s: height of its bounce, mm", 1e3 * highest_m, "100, 1 %");
  EXPECT_NEAR(highest_m, .1, .001);
}

// Pucks on ice that knock each other about between boards until they rest.
TEST(Impact, PucksStayBetweenTheBoardsAndGainNoEnergy) {
  constexpr double kReach_m = .015;
  const std::string ice =
      R"("material": {"stiffness_N_m": 1000, "static_friction": 0.1, "dynamic_friction": 0.05})";
  const auto board = [&](const std::string& normal, double offset_m) {
    return R"({"name": ")" + normal + R"(", "shape": {"plane": {"normal": )" + normal + R"(, "offset_m": )" +
           std::to_string(offset_m) + "}}, " + ice + "}";
  };
  Random random(1);
  double rise = 0;
  double beyond_m = 0;
  for (int seed = 0; seed < (kUnderSanitizers ? 2 : 40); ++seed) {
    std::string text = std::string(kGravity) + R"("objects": [)" + board("[0, 0, 1]", 0) + ", " +
                       board("[1, 0, 0]", -.09) + ", " + board("[-1, 0, 0]", -.09) + ", " +
                       board("[0, 1, 0]", -.06) + ", " + board("[0, -1, 0]", -.06);
    const std::size_t count = 2 + random.below(4);
    std::vector<double> mass_kg;
    for (std::size_t i = 0; i < count; ++i) {
      mass_kg.push_back(random.uniform(.05, .5));
      const Vector3d velocity_m_s = random.in_box({.5, .5, 0});
      text += R"(, {"name": "puck )" + std::to_string(i) +
              R"(", "shape": {"cylinder": {"radius_m": 0.015, "height_m": 0.02}}, "pose": {"position_m": )" +
              list({-.064 + .032 * static_cast<double>(i), random.uniform(-.04, .04), .01}) + "}, " + ice +
              R"(, "body": {"motion": "plane", "restitution": 0.8, "mass_kg": )" +
              std::to_string(mass_kg.back()) + R"(, "velocity_m_s": )" + list(velocity_m_s) + "}}";
    }
    BodyRun run(text + "]");
    double before_J = std::numeric_limits<double>::infinity();
    while (run.time_s() < 5) {
      run.tick();
      double energy_J = 0;
      for (std::size_t i = 0; i < count; ++i) {
        energy_J += .5 * mass_kg[i] * run.velocity_m_s(i).squaredNorm();
        const Vector3d p = run.position_m(i);
        ASSERT_TRUE(p.allFinite()) << seed << " at " << run.time_s();
        beyond_m = std::max({beyond_m, std::abs(p.x()) + kReach_m - .09, std::abs(p.y()) + kReach_m - .06});
      }
      rise = std::max(rise, energy_J - before_J);
      before_J = energy_J;
    }
  }
  figure("pucks: beyond a board, um", 1e6 * beyond_m, "< 20");
  figure("pucks: most that the energy rose in a tick, J", rise, "< 1e-8");
  EXPECT_LT(beyond_m, 20e-6);
  EXPECT_LT(rise, 1e-8);
}

// What a contact bears decays until it is hardly a number. Pressed on boards and left there, a puck keeps a place.
TEST(Impact, APuckThatIsLeftAtABoardKeepsItsPlace) {
  const std::string ice =
      R"("material": {"stiffness_N_m": 1000, "static_friction": 0.02, "dynamic_friction": 0.01})";
  Random random(1);
  for (int trial = 0; trial < (kUnderSanitizers ? 2 : 50); ++trial) {
    Vector3d tip(.04, random.uniform(-.005, .005), .01);
    BodyRun run(
        std::string(kGravity) + R"("objects": [{"name": "ice", "shape": {"plane": {"normal": [0, 0, 1]}}, )" +
            ice + R"(}, {"name": "board", "shape": {"plane": {"normal": [1, 0, 0]}}, )" + ice +
            R"(}, {"name": "puck", "shape": {"cylinder": {"radius_m": 0.015, "height_m": 0.02}}, "pose": {"position_m": [0.016, 0, 0.01]}, )" +
            ice + R"(, "body": {"motion": "plane", "mass_kg": 0.05}}])",
        {tip});
    const Vector3d step(-random.uniform(1e-6, 1e-5), 0, 0);
    const double to_m = random.uniform(.027, .0305);
    while (tip.x() > to_m) run.tick({tip += step});
    while (tip.x() < .04) run.tick({tip -= step});
    run.run(.3);
    const Vector3d p = run.position_m(0);
    ASSERT_TRUE(p.allFinite() && p.x() > .015 - 20e-6) << "trial " << trial << ": " << p.transpose();
  }
}

}  // namespace
}  // namespace thimble::test
