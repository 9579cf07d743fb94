// Bodies on meshes and height fields, bodies that are meshes, and bodies on tissue.
#include "tests/closed_loop/bodies/mesh_bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/error.h"
#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

TEST_F(MeshBodies, ABallRollsDownAHeightField) {
  constexpr double kSlope = .1;
  const std::string field = height_field(41, 21, .4, .2, [](double x, double) { return -kSlope * x; });
  const double a = std::atan(kSlope);
  const Vector3d start(-.15, .003, kSlope * .15 + .01 / std::cos(a));
  BodyRun run(kGravity + std::string(kWood) + R"("objects": [)" +
              object("field", field, Vector3d::Zero(), "") + "," +
              object("ball", R"("sphere": {"radius_m": 0.01})", start, kFree) + "]");
  run.run(.1);
  const double from = run.velocity_m_s(0).norm();
  double bumped = 0;
  while (run.time_s() < .6) {
    run.tick();
    const Vector3d normal(std::sin(a), 0, std::cos(a));
    bumped = std::max(bumped, std::abs(run.position_m(0).dot(normal) - .01));
  }
  const double gained = (run.velocity_m_s(0).norm() - from) / .5;
  const double expected = 5.0 / 7.0 * 9.81 * std::sin(a);
  figure("ball down a height field of slope 0.1: m/s2", gained, std::to_string(expected) + ", 1 %");
  figure("ball down a height field: off the slope at most, um", 1e6 * bumped, "< 1");
  EXPECT_NEAR(gained, expected, .01 * expected);
  EXPECT_LT(bumped, 1e-6);
  EXPECT_LT(std::abs(run.velocity_m_s(0).y()), 1e-3);
}

// A body at rest: how far it moves and turns in the time after it has settled.
struct Rest {
  double moved_m = 0;
  double turned_rad = 0;
};
Rest rest(BodyRun& run, double settle_s, double then_s) {
  run.run(settle_s);
  const Vector3d at = run.position_m(0);
  const Eigen::Quaterniond as = run.rotation(0);
  Rest out;
  for (const double end = run.time_s() + then_s; run.time_s() < end;) {
    run.tick();
    out.moved_m = std::max(out.moved_m, (run.position_m(0) - at).norm());
    out.turned_rad = std::max(out.turned_rad, run.rotation(0).angularDistance(as));
  }
  return out;
}

host::TriangleSoup rough(double amplitude_m, int cells, double cell_m, std::uint64_t seed) {
  Random random(seed);
  host::TriangleSoup soup = box_mesh({cells * cell_m, cells * cell_m, .02}, cells);
  for (Vector3d& p : soup.vertices_m) {
    p.z() -= .01;
    if (p.z() > -.001) p.z() += random.uniform(-amplitude_m, amplitude_m);
  }
  return soup;
}

TEST_F(MeshBodies, ABallRollsOverFlatTrianglesWithoutABump) {
  for (const std::string& floor :
       {mesh(rough(0, 40, .01, 1)), height_field(101, 101, .4, .4, [](double, double) { return 0.0; })}) {
    BodyRun run(
        kGravity + std::string(kWood) + R"("objects": [)" + object("floor", floor, Vector3d::Zero(), "") +
        "," +
        object(
            "ball", R"("sphere": {"radius_m": 0.01})", {-.15, -.013, .01},
            R"(, "body": {"motion": "free", "mass_kg": 0.1, "velocity_m_s": [0.6, 0.07, 0], "spin_rad_s": [-7, 60, 0]})") +
        "]");
    run.run(.02);
    const Vector3d from = run.velocity_m_s(0);
    double highest = -1;
    double lowest = 1;
    while (run.time_s() < .4) {
      run.tick();
      highest = std::max(highest, run.position_m(0).z());
      lowest = std::min(lowest, run.position_m(0).z());
    }
    figure("ball over flat triangles: rise and fall, um", 1e6 * (highest - lowest), "< 0.2");
    figure("ball over flat triangles: speed lost, mm/s", 1e3 * (from - run.velocity_m_s(0)).norm(), "< 2");
    EXPECT_LT(highest - lowest, 2e-7);
    EXPECT_LT((from - run.velocity_m_s(0)).norm(), 2e-3);
  }
}

