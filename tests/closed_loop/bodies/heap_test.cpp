// Many bodies on each other: stacks stand, and heaps stay above the floor. THIMBLE_HEAP_LONG=1: the full times.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

bool is_long() { return std::getenv("THIMBLE_HEAP_LONG") != nullptr; }
double seconds(double in_long, double in_short) {
  return is_long() ? in_long : kUnderSanitizers ? .1 : in_short;
}

const std::string kFloor =
    R"("gravity_m_s2": [0, 0, -9.81], "materials": {
      "wood": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4},
      "felt": {"stiffness_N_m": 500, "static_friction": 0.9, "dynamic_friction": 0.6}},
    "objects": [{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1]}}, "material": "wood"})";

struct Brick {
  Vector3d size_m;
  Vector3d at_m;
  double mass_kg = .1;
};

std::string wall_of(const std::vector<Brick>& bricks) {
  std::string text = kFloor;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const Brick& brick = bricks[i];
    text += R"(, {"name": ")" + std::to_string(i) + R"(", "shape": {"box": {"size_m": )" +
            list(brick.size_m) + R"(}}, "pose": {"position_m": )" + list(brick.at_m) + R"(}, "material": ")" +
            (i % 3 == 0 ? "felt" : "wood") + R"(", "body": {"motion": "free", "mass_kg": )" +
            std::to_string(brick.mass_kg) + "}}";
  }
  return text + "]";
}

struct Stood {
  double sunk_m = 0;   // of the lowest against where it began, less the gap it was dropped by
  double moved_m = 0;  // the farthest drift once it has settled
  double turned_rad = 0;
  double speed_m_s = 0;  // the fastest at the end
  double points_left_out = 0;
};

Stood stand(const std::vector<Brick>& bricks, double duration_s, double settles_s = .5) {
  BodyRun run(wall_of(bricks));
  run.run(kUnderSanitizers ? .1 : settles_s);
  std::vector<Vector3d> at;
  for (std::size_t i = 0; i < bricks.size(); ++i) at.push_back(run.position_m(i));
  run.run(duration_s);
  Stood stood;
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    stood.sunk_m = std::max(stood.sunk_m, (run.position_m(i) - bricks[i].at_m).norm());
    stood.moved_m = std::max(stood.moved_m, (run.position_m(i) - at[i]).norm());
    stood.turned_rad = std::max(stood.turned_rad, Eigen::AngleAxisd(run.rotation(i)).angle());
    stood.speed_m_s = std::max(stood.speed_m_s, run.velocity_m_s(i).norm());
  }
  stood.points_left_out = run.renderer().counters().contact_bound;
  return stood;
}

void report(const std::string& what, const Stood& stood, double moved_um, double sunk_um) {
  figure(what + ": drift once it has settled, um", 1e6 * stood.moved_m, "< " + std::to_string(moved_um));
  figure(what + ": moved from the start, um", 1e6 * stood.sunk_m, "< " + std::to_string(sunk_um));
  figure(what + ": turned, mrad", 1e3 * stood.turned_rad, "< 1");
  figure(what + ": contact points left out", stood.points_left_out, "");
  EXPECT_LT(1e6 * stood.moved_m, moved_um) << what;
  EXPECT_LT(1e6 * stood.sunk_m, sunk_um) << what;
  EXPECT_LT(stood.turned_rad, 1e-3) << what;
}

TEST(Heap, TwelveBricksInThreeRowsStand) {
  std::vector<Brick> bricks;
  for (int row = 0; row < 3; ++row)
    for (int i = 0; i < 4; ++i)
      bricks.push_back(
          {{.04, .02, .015}, {.0405 * i + .01 * (row % 2), 0, .0076 + .0151 * row}, .05 + .03 * (i % 3)});
  report("12 bricks in three rows", stand(bricks, seconds(10, .6)), 20, 400);
}

TEST(Heap, SixteenBricksSideBySideStand) {
  // They touch at their sides too: more points than the budget.
  std::vector<Brick> bricks;
  for (int row = 0; row < 4; ++row)
    for (int i = 0; i < 4; ++i)
      bricks.push_back(
          {{.04, .02, .015}, {.04 * i + .01 * (row % 2), 0, .0075 + .015 * row}, .05 + .03 * (i % 3)});
  report("16 bricks side by side", stand(bricks, seconds(10, .6)), 20, 400);
}

TEST(Heap, APyramidOfSixteenStands) {
  std::vector<Brick> bricks;
  for (int row = 0; row < 5; ++row)
    for (int i = 0; i < 5 - row; ++i)
      bricks.push_back({{.03, .03, .03}, {.032 * (i + .5 * row), 0, .0155 + .0305 * row}, .1});
  bricks.push_back({{.03, .03, .03}, {.064, 0, .0155 + .0305 * 5}, .1});
  report("pyramid of 16", stand(bricks, seconds(10, .6)), 20, 3500);
}

TEST(Heap, AColumnOfSixteenStands) {
  std::vector<Brick> bricks;
  for (int i = 0; i < 16; ++i)
    bricks.push_back(
        {{.03, .03, .03}, {.002 * (i % 2), -.001 * (i % 3), .015 + .03 * i}, .05 + .05 * (i % 4)});
  report("column of 16", stand(bricks, seconds(20, .5), 2.5), 10, 400);
}

// A body of the heap, for a judge that knows only the closed forms of its shape.
struct Heaped {
  std::string shape;
  double mass_kg = 0;
  std::vector<Vector3d> surface;                   // points of its surface, in its frame
  std::function<double(const Vector3d&)> depth_m;  // of a point in its frame; above 0 inside
};

