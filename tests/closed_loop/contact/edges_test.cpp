// Edges, corners and curved meshes against the god object by its definition (tests/support/oracle.h).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

TEST(Oracle, AgreesWithClosedForms) {
  Random random(9);
  const MeshOracle box(box_mesh({0.1, 0.1, 0.1}, 3));
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Vector3d p = random.in_box(Vector3d::Constant(0.08));
    const Vector3d outside = (p.cwiseAbs() - Vector3d::Constant(0.05));
    const double exact = outside.maxCoeff() < 0.0 ? outside.maxCoeff() : outside.cwiseMax(0.0).norm();
    worst = std::max(worst, std::abs(box.signed_distance(p) - exact));
  }
  figure("oracle: signed distance to a box, m", worst, "1e-12");
  EXPECT_LE(worst, 1e-12);
  ReferenceGodObject reference(box);
  reference.place({0.01, 0.0, 0.06});
  EXPECT_TRUE(reference.follow({0.02, 0.01, 0.04}));
  EXPECT_LE((reference.position() - Vector3d(0.02, 0.01, 0.05)).norm(), 5e-8);
  EXPECT_TRUE(reference.follow({0.049, 0.01, 0.04}));  // nearer to the side, yet still under the top
  EXPECT_LE((reference.position() - Vector3d(0.049, 0.01, 0.05)).norm(), 5e-8);
  EXPECT_TRUE(reference.follow({0.051, 0.01, 0.04}));  // beyond the edge: free
  EXPECT_LE((reference.position() - Vector3d(0.051, 0.01, 0.04)).norm(), 5e-8);
  EXPECT_EQ(box.crossings({0.0, 0.001, 0.2}, {0.0, 0.001, -0.2}).size(), 2U);
}

TEST(BoxShape, GodObjectSlidesToTheEdgeAndThenOverIt) {
  const SceneImage image = SceneBuilder().box({0.1, 0.1, 0.1}, {}).image();
  const SceneImage mesh = SceneBuilder().mesh(box_mesh({0.1, 0.1, 0.1}, 3), {}).image();
  for (const SceneImage* scene : {&image, &mesh}) {
    IdealRun run(*scene);
    // The tip crosses the vertical through the edge and then goes under: the god object follows round.
    run.step({0.03, 0.0, 0.051});
    run.move({0.03, 0.0, 0.046}, 1e-4);
    double worst = 0.0;
    for (double x = 0.03; x < 0.05; x += 1e-4) {
      const Felt& felt = run.step({x, 0.0, 0.046});
      worst = std::max(worst, (felt.god_object_m - Eigen::Vector3d(felt.tip_m.x(), 0.0, 0.05)).norm());
    }
    const Felt over = run.step({0.0501, 0.0, 0.046});
    EXPECT_EQ(over.contacts, 0);
    EXPECT_EQ(over.force_N.norm(), 0.0);
    const Felt side = run.step({0.0465, 0.0, 0.046});
    worst = std::max(worst, (side.god_object_m - Eigen::Vector3d(0.05, 0.0, 0.046)).norm());
    figure(std::string("box edge, ") + (scene == &image ? "shape" : "mesh") + ": god object's error, m",
           worst, "1e-6");
    EXPECT_LE(worst, 1e-6);
  }
}

struct Wandered {
  std::string name;
  host::TriangleSoup soup;
  double reach_m;  // the tip wanders in a shell of +-3 mm about this radius, or in this box when it is 0
  bool as_box = false;
};

// Under a flat face the god object goes straight to the point over the tip, however near another face of the
// body is to the tip.
TEST(Meshes, SlideStraightOverAFlatFaceNearOtherFaces) {
  for (const double angle_deg : {8.0, 25.0, 60.0}) {
    constexpr double kHeight_m = 0.03;
    const double half_m = kHeight_m * std::tan(angle_deg / 360.0 * std::numbers::pi);
    const SceneImage image = SceneBuilder().mesh(knife(angle_deg, kHeight_m, 0.05, 9), {}).image();
    Random random(20);
    IdealRun run(image);
    int wrong = 0;
    constexpr int kJumps = 20000;
    for (int jump = 0; jump < kJumps; ++jump) {
      const Vector3d from(0.97 * half_m * random.uniform(-1.0, 1.0), random.uniform(-0.02, 0.02), -kHeight_m);
      const Vector3d to(std::clamp(from.x() + random.uniform(-0.003, 0.003), -0.97 * half_m, 0.97 * half_m),
                        from.y() + random.uniform(-0.004, 0.004), -kHeight_m);
      run.restart(from - Vector3d(0.0, 0.0, 1e-4));
      run.step(from + Vector3d(0.0, 0.0, 1e-5));
      const Felt& felt = run.step(to + Vector3d(0.0, 0.0, random.uniform(1e-5, 0.004)));
      if ((felt.god_object_m - to).norm() > 1e-6) ++wrong;
    }
    figure("flat side of a knife of " + std::to_string(static_cast<int>(angle_deg)) +
               " degrees: slides gone astray, of 20000",
           wrong, "0");
    EXPECT_EQ(wrong, 0);
  }
}

