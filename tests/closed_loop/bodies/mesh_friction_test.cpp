// Static friction of bodies on level meshes and height fields: it is that of a plane, however the ground is cut into triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "tests/closed_loop/bodies/mesh_bodies.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

host::TriangleSoup level(int cells) {
  host::TriangleSoup soup = box_mesh({.6, .6, .05}, cells);
  for (Vector3d& p : soup.vertices_m) p.z() -= .025;
  return soup;
}

double level_m(double, double) { return 0; }

class MeshFriction : public MeshBodies {};

struct Composition {
  std::string shape;
  double height_m = 0;  // of its origin
  Vector3d at_m;
  double turned_deg = 0;
  double mass_kg = 0;
  double static_friction = 0;
  double dynamic_friction = 0;
  double direction_rad = 0;  // of the pull
};

// How far it slides in the last of the time when it is pulled along the ground by a part of its static friction.
double slid_m(const std::string& floor, const Composition& c, double part) {
  const double g = 9.81 / std::hypot(1, c.static_friction * part);
  const double along = g * c.static_friction * part;
  BodyRun run(R"("gravity_m_s2": )" +
              list({along * std::cos(c.direction_rad), along * std::sin(c.direction_rad), -g}) +
              R"(, "materials": {"wood": {"stiffness_N_m": 2000, "static_friction": )" +
              std::to_string(c.static_friction) + R"(, "dynamic_friction": )" +
              std::to_string(c.dynamic_friction) + R"(}}, "objects": [)" +
              object("floor", floor, Vector3d::Zero(), "") + "," +
              object("body", c.shape, c.at_m,
                     R"(, "body": {"motion": "free", "mass_kg": )" + std::to_string(c.mass_kg) + "}",
                     {0, 0, c.turned_deg}) +
              "]");
  run.run(.2);
  const Vector3d from = run.position_m(0);
  run.run(.4);
  return (run.position_m(0) - from).norm();
}

TEST_F(MeshFriction, ABodyHoldsUpToItsStaticFriction) {
  const std::array floors = {mesh(level(12)), mesh(level(60)), height_field(61, 61, .6, .6, level_m),
                             height_field(201, 201, .6, .6, level_m)};
  const std::string cube = mesh(box_mesh({.04, .04, .03}, 1));
  const std::string angle =
      mesh(prism({{0, 0}, {.04, 0}, {.04, .015}, {.015, .015}, {.015, .04}, {0, .04}}, .015, 1));
  double held_m = 0;
  double slid = 1;
  Random random(11);
  const int rounds = kUnderSanitizers ? 1 : 5;
  for (int i = 0; i < rounds * static_cast<int>(floors.size()); ++i) {
    const std::string& floor = floors.at(static_cast<std::size_t>(i) % floors.size());
    const double radius = random.uniform(.015, .03);
    const double height = random.uniform(.6, 1) * radius;
    const std::string round =
        R"("radius_m": )" + std::to_string(radius) + R"(, "height_m": )" + std::to_string(height) + "}";
    Composition c;
    switch (i / static_cast<int>(floors.size())) {
      case 0:
        c.shape = R"("box": {"size_m": )" + list({2 * radius, 1.5 * radius, height}) + "}";
        c.height_m = height / 2;
        break;
      case 1:
        c.shape = R"("cylinder": {)" + round;
        c.height_m = height / 2;
        break;
      case 2:
        c.shape = R"("cone": {)" + round;
        c.height_m = height / 4;
        break;
      case 3:
        c.shape = cube;
        c.height_m = .015;
        break;
      default:
        c.shape = angle;
        break;
    }
    c.at_m = random.in_box({.03, .03, 0}) + Vector3d(0, 0, c.height_m);
    c.turned_deg = random.uniform(-180, 180);
    c.mass_kg = random.uniform(.05, .4);
    c.static_friction = random.uniform(.2, .45);
    c.dynamic_friction = random.uniform(.5, .9) * c.static_friction;
    c.direction_rad = random.uniform(0, 2 * std::numbers::pi);
    const double held = slid_m(floor, c, .98);
    const double free = slid_m(floor, c, 1.02);
    EXPECT_LT(held, 2e-5) << i << " " << c.shape;
    EXPECT_GT(free, 2e-4) << i << " " << c.shape;
    held_m = std::max(held_m, held);
    slid = std::min(slid, free);
  }
  figure("pulled by 0.98 of the static friction on 4 level grounds: slid, um", 1e6 * held_m, "< 20");
  figure("pulled by 1.02 of it: slid at least, mm", 1e3 * slid, "> 0.2");
}

TEST_F(MeshFriction, ATowerStandsStill) {
  for (const std::string& floor : {mesh(level(12)), height_field(201, 201, .6, .6, level_m)}) {
    std::string text =
        kGravity + std::string(kWood) + R"("objects": [)" + object("floor", floor, Vector3d::Zero(), "");
    constexpr std::size_t kBoxes = 8;
    for (std::size_t i = 0; i < kBoxes; ++i)
      text += "," + object("box " + std::to_string(i), R"("box": {"size_m": [0.04, 0.04, 0.04]})",
                           {.003, .001, .02 + .04 * static_cast<double>(i)}, kFree, {0, 0, 20});
    BodyRun run(text + "]");
    run.run(.1);
    std::array<Vector3d, kBoxes> from;
    for (std::size_t i = 0; i < kBoxes; ++i) from.at(i) = run.position_m(i);
    run.run(kUnderSanitizers ? .2 : 3);
    double moved = 0;
    for (std::size_t i = 0; i < kBoxes; ++i) moved = std::max(moved, (run.position_m(i) - from.at(i)).norm());
    figure("tower of 8 boxes on a level mesh or field: moved in 3 s, um", 1e6 * moved, "< 40");
    EXPECT_LT(moved, 4e-5);
  }
}

}  // namespace
}  // namespace thimble::test