Heaped random_solid(Random& random) {
  const double a = random.uniform(.008, .02);
  const double b = random.uniform(.008, .02);
  const double c = random.uniform(.006, .016);
  Heaped solid;
  solid.mass_kg = std::exp(random.uniform(std::log(.02), std::log(.5)));
  const auto round = [&](double half_m, double cap_m) {  // a cylinder's side, or a capsule's with its caps
    for (int i = 0; i < 24; ++i) {
      const double angle = i * M_PI / 12;
      const Vector3d out(a * std::cos(angle), a * std::sin(angle), 0);
      for (const double z : {-half_m, -.5 * half_m, .0, .5 * half_m, half_m})
        solid.surface.push_back(out + Vector3d(0, 0, z));
      if (cap_m <= 0) continue;
      for (const double up : {-1.0, 1.0})
        solid.surface.push_back(.7071 * out + Vector3d(0, 0, up * (half_m + .7071 * cap_m)));
    }
  };
  switch (random.below(4)) {
    case 0:
      solid.shape = R"("sphere": {"radius_m": )" + std::to_string(a) + "}";
      solid.depth_m = [a](const Vector3d& p) { return a - p.norm(); };
      for (int i = 0; i < 120; ++i) solid.surface.push_back(a * random.direction());
      break;
    case 1: {
      const Vector3d half(a, b, c);
      solid.shape = R"("box": {"size_m": )" + list(2 * half) + "}";
      solid.depth_m = [half](const Vector3d& p) { return (half - p.cwiseAbs()).minCoeff(); };
      for (int i = 0; i < 125; ++i)
        solid.surface.push_back(half.cwiseProduct(Vector3d(i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2) / 2));
      break;
    }
    case 2:
      solid.shape = R"("cylinder": {"radius_m": )" + std::to_string(a) + R"(, "height_m": )" +
                    std::to_string(2 * b) + "}";
      solid.depth_m = [a, b](const Vector3d& p) {
        return std::min(a - p.head<2>().norm(), b - std::abs(p.z()));
      };
      round(b, 0);
      break;
    default:
      solid.shape = R"("capsule": {"radius_m": )" + std::to_string(a) + R"(, "height_m": )" +
                    std::to_string(2 * b) + "}";
      solid.depth_m = [a, b](const Vector3d& p) {
        return a - (p - Vector3d(0, 0, std::clamp(p.z(), -b, b))).norm();
      };
      round(b, a);
      break;
  }
  return solid;
}

// Cylinders askew to boxes and cylinders collide as boxes, so they may only be apart.
TEST(Heap, SixteenRandomBodiesStayAboveTheFloor) {
  const int heaps = is_long() ? 12 : 1;
  double deepest_floor_m = 0;
  double deepest_pair_m = 0;
  double fastest_m_s = 0;
  double left_out = 0;
  for (int heap = 0; heap < (kUnderSanitizers ? 1 : heaps); ++heap) {
    Random random(static_cast<std::uint64_t>(100 + heap));
    std::string text = kFloor;
    for (const std::string normal : {"[1, 0, 0.2]", "[-1, 0, 0.2]", "[0, 1, 0.2]", "[0, -1, 0.2]"})
      text += R"(, {"name": "wall )" + normal + R"(", "material": "wood", "shape": {"plane": {"normal": )" +
              normal + R"(, "offset_m": -0.05}}})";
    std::vector<Heaped> solids;
    for (int i = 0; i < 16; ++i) {
      solids.push_back(random_solid(random));
      const Vector3d place = random.in_box({.03, .03, 0}) + Vector3d(0, 0, .05 + .05 * i);
      text += R"(, {"name": ")" + std::to_string(i) + R"(", "material": ")" + (i % 2 == 0 ? "felt" : "wood") +
              R"(", "shape": {)" + solids.back().shape + R"(}, "pose": {"position_m": )" + list(place) +
              R"(, "rotation_deg": )" + list(180 * random.in_box(Vector3d::Ones())) +
              R"(}, "body": {"motion": "free", "mass_kg": )" + std::to_string(solids.back().mass_kg) +
              R"(, "angular_damping_N_m_s": 1e-5}})";
    }
    BodyRun run(text + "]");
    const double end_s = seconds(60, 2);
    for (int sample = 0; run.time_s() < end_s; ++sample) {
      run.run(.05);
      fastest_m_s = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        fastest_m_s = std::max(fastest_m_s, run.velocity_m_s(i).norm());
        for (const Vector3d& p : solids[i].surface) {
          const Vector3d at = run.rotation(i) * p + run.position_m(i);
          ASSERT_TRUE(at.allFinite());
          deepest_floor_m = std::max(deepest_floor_m, -at.z());
          if (sample % 5 != 0) continue;
          for (std::size_t j = 0; j < 16; ++j) {
            if (j == i || (at - run.position_m(j)).squaredNorm() > .002) continue;
            deepest_pair_m = std::max(
                deepest_pair_m, solids[j].depth_m(run.rotation(j).conjugate() * (at - run.position_m(j))));
          }
        }
      }
    }
    left_out += run.renderer().counters().contact_bound;
    figure("heap " + std::to_string(heap) + ": fastest at the end, mm/s", 1e3 * fastest_m_s,
           "< 100: some may still roll");
    EXPECT_LT(fastest_m_s, .1);
  }
  figure("heaps of 16: deepest point below the floor, mm", 1e3 * deepest_floor_m, "< 0.5");
  figure("heaps of 16: deepest point of a body in another one, mm", 1e3 * deepest_pair_m, "< 1");
  figure("heaps of 16: contact points left out", left_out, "");
  EXPECT_LT(deepest_floor_m, 5e-4);
  EXPECT_LT(deepest_pair_m, 1e-3);
}

}  // namespace
}  // namespace thimble::test