TEST_F(MeshBodies, EveryShapeRestsOnRoughGround) {
  const std::array grounds = {mesh(rough(.001, 30, .004, 3)), mesh(rough(.001, 30, .004, 6))};
  for (const std::string& ground : grounds)
    for (const std::string shape :
         {R"("box": {"size_m": [0.03, 0.03, 0.02]})", R"("cylinder": {"radius_m": 0.015, "height_m": 0.02})",
          R"("cone": {"radius_m": 0.02, "height_m": 0.02})"}) {
      BodyRun run(kGravity + std::string(kWood) + R"("objects": [)" +
                  object("ground", ground, Vector3d::Zero(), "") + "," +
                  object("body", shape, {.003, .001, .014}, kFree, {0, 0, 20}) + "]");
      const Rest still = rest(run, .6, kUnderSanitizers ? .1 : .4);
      figure("on rough ground, " + shape + ": moved in 0.4 s, um", 1e6 * still.moved_m, "< 20");
      figure("on rough ground, " + shape + ": turned, mrad", 1e3 * still.turned_rad, "< 2");
      figure("on rough ground, " + shape + ": height, mm", 1e3 * run.position_m(0).z(), "> 4");
      EXPECT_LT(still.moved_m, 2e-5);
      EXPECT_LT(still.turned_rad, 2e-3);
      EXPECT_GT(run.position_m(0).z(), .004);
    }
}

host::TriangleSoup rough_sheet(double amplitude_m, int cells, double size_m, std::uint64_t seed) {
  Random random(seed);
  host::TriangleSoup soup = sheet(size_m, cells);
  for (Vector3d& p : soup.vertices_m) p.z() += random.uniform(-amplitude_m, amplitude_m);
  return soup;
}

// Bodies thrown on to fine and coarse, level, rough and steep ground, open and closed: more triangles than the bounds let a
// body meet. No body's origin is ever below the lowest place of the ground.
TEST_F(MeshBodies, NoBodyFallsThroughTheGround) {
  const std::array grounds = {mesh(rough_sheet(0, 60, .12, 1)), mesh(rough_sheet(.0003, 120, .12, 2)),
                              mesh(rough(.002, 40, .003, 3)), mesh(rough(.004, 12, .01, 4))};
  const std::array lowest_m = {0.0, -.0003, -.002, -.004};
  const std::array shapes = {std::string(R"("box": {"size_m": [0.03, 0.02, 0.01]})"),
                             std::string(R"("cylinder": {"radius_m": 0.012, "height_m": 0.03})"),
                             std::string(R"("cone": {"radius_m": 0.015, "height_m": 0.02})"),
                             std::string(R"("capsule": {"radius_m": 0.005, "height_m": 0.03})"),
                             std::string(R"("sphere": {"radius_m": 0.006})"),
                             mesh(icosphere(2, .012)),
                             mesh(torus(.012, .004, 24, 12))};
  Random random(5);
  double deepest_m = -1;
  int bounds = 0;
  for (std::size_t g = 0; g < grounds.size(); ++g) {
    std::string text =
        kGravity + std::string(kWood) + R"("objects": [)" + object("g", grounds[g], Vector3d::Zero(), "");
    for (const std::string normal : {"[1, 0, 0]", "[-1, 0, 0]", "[0, 1, 0]", "[0, -1, 0]"})
      text += R"(, {"name": "wall )" + normal + R"(", "material": "wood", "shape": {"plane": {"normal": )" +
              normal + R"(, "offset_m": -0.055}}})";
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const Vector3d place =
          random.in_box({.02, .02, 0}) + Vector3d(0, 0, .03 + .03 * static_cast<double>(i));
      const Vector3d velocity = random.in_box({1, 1, 0}) - Vector3d(0, 0, 1 + .3 * static_cast<double>(i));
      text +=
          "," + object("body " + std::to_string(i), shapes[i], place,
                       R"(, "body": {"motion": "free", "mass_kg": 0.05, "velocity_m_s": )" + list(velocity) +
                           R"(, "spin_rad_s": )" + list(20 * random.in_box(Vector3d::Ones())) + "}",
                       180 * random.in_box(Vector3d::Ones()));
    }
    BodyRun run(text + "]");
    while (run.time_s() < (kUnderSanitizers ? .08 : .3)) {
      run.tick();
      for (std::size_t i = 0; i < shapes.size(); ++i)
        deepest_m = std::max(deepest_m, lowest_m.at(g) - run.position_m(i).z());
    }
    bounds += static_cast<int>(run.renderer().counters().contact_bound);
  }
  figure("7 bodies thrown on 4 grounds: deepest origin below the lowest place, mm", 1e3 * deepest_m, "< 0");
  figure("7 bodies thrown on 4 grounds: bounds reached", bounds, "");
  EXPECT_LT(deepest_m, 0);
}

