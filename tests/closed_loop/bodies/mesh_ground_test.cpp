// Bodies on height fields with many cells under them. The judge knows the ground as a function and the bodies as points of
// their surface; it takes nothing from the collision code.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/mesh_bodies.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

constexpr double kMass_kg = .1;

struct SampledSolid {
  std::string shape;
  Vector3d inertia;              // of 1 kg, about its origin
  std::vector<Vector3d> points;  // of its surface
};

// Rings round the z axis.
void add_ring(std::vector<Vector3d>& points, double radius, double z) {
  constexpr int kPoints = 36;
  for (int i = 0; i < kPoints; ++i) {
    const double a = 2 * std::numbers::pi * i / kPoints;
    points.emplace_back(radius * std::cos(a), radius * std::sin(a), z);
  }
}

std::string round(double radius, double height) {
  return R"({"radius_m": )" + std::to_string(radius) + R"(, "height_m": )" + std::to_string(height) + "}";
}

SampledSolid cylinder(double r, double h) {
  SampledSolid s{R"("cylinder": )" + round(r, h), {}, {}};
  const double across = (3 * r * r + h * h) / 12;
  s.inertia = {across, across, r * r / 2};
  for (int i = 0; i <= 12; ++i) add_ring(s.points, r, h * (i / 12.0 - .5));
  for (const double part : {.25, .5, .75})
    for (const double z : {-h / 2, h / 2}) add_ring(s.points, part * r, z);
  return s;
}

SampledSolid cone(double r, double h) {
  SampledSolid s{R"("cone": )" + round(r, h), {}, {}};
  const double across = 3 * (r * r / 20 + h * h / 80);
  s.inertia = {across, across, .3 * r * r};
  for (int i = 0; i <= 10; ++i) {
    add_ring(s.points, r * (1 - i / 10.0), h * (i / 10.0 - .25));
    add_ring(s.points, r * i / 10.0, -h / 4);
  }
  return s;
}

SampledSolid box(const Vector3d& size) {
  SampledSolid s{R"("box": {"size_m": )" + list(size) + "}", {}, {}};
  const Vector3d squares = size.cwiseProduct(size);
  s.inertia = (Vector3d::Constant(squares.sum()) - squares) / 12;
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; j <= kSteps; ++j)
      for (int k = 0; k <= kSteps; ++k)
        if (i % kSteps == 0 || j % kSteps == 0 || k % kSteps == 0)
          s.points.push_back((Vector3d(i, j, k) / kSteps - Vector3d::Constant(.5)).cwiseProduct(size));
  return s;
}

SampledSolid capsule(double r, double h) {
  SampledSolid s{R"("capsule": )" + round(r, h), {}, {}};
  const double tube = h / (h + 4.0 / 3 * r);
  const double ends = 1 - tube;
  const double across = tube * (3 * r * r + h * h) / 12 + ends * (.4 * r * r + h * h / 4 + 3 * h * r / 8);
  s.inertia = {across, across, tube * r * r / 2 + ends * .4 * r * r};
  for (int i = 0; i <= 8; ++i) {
    add_ring(s.points, r, h * (i / 8.0 - .5));
    const double a = std::numbers::pi / 2 * i / 8;
    for (const double side : {-1.0, 1.0})
      add_ring(s.points, r * std::cos(a), side * (h / 2 + r * std::sin(a)));
  }
  return s;
}

struct Ground {
  std::size_t columns;  // of a field of 0.3 m
  std::function<double(double, double)> height_m;
};

double energy_J(const BodyRun& run, const std::vector<SampledSolid>& solids) {
  double sum = 0;
  for (std::size_t i = 0; i < solids.size(); ++i) {
    const Vector3d spin = run.rotation(i).conjugate() * run.body(i).spin_rad_s.cast<double>();
    sum += kMass_kg * (.5 * run.velocity_m_s(i).squaredNorm() + 9.81 * run.position_m(i).z() +
                       .5 * spin.cwiseProduct(spin).dot(solids[i].inertia));
  }
  return sum;
}