// A point just off the faces that p lies on, on their free side.
Vector3d lifted(const MeshOracle& oracle, const Vector3d& p) {
  std::vector<std::uint32_t> faces;
  oracle.near(p, 1e-7, faces);
  Vector3d away = Vector3d::Zero();
  for (const std::uint32_t face : faces) away += oracle.normal(face);
  return faces.empty() ? p : Vector3d(p + 2e-7 * away.normalized());
}

// A smooth random walk of the tip near a body's surface: through faces, over edges and corners, in and out.
TEST(Meshes, FollowTheGodObjectByItsDefinition) {
  std::vector<Wandered> bodies;
  bodies.push_back({"box shape", box_mesh({0.03, 0.03, 0.03}, 1), 0.0, true});
  bodies.push_back({"box mesh", box_mesh({0.03, 0.03, 0.03}, 2), 0.0});
  bodies.push_back({"icosphere 80", icosphere(1, 0.02), 0.019});
  bodies.push_back({"icosphere 1280", icosphere(3, 0.02), 0.019});
  bodies.push_back({"uv sphere", uv_sphere(48, 12, 0.02), 0.019});
  bodies.push_back({"torus", torus(0.015, 0.006, 24, 12), 0.015});
  bodies.push_back({"groove", v_groove(70.0, 0.01, 0.05, 4), 0.006});
  bodies.push_back({"knife", knife(25.0, 0.03, 0.04, 4), 0.004});
  bodies.push_back({"terrain", hostile_terrain(16, 0.002, 0.003, 3), 0.01});
  constexpr int kTicks = kUnderSanitizers ? 600 : 6000;
  for (const Wandered& body : bodies) {
    const host::CompiledMesh mesh = host::compile_mesh(body.soup, {}, body.name);
    const MeshOracle oracle(as_soup(mesh));
    SceneBuilder builder;
    if (body.as_box) {
      builder.box({0.03, 0.03, 0.03}, {});
    } else {
      builder.mesh(mesh, {});
    }
    const SceneImage image = builder.image();
    Random random(10);
    IdealRun run(image);
    ReferenceGodObject reference(oracle);
    int contacts = 0;
    int branches = 0;
    int unsettled = 0;
    double worst = 0.0;
    Vector3d tip = Vector3d::Zero();
    Vector3d velocity = Vector3d::Zero();
    for (int tick = 0; tick < kTicks; ++tick) {
      if (tick % 300 == 0) {  // from free space
        do {
          tip = 0.03 * random.direction();
        } while (oracle.signed_distance(tip) < 0.001);
        velocity.setZero();
        run.restart(tip);
        reference.place(run.felt().tip_m);
      }
      // Up to 0.4 mm a tick, drawn towards the surface so that most of the time is spent just under it.
      const Nearest nearest = oracle.nearest(tip);
      const double depth = -oracle.signed_distance(tip);
      Vector3d inwards =
          nearest.distance_m > 1e-9 ? Vector3d((nearest.point - tip) / nearest.distance_m) : Vector3d::Zero();
      if (depth > 0.0) inwards = -inwards;
      velocity = 0.95 * velocity + 3e-5 * random.direction() + 2e-2 * (0.0012 - depth) * inwards;
      velocity *= std::min(1.0, 4e-4 / std::max(1e-12, velocity.norm()));
      tip += velocity;
      const Felt& felt = run.step(tip);
      if (felt.contacts > 0) ++contacts;
      bool settled = reference.follow(felt.tip_m);
      double error = (reference.position() - felt.god_object_m).norm();
      if (!settled || error > 1e-6) {
        // Where the way downhill parts, either way is right; but then the renderer's place must hold the
        // reference too.
        const double apart = error;
        reference.place(lifted(oracle, felt.god_object_m));
        settled = reference.follow(felt.tip_m);
        error = (reference.position() - felt.god_object_m).norm();
        if (settled && error <= 1e-6 && apart > 1e-5) ++branches;
      }
      if (!settled) ++unsettled;
      worst = std::max(worst, error);
    }
    figure("oracle, " + body.name + ": ticks in contact, of " + std::to_string(kTicks), contacts, "> half");
    figure("oracle, " + body.name + ": god object's distance from its rest, um", 1e6 * worst, "1");
    figure("oracle, " + body.name + ": other branches taken", branches, std::to_string(kTicks / 200));
    figure("oracle, " + body.name + ": ticks in which the reference did not settle", unsettled, "0");
    EXPECT_GT(contacts, kTicks / 2) << body.name;
    EXPECT_LE(worst, 1e-6) << body.name;
    EXPECT_LE(branches, kTicks / 200) << body.name;
    EXPECT_EQ(unsettled, 0) << body.name;
  }
}