TEST_F(MeshBodies, ABoxStaysOnAFineFlatMeshAndOverItsEdge) {
  const std::string table = mesh(rough(0, 60, .002, 1));  // 0.12 m
  for (const double x : {0.0, .0715}) {                   // over the edge by 0.0265 of 0.06
    BodyRun run(
        kGravity + std::string(kWood) + R"("objects": [)" + object("table", table, Vector3d::Zero(), "") +
        "," +
        object("box", R"("box": {"size_m": [0.06, 0.04, 0.02]})", {x > 0 ? .0565 : 0, .001, .01}, kFree) +
        "]");
    const Rest still = rest(run, .2, kUnderSanitizers ? .1 : .5);
    figure("box on a fine flat mesh, at x = " + std::to_string(x) + ": moved, um", 1e6 * still.moved_m,
           "< 20");
    figure("box on a fine flat mesh: height, mm", 1e3 * run.position_m(0).z(), "10");
    EXPECT_LT(still.moved_m, 2e-5);
    EXPECT_NEAR(run.position_m(0).z(), .01, 5e-5);
  }
}

TEST_F(MeshBodies, TheAsteroidLiesOnATableAndIsPushed) {
  const std::string asteroid =
      R"("mesh": {"file": ")" THIMBLE_SOURCE_DIR R"(/scenes/asteroid/asteroid.plg", "scale": 0.00001})";
  for (const std::string& table :
       {std::string(R"("box": {"size_m": [0.4, 0.4, 0.02]})"), mesh(box_mesh({.4, .4, .02}, 8))}) {
    BodyRun run(
        kGravity + std::string(kWood) + R"("objects": [)" + object("table", table, {0, 0, -.01}, "") + "," +
            object("asteroid", asteroid, {0, 0, .06}, R"(, "body": {"motion": "free", "mass_kg": 0.2})") +
            "]",
        {{.15, 0, .02}});
    const Rest still = rest(run, 3, kUnderSanitizers ? .2 : 1);
    figure("asteroid on a table: height of its origin, mm", 1e3 * run.position_m(0).z(), "> 5");
    figure("asteroid on a table: moved in 1 s, um", 1e6 * still.moved_m, "< 20");
    EXPECT_GT(run.position_m(0).z(), .005);
    EXPECT_LT(still.moved_m, 2e-5);
    const double before = run.position_m(0).x();
    for (int i = 0; i < 4000; ++i) run.tick({{.15 - .15 * i / 4000.0, 0, .02}});
    figure("asteroid pushed by a finger: moved, mm", 1e3 * (run.position_m(0).x() - before), "< -10");
    figure("asteroid pushed: height, mm", 1e3 * run.position_m(0).z(), "> 5");
    EXPECT_LT(run.position_m(0).x() - before, -.01);
    EXPECT_GT(run.position_m(0).z(), .005);
  }
}