double depth_m(const BodyRun& run, const std::vector<SampledSolid>& solids, const Ground& ground) {
  double deepest = -1;
  for (std::size_t i = 0; i < solids.size(); ++i)
    for (const Vector3d& of : solids[i].points) {
      const Vector3d p = run.rotation(i) * of + run.position_m(i);
      deepest = std::max(deepest, ground.height_m(p.x(), p.y()) - p.z());
    }
  return deepest;
}

class MeshGround : public MeshBodies {};

// Bumps and hills of cells that are far smaller than the bodies, and of cells of a sixth of them. The field itself is up to
// 0.12 mm off the function between its vertices.
TEST_F(MeshGround, NoBodySinksIntoAFieldOrGainsEnergyFromIt) {
  const auto bumps = [](double x, double y) { return .002 * std::sin(200 * x) * std::cos(190 * y); };
  const auto hills = [](double x, double y) { return .006 * std::sin(40 * x) * std::cos(37 * y); };
  const std::array<Ground, 3> grounds = {{{101, bumps}, {101, hills}, {31, hills}}};
  Random random(17);
  double deepest_m = -1;
  double resting_m = -1;
  double gained = -1;
  const int scenes = kUnderSanitizers ? 4 : 24;
  for (int n = 0; n < scenes; ++n) {
    const Ground& ground = grounds.at(static_cast<std::size_t>(n) % grounds.size());
    const std::string friction = n % 2 == 0 ? "0" : "0.5";
    const std::vector<SampledSolid> kinds = {
        cylinder(random.uniform(.02, .03), random.uniform(.04, .08)),
        box({random.uniform(.04, .06), random.uniform(.04, .06), random.uniform(.02, .04)}),
        capsule(random.uniform(.015, .025), random.uniform(.03, .06)),
        cone(random.uniform(.02, .03), random.uniform(.03, .05))};
    const std::vector<SampledSolid> solids = {kinds.at(static_cast<std::size_t>(n / 3) % kinds.size())};
    std::string text = kGravity +
                       (R"("materials": {"wood": {"stiffness_N_m": 1000, "static_friction": )" + friction) +
                       R"(}}, "objects": [)" +
                       object("ground", height_field(ground.columns, ground.columns, .3, .3, ground.height_m),
                              Vector3d::Zero(), "");
    for (const std::string normal : {"[1, 0, 0]", "[-1, 0, 0]", "[0, 1, 0]", "[0, -1, 0]"})
      text += R"(, {"name": "wall )" + normal + R"(", "material": "wood", "shape": {"plane": {"normal": )" +
              normal + R"(, "offset_m": -0.1}}})";
    text += "," + object("body", solids[0].shape, Vector3d(0, 0, .06) + random.in_box({.04, .04, .005}),
                         R"(, "body": {"motion": "free", "mass_kg": 0.1, "velocity_m_s": )" +
                             list(random.in_box({.3, .3, .3})) + "}",
                         180 * random.in_box(Vector3d::Ones()));
    BodyRun run(text + "]");
    const double start_J = energy_J(run, solids);
    double least_J = start_J;
    const double end_s = kUnderSanitizers ? .2 : 1.5;
    for (int k = 0; run.time_s() < end_s; ++k) {
      run.tick();
      const double now_J = energy_J(run, solids);
      gained = std::max(gained, (now_J - least_J) / start_J);
      least_J = std::min(least_J, now_J);
      if (k % 40 == 0) deepest_m = std::max(deepest_m, depth_m(run, solids, ground));
    }
    resting_m = std::max(resting_m, depth_m(run, solids, ground));
  }
  figure("bodies on fine fields: deepest place below the ground ever, mm", 1e3 * deepest_m, "< 0.5");
  figure("bodies on fine fields: deepest place at the end, mm", 1e3 * resting_m, "< 0.3");
  figure("bodies on fine fields: rise of the energy, part of that of the start", gained, "< 0.01");
  EXPECT_LT(deepest_m, 5e-4);
  EXPECT_LT(resting_m, 3e-4);
  EXPECT_LT(gained, .01);
}

}  // namespace
}  // namespace thimble::test