TEST(Symmetry, ForcesTurnAndMirrorWithTheScene) {
  Random random(11);
  const host::TriangleSoup soup = torus(0.03, 0.012, 24, 12);
  const Eigen::Matrix3d mirror = Eigen::Vector3d(-1.0, 1.0, 1.0).asDiagonal();
  const Eigen::Quaterniond turn = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized();
  const Eigen::Vector3d shift(0.01, -0.02, 0.03);
  const Material rough = {.static_friction = 0.6F, .dynamic_friction = 0.4F};
  for (const bool friction : {false, true}) {
    const Material material = friction ? rough : Material{};
    const SceneImage plain = SceneBuilder().mesh(soup, material).image();
    const SceneImage posed = SceneBuilder().mesh(soup, material, {}, {shift, turn}).image();
    const SceneImage mirrored =
        SceneBuilder().mesh(transformed(soup, mirror, Vector3d::Zero()), material).image();
    IdealRun a(plain);
    IdealRun b(posed);
    IdealRun c(mirrored);
    double worst_N = 0.0;
    int apart = 0;
    constexpr int kTicks = 40000;
    for (int tick = 0; tick < kTicks; ++tick) {
      const double t = tick / kRate_Hz;
      const double ring = 2.0 * std::numbers::pi * 0.31 * t;
      const double tube = 2.0 * std::numbers::pi * 0.73 * t;
      const double r = 0.0115 - 0.0015 * std::sin(2.0 * std::numbers::pi * 1.3 * t);
      const double out = 0.03 + r * std::cos(tube);
      const Vector3d p(out * std::cos(ring), out * std::sin(ring), r * std::sin(tube));
      const Vector3d force = a.step(p).force_N;
      const double turned = (turn * force - b.step(turn * p + shift).force_N).norm();
      const double flipped = (mirror * force - c.step(mirror * p).force_N).norm();
      const double error = std::max(turned, flipped);
      // Rounding may move a crossing of an edge, or a slip, to the next tick.
      if (error > 1e-3) {
        ++apart;
      } else {
        worst_N = std::max(worst_N, error);
      }
    }
    const std::string what = friction ? "symmetry, with friction: " : "symmetry: ";
    figure(what + "force error, N", worst_N, "1e-3");
    figure(what + "ticks apart at an edge or a slip, of 40000", apart, "40");
    EXPECT_LE(worst_N, 1e-3);
    EXPECT_LE(apart, 40);
  }
}

TEST(Refinement, AnIcospheresForceTendsToTheSpheres) {
  double magnitude_before = 0.0;
  double shaded_before = 0.0;
  for (int subdivisions = 2; subdivisions <= 5; ++subdivisions) {
    const host::TriangleSoup soup = icosphere(subdivisions, 0.05);
    const SceneImage flat = SceneBuilder().mesh(soup, {}).image();
    const SceneImage shaded = SceneBuilder().mesh(soup, {}, {host::MeshSide::kOutside, 60.0}).image();
    IdealRun flat_run(flat);
    IdealRun shaded_run(shaded);
    double magnitude = 0.0;
    double vector = 0.0;
    int count = 0;
    for (int tick = 0; tick < 40000; ++tick) {
      const double t = tick / kRate_Hz;
      const double lon = 2.0 * std::numbers::pi * 0.3 * t;
      const double lat = std::sin(2.0 * std::numbers::pi * 0.37 * t);
      const Vector3d out(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat));
      const double radius = 0.055 - 0.009 * std::min(1.0, t / 0.1);
      const Felt& felt = flat_run.step(radius * out);
      const Vector3d shaded_force = shaded_run.step(radius * out).force_N;
      if (t < 0.1) continue;
      const Vector3d expected = 1000.0 * (0.05 / felt.tip_m.norm() - 1.0) * felt.tip_m;
      magnitude += std::pow(felt.force_N.norm() - expected.norm(), 2);
      vector += (shaded_force - expected).squaredNorm();
      ++count;
    }
    magnitude = std::sqrt(magnitude / count);
    vector = std::sqrt(vector / count);
    const std::string what = "refinement, " + std::to_string(soup.triangles.size()) + " triangles: ";
    figure(what + "RMS error of |F|, flat, N", magnitude, "a quarter of the last");
    figure(what + "RMS error of F, shaded, N", vector, "a quarter of the last");
    if (subdivisions > 2) {
      EXPECT_LE(magnitude, magnitude_before / 3.5);
      EXPECT_LE(vector, shaded_before / 3.5);
    }
    magnitude_before = magnitude;
    shaded_before = vector;
  }
}

}  // namespace
}  // namespace thimble::test