TEST_F(MeshBodies, MeshesLieOnAMeshAndOnEachOther) {
  const std::string ground = mesh(rough(.001, 24, .01, 5));
  const std::vector<std::string> shapes = {
      mesh(torus(.015, .006, 24, 12)), mesh(box_mesh({.03, .02, .02}, 2)), mesh(icosphere(2, .012)),
      mesh(prism({{-.015, 0}, {.015, 0}, {.015, .01}, {-.005, .01}, {-.005, .03}, {-.015, .03}}, .02, 1))};
  std::string text =
      kGravity + std::string(kWood) + R"("objects": [)" + object("ground", ground, Vector3d::Zero(), "");
  for (const auto& [n, side] :
       {std::pair(0, Vector3d(1, 0, 0)), {1, {-1, 0, 0}}, {2, {0, 1, 0}}, {3, {0, -1, 0}}}) {
    text += R"(, {"name": "wall )" + std::to_string(n) +
            R"(", "material": "wood", "shape": {"plane": {"normal": )" + list(side) +
            R"(, "offset_m": -0.05}}})";
  }
  Random random(4);
  constexpr int kBodies = 6;
  for (int i = 0; i < kBodies; ++i) {
    text += "," + object("body " + std::to_string(i), shapes[static_cast<std::size_t>(i) % shapes.size()],
                         random.in_box({.02, .02, 0}) + Vector3d(0, 0, .03 + .04 * i),
                         R"(, "body": {"motion": "free", "mass_kg": 0.05, "angular_damping_N_m_s": 2e-5})",
                         180 * random.in_box(Vector3d::Ones()));
  }
  BodyRun run(text + "]");
  double lowest = 1;
  double fastest = 0;
  while (run.time_s() < (kUnderSanitizers ? .3 : 1.2)) {
    run.tick();
    fastest = 0;
    for (std::size_t i = 0; i < kBodies; ++i) {
      lowest = std::min(lowest, run.position_m(i).z());
      fastest = std::max(fastest, run.velocity_m_s(i).norm());
    }
  }
  figure("heap of 6 meshes on a mesh: lowest origin ever, mm", 1e3 * lowest,
         "> -1.5: that of the angle is on its base");
  figure("heap of 6 meshes on a mesh: fastest at the end, mm/s", 1e3 * fastest, "< 150");
  EXPECT_GT(lowest, -.0015);
  EXPECT_LT(fastest, kUnderSanitizers ? 3 : .15);
}

TEST_F(MeshBodies, ABodySinksIntoTissueByItsWeight) {
  for (const std::string shape :
       {R"("sphere": {"radius_m": 0.02})", R"("box": {"size_m": [0.04, 0.04, 0.04]})"}) {
    BodyRun run(
        kGravity + std::string(kWood) +
        R"("objects": [{"name": "pad", "shape": {"tissue": {"size_m": [0.2, 0.2], "contact_radius_m": 0.01,
      "relaxed_stiffness_N_m": 200, "recovery_s": 0.5}}, "material": {"stiffness_N_m": 400, "dynamic_friction": 0.3, "static_friction": 0.3}}, )" +
        object("body", shape, {.01, 0, .021}, kFree) + "]");
    run.run(3);
    const double sunk = .02 - run.position_m(0).z();
    figure("body on tissue, " + shape + ": sunk, mm", 1e3 * sunk,
           std::to_string(1e3 * .1 * 9.81 / 200) + ", 1 %");
    figure("body on tissue: speed, mm/s", 1e3 * run.velocity_m_s(0).norm(), "< 1");
    EXPECT_NEAR(sunk, .1 * 9.81 / 200, .01 * .1 * 9.81 / 200);
    EXPECT_LT(run.velocity_m_s(0).norm(), 1e-3);
  }
}

TEST_F(MeshBodies, WhatWouldNotMeetIsAnErrorWithBothNames) {
  const std::string open_mesh = mesh(sheet(.05, 2));
  const std::string kInertia =
      R"(, "body": {"motion": "free", "mass_kg": 0.1, "inertia_kg_m2": [1e-5, 1e-5, 1e-5]})";
  const std::string needle =
      R"({"name": "other", "material": "wood", "shape": {"needle": {"layers": [{"thickness_m": 0.01, "stiffness_N_m": 100, "tear_N": 1}]}}})";
  const std::string pad =
      R"({"name": "other", "material": "wood", "shape": {"tissue": {"size_m": [0.2, 0.2], "contact_radius_m": 0.01, "relaxed_stiffness_N_m": 900, "recovery_s": 0.5}}})";
  const std::string ball = R"("sphere": {"radius_m": 0.01})";
  for (const std::string& objects : {object("thing", open_mesh, Vector3d::Zero(), kInertia) + "," +
                                         object("other", ball, Vector3d::Zero(), ""),
                                     object("thing", ball, Vector3d::Zero(), kFree) + "," + needle}) {
    try {
      scene_of(std::string(kWood) + R"("objects": [)" + objects + "]");
      ADD_FAILURE() << objects;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "objects-do-not-meet") << error.what();
      EXPECT_NE(std::string(error.what()).find("thing"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("other"), std::string::npos) << error.what();
    }
  }
  // Alone it meets nothing; on tissue that is soft enough for its mass it is held.
  EXPECT_NO_THROW(scene_of(std::string(kWood) + R"("objects": [)" +
                           object("thing", open_mesh, Vector3d::Zero(), kInertia) + "]"));
  EXPECT_NO_THROW(scene_of(std::string(kWood) + R"("objects": [)" +
                           object("thing", ball, Vector3d::Zero(), kFree) + "," + pad + "]"));
}

// It has no surface to lie on: a scene can have both, and the compiler says what happens.
TEST_F(MeshBodies, ABodyPassesThroughAFieldWithAWarning) {
  const std::string vector_field = R"("vector_field": {"subvolumes": [{"plane": {"normal": [0, 0, 1]}}]})";
  const std::string potential_field =
      R"("potential_field": {"shape": {"sphere": {"radius_m": 0.02}}, "step_m": 0.004, "source_per_m": 100})";
  for (const std::string& field : {vector_field, potential_field}) {
    for (const bool slides : {false, true}) {
      const std::string body =
          slides ? R"(, "body": {"motion": "slide", "mass_kg": 0.1, "axis": [1, 0, 0]})" : kFree;
      const std::string text = R"({"thimble_scene": 1, "name": "test", )" + std::string(kGravity) + kWood +
                               R"("objects": [)" + object("field", field, Vector3d::Zero(), "") + "," +
                               object("ball", R"("sphere": {"radius_m": 0.01})", {0, 0, .03}, body) + "]}";
      const host::CompiledScene scene = host::compile_scene_text(text, "test.scene.json", ".");
      const auto& warnings = scene.report.warnings;
      const bool told =
          std::find(warnings.begin(), warnings.end(),
                    "field acts on fingertips only: the body ball passes through it") != warnings.end();
      EXPECT_EQ(told, !slides) << field;
    }
    BodyRun run(kGravity + std::string(kWood) + R"("objects": [)" +
                object("field", field, Vector3d::Zero(), "") + "," +
                object("ball", R"("sphere": {"radius_m": 0.01})", {0, 0, .03}, kFree) + "]");
    run.run(.2);
    figure("ball falls through a field in 0.2 s, mm", 1e3 * (.03 - run.position_m(0).z()), "196.3");
    EXPECT_NEAR(.03 - run.position_m(0).z(), .5 * 9.81 * .04, 1e-3);
  }
}

TEST_F(MeshBodies, AnImageWithBadPiecesIsRefused) {
  const SceneImage image =
      scene_of(std::string(kWood) + R"("objects": [)" +
               object("stone", mesh(torus(.02, .008, 16, 8)), Vector3d::Zero(), kFree) + "]");
  const scene::Mesh& stone = *image.view().scene()->objects()->Get(0)->shape_as_Mesh();
  ASSERT_NE(stone.piece_ends(), nullptr);
  const std::size_t pieces = stone.piece_ends()->size();
  figure("convex pieces of a torus", static_cast<double>(pieces), "3 to 16");
  EXPECT_GT(pieces, 2U);
  EXPECT_LE(pieces, control::kMaxPieces);
  const auto refused = [&](const void* place, auto value) {
    std::vector<std::byte> bytes(image.bytes().begin(), image.bytes().end());
    const std::ptrdiff_t at = static_cast<const std::byte*>(place) - image.bytes().data();
    std::memcpy(bytes.data() + at, &value, sizeof value);
    control::SceneView view;
    return control::SceneView::check(bytes, view) != control::ImageStatus::kOk;
  };
  const std::uint16_t* ends = stone.piece_ends()->data();
  EXPECT_FALSE(refused(ends, ends[0]));
  for (const int end : {0, 3, 65535}) EXPECT_TRUE(refused(ends, static_cast<std::uint16_t>(end))) << end;
  EXPECT_TRUE(refused(ends + pieces - 1, static_cast<std::uint16_t>(ends[pieces - 1] + 1)));
  EXPECT_TRUE(refused(stone.piece_corners()->Get(0), std::numeric_limits<float>::quiet_NaN()));
  EXPECT_TRUE(refused(stone.piece_corners()->Get(0), 11.0F));
}

}  // namespace
}  // namespace thimble::test
