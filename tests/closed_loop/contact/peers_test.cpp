// The probe paths with which existing haptic engines were measured: their errors, and the limits for this
// renderer.
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
#include "tests/support/peer_path.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

constexpr int kFewer = kUnderSanitizers ? 20 : 1;  // a twentieth of the ticks under the sanitizers

const host::MeshOptions kFlat = {};
const host::MeshOptions kShaded = {host::MeshSide::kOutside, 60.0};

TEST(Peers, NoFallsThroughATenthOfAMillimetre) {
  constexpr int kRuns = 16;
  constexpr int kTicks = 40'000 / kFewer;
  const SceneImage mesh = SceneBuilder().mesh(box_mesh({0.1, 0.1, 0.0001}, 12), {}).image();
  const SceneImage shape = SceneBuilder().box({0.1, 0.1, 0.0001}, {}).image();
  for (const SceneImage* image : {&mesh, &shape}) {
    int falls = 0;
    int silent = 0;
    for (int run_index = 0; run_index < kRuns; ++run_index) {
      Random random(static_cast<std::uint64_t>(100 + run_index));
      IdealRun run(*image);
      // Up to 3 mm through and far beyond the other face, at up to 0.15 m/s with encoder noise; odd runs also
      // jump sideways.
      for (int tick = 0; tick < kTicks; ++tick) {
        const double t = tick / kRate_Hz;
        Vector3d p(0.03 * std::sin(2.9 * t + run_index), 0.03 * std::sin(4.1 * t),
                   -0.001 + 0.002 * std::cos(7.0 * t));
        p += 2e-6 * Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
        if (run_index % 2 == 1) p += random.in_box({0.002, 0.002, 0.0005});
        const Felt& felt = run.step(p);
        if (felt.god_object_m.z() < 0.00005 - 1e-6) ++falls;
        if (felt.tip_m.z() < 0.00005 - 1e-6 && felt.force_N.z() <= 0.0) ++silent;
      }
    }
    const std::string what = std::string("0.1 mm plate, ") + (image == &mesh ? "mesh" : "box") + ", 16 x " +
                             std::to_string(kTicks);
    figure(what + " ticks: falls", falls, "0");
    figure(what + " ticks: under it without force", silent, "0");
    EXPECT_EQ(falls, 0);
    EXPECT_EQ(silent, 0);
  }
}

TEST(Peers, NoFallsThroughTheRimOfAPlate) {
  const SceneImage mesh = SceneBuilder().mesh(box_mesh({0.03, 0.03, 1e-4}, 5), {}).image();
  const SceneImage shape = SceneBuilder().box({0.03, 0.03, 1e-4}, {}).image();
  for (const SceneImage* image : {&mesh, &shape}) {
    Random random(19);
    IdealRun run(*image);
    int missed = 0;
    constexpr int kEntries = 20'000 / kFewer;
    for (int entry = 0; entry < kEntries; ++entry) {
      const double side = random.below(2) == 0 ? 1.0 : -1.0;
      const Vector3d outside(side * (0.015 + random.uniform(1e-5, 0.002)), random.uniform(-0.0145, 0.0145),
                             random.uniform(-4.5e-5, 4.5e-5));
      run.restart(outside);
      const double depth = random.uniform(1e-5, 0.003);
      const Felt& felt =
          run.step({side * (0.015 - depth), outside.y(), outside.z() + random.uniform(-2e-6, 2e-6)});
      if (felt.contacts < 1 || felt.force_N.x() * side < 0.9 * kDefaultStiffness_N_m * depth - 1e-4) ++missed;
    }
    figure(std::string("rim of a 0.1 mm plate, ") + (image == &mesh ? "mesh" : "box") +
               ": entries missed, of " + std::to_string(kEntries),
           missed, "0");
    EXPECT_EQ(missed, 0);
  }
}

TEST(Peers, NoFallsOnSharedVerticesAndEdges) {
  struct Body {
    std::string name;
    host::TriangleSoup soup;
  };
  const std::vector<Body> bodies = {{"icosphere 1280", icosphere(3, 0.05)},
                                    {"flat lattice", box_mesh({0.1, 0.1, 0.02}, 10)},
                                    {"torus", torus(0.03, 0.012, 24, 12)},
                                    {"uv sphere", uv_sphere(24, 12, 0.05)},
                                    {"terrain", hostile_terrain(16, 0.002, 0.002, 4)}};
  int drops = 0;
  int falls = 0;
  int inside = 0;
  for (const Body& body : bodies) {
    const host::CompiledMesh mesh = host::compile_mesh(body.soup, kFlat, body.name);
    const host::TriangleSoup soup = as_soup(mesh);
    const MeshOracle oracle(soup);
    const SceneImage image = SceneBuilder().mesh(mesh, {}).image();
    IdealRun run(image);
    std::vector<Vector3d> normals(soup.vertices_m.size(), Vector3d::Zero());
    for (std::uint32_t t = 0; t < soup.triangles.size(); ++t) {
      for (const std::uint32_t v : soup.triangles[t]) normals[v] += oracle.normal(t);
    }
    const auto drop = [&](const Vector3d& target, const Vector3d& way_out) {
      const Vector3d n = way_out.normalized();
      const Vector3d above = target + 0.0005 * n;
      if (oracle.crosses(target + 1e-7 * n, above)) return;  // not in sight from above
      ++drops;
      run.restart(above);
      bool fell = false;
      for (const double height : {0.0003, 0.0001, 0.0, -0.0001, -0.0003, -0.0005}) {
        const Felt& felt = run.step(target + height * n);
        const double side = oracle.signed_distance(felt.tip_m, 1e-3);
        if (side < -2e-6 && felt.force_N.norm() < 0.5 * kDefaultStiffness_N_m * -side) fell = true;
        if (oracle.signed_distance(felt.god_object_m, 1e-3) < -1e-6) ++inside;
      }
      if (fell) ++falls;
    };
    for (std::size_t v = 0; v < soup.vertices_m.size(); ++v) drop(soup.vertices_m[v], normals[v]);
    for (const auto& triangle : soup.triangles) {
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t a = triangle[e];
        const std::uint32_t b = triangle[(e + 1) % 3];
        if (a < b) drop(0.5 * (soup.vertices_m[a] + soup.vertices_m[b]), normals[a] + normals[b]);
      }
    }
  }
  figure("drops exactly on shared vertices and edges", drops, ">= 2237");
  figure("drops: falls", falls, "0");
  figure("drops: god object inside by more than 1 um, ticks", inside, "0");
  EXPECT_GE(drops, 2237);
  EXPECT_EQ(falls, 0);
  EXPECT_EQ(inside, 0);
}

TEST(Peers, NoFallsOnHostileTerrain) {
  constexpr int kTicks = 400'000 / kFewer;
  constexpr double kHeight_m = 0.002;
  const host::CompiledMesh mesh =
      host::compile_mesh(hostile_terrain(64, 0.001, kHeight_m, 6), kFlat, "terrain");
  const MeshOracle oracle(as_soup(mesh));
  for (const bool friction : {false, true}) {
    const Material material =
        friction ? Material{.static_friction = 0.6F, .dynamic_friction = 0.4F} : Material{};
    const SceneImage image = SceneBuilder().mesh(mesh, material).image();
    IdealRun run(image);
    Random random(13);
    int falls = 0;
    int silent = 0;
    double deepest = 0.0;
    run.step({0.0, 0.0, 0.02});
    for (int tick = 0; tick < kTicks; ++tick) {
      const double t = tick / kRate_Hz;
      Vector3d p(0.024 * std::sin(1.9 * t), 0.024 * std::sin(2.3 * t), 0.0045 * std::sin(5.3 * t) + 0.001);
      p += 2e-6 * Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
      const Felt& felt = run.step(p);
      const double god = oracle.signed_distance(felt.god_object_m, 1e-3);
      deepest = std::min(deepest, god);
      if (god < -1e-6) ++falls;
      if (felt.contacts == 0 && oracle.signed_distance(felt.tip_m, 1e-3) < -1e-6) ++silent;
    }
    const std::string what = std::string("hostile terrain") + (friction ? ", friction, " : ", ") +
                             std::to_string(kTicks) + " ticks: ";
    figure(what + "falls", falls, "0");
    figure(what + "tip inside without contact", silent, "0");
    figure(what + "god object's deepest, um", 1e6 * deepest, ">= -1");
    EXPECT_EQ(falls, 0);
    EXPECT_EQ(silent, 0);
  }
}

TEST(Peers, VGrooveForceIsExactToAMicrometre) {
  for (const double angle_deg : {40.0, 60.0, 90.0, 120.0, 150.0}) {
    const double half = angle_deg / 360.0 * std::numbers::pi;
    const Vector3d left_n(std::cos(half), 0.0, std::sin(half));
    const Vector3d right_n(-std::cos(half), 0.0, std::sin(half));
    const SceneImage image = SceneBuilder().mesh(v_groove(angle_deg, 0.02, 0.2, 13), {}).image();
    IdealRun run(image);
    Random random(14);
    run.step({0.0, 0.0, 0.001});
    double worst_m = 0.0;
    for (int tick = 0; tick < 40'000 / kFewer; ++tick) {
      const double t = tick / kRate_Hz;
      const double depth = 0.003 + 0.001 * std::sin(8.0 * t);
      // Across the groove too, as far as both walls still push.
      const double across = 0.9 * depth * std::tan(std::numbers::pi / 2.0 - half) * std::sin(13.0 * t);
      Vector3d p(std::clamp(across, -0.003, 0.003), 0.06 * std::sin(2.0 * t), -depth);
      p += 2e-6 * Vector3d(random.gaussian(), random.gaussian(), random.gaussian());
      const Felt& felt = run.step(p);
      // The walls' own share: solve the two depths for the pushes along the two normals; here that is the
      // bottom line itself.
      const Vector3d bottom(0.0, felt.tip_m.y(), 0.0);
      if (left_n.dot(felt.tip_m) >= 0.0 || right_n.dot(felt.tip_m) >= 0.0) continue;
      const Vector3d to_bottom = bottom - felt.tip_m;
      // Both walls push only while the way to the bottom lies between the two normals.
      const double share = (to_bottom.x() / left_n.x() + to_bottom.z() / left_n.z()) / 2.0;
      const double other = to_bottom.z() / left_n.z() - share;
      if (share < 0.0 || other < 0.0) continue;
      worst_m = std::max(worst_m,
                         (felt.force_N - kDefaultStiffness_N_m * to_bottom).norm() / kDefaultStiffness_N_m);
    }
    figure("V-groove of " + std::to_string(static_cast<int>(angle_deg)) + " degrees: force error, um at K",
           1e6 * worst_m, "1");
    EXPECT_LE(worst_m, 1e-6);
  }
}

TEST(Peers, JumpsOfFiveMillimetresAlwaysPush) {
  for (const host::MeshOptions& options : {kFlat, kShaded}) {
    const host::CompiledMesh mesh = host::compile_mesh(icosphere(3, 0.05), options, "icosphere");
    const MeshOracle oracle(as_soup(mesh));
    const SceneImage image = SceneBuilder().mesh(mesh, {}).image();
    IdealRun run(image);
    Random random(15);
    Vector3d p(0.0, 0.0, 0.055);
    run.step(p);
    int inside = 0;
    int silent = 0;
    while (inside < 2380) {
      Vector3d next = p + 0.005 * random.direction();
      if (std::abs(next.norm() - 0.05) > 0.006) continue;
      p = next;
      const Felt& felt = run.step(p);
      if (oracle.signed_distance(felt.tip_m) > -1e-6) continue;
      ++inside;
      if (felt.force_N.norm() <= 0.0) ++silent;
    }
    figure(std::string("5 mm jumps, ") + (options.crease_deg ? "shaded" : "flat") +
               ": inside without force, of 2380",
           silent, "0");
    EXPECT_EQ(silent, 0);
  }
}

double direction_error_deg(const Felt& felt) {
  return std::atan2(felt.force_N.cross(felt.tip_m).norm(), felt.force_N.dot(felt.tip_m)) * 180.0 /
         std::numbers::pi;
}

TEST(Peers, DirectionOfTheForce) {
  const host::TriangleSoup soup = icosphere(5, 0.05);
  const std::vector<Vector3d> path = peer_path(MeshOracle(soup), {.ticks = kPeerTicks / kFewer});
  for (const bool shaded : {false, true}) {
    const SceneImage image = SceneBuilder().mesh(soup, {}, shaded ? kShaded : kFlat).image();
    IdealRun run(image);
    double sum = 0.0;
    double squares = 0.0;
    double most = 0.0;
    int count = 0;
    for (const Vector3d& p : path) {
      const Felt& felt = run.step(p);
      if (felt.contacts == 0 || felt.force_N.norm() < 0.5) continue;
      const double error = direction_error_deg(felt);
      sum += error;
      squares += error * error;
      most = std::max(most, error);
      ++count;
    }
    const std::string what =
        std::string("direction @20 480, ") + (shaded ? "shaded" : "flat") + ", degrees: ";
    const double limit = shaded ? 0.05 : 0.58;
    figure(what + "mean", sum / count, shaded ? "0.05" : "0.58");
    figure(what + "RMS", std::sqrt(squares / count), "");
    figure(what + "most", most, "");
    EXPECT_GT(count, kPeerTicks / kFewer / 2);
    EXPECT_LE(sum / count, limit);
  }
}

// Total variation of the force over K times the tip's way. On the sphere itself this path gives 0.07.
TEST(Peers, Ripple) {
  const host::TriangleSoup soup = icosphere(5, 0.05);
  const std::vector<Vector3d> path =
      peer_path_on_sphere(0.05, {.ticks = kPeerTicks / kFewer, .noise_m = 0.0, .lifts = false});
  enum class Body { kSphere, kFacets, kSmooth };
  for (const Body body : {Body::kSphere, Body::kFacets, Body::kSmooth}) {
    SceneBuilder builder;
    if (body == Body::kSphere) {
      builder.sphere(0.05, {});
    } else {
      builder.mesh(soup, {}, body == Body::kSmooth ? kShaded : kFlat);
    }
    const SceneImage image = builder.image();
    IdealRun run(image);
    run.step(1.2 * path.front());
    run.step(path.front());
    double change = 0.0;
    double way = 0.0;
    double squares = 0.0;
    std::vector<double> ratios;
    for (std::size_t tick = 1; tick < path.size(); ++tick) {
      const Felt before = run.felt();
      const Felt& felt = run.step(path[tick]);
      const double dx = (felt.tip_m - before.tip_m).norm();
      const double df = (felt.force_N - before.force_N).norm();
      change += df;
      way += dx;
      if (dx > 0.0) ratios.push_back(df / (kDefaultStiffness_N_m * dx));
      squares += std::pow(ratios.back(), 2);
    }
    std::sort(ratios.begin(), ratios.end());
    const std::string name = body == Body::kSphere ? "sphere" : body == Body::kFacets ? "flat" : "shaded";
    const std::string what = "ripple @20 480, " + name + ": ";
    const double total = change / (kDefaultStiffness_N_m * way);
    figure(what + "total |dF| / (K |dx|)", total, body == Body::kFacets ? "" : "0.08");
    figure(what + "median", ratios[ratios.size() / 2], "0.08");
    figure(what + "RMS", std::sqrt(squares / static_cast<double>(ratios.size())), "");
    figure(what + "99 %", ratios[ratios.size() * 99 / 100], "");
    figure(what + "most", ratios.back(), "");
    EXPECT_LE(ratios[ratios.size() / 2], 0.08);
    if (body != Body::kFacets) {
      EXPECT_LE(total, 0.08);
    }
  }
}

// Press 2 mm, slide 90 degrees round at constant depth, release: the work on the hand over 1/2 K d^2.
struct Loops {
  double mean = 0;
  double most = -1e9;
  double least = 1e9;
  int give = 0;
};

Loops arc_loops(const SceneImage& image, int loops, std::uint64_t seed) {
  constexpr double kRadius_m = 0.05;
  constexpr double kDepth_m = 0.002;
  constexpr double kStep_m = 2.5e-5;
  Random random(seed);
  IdealRun run(image);
  Loops result;
  for (int loop = 0; loop < loops; ++loop) {
    const Vector3d start = random.direction();
    const Vector3d side = start.cross(random.direction()).normalized();
    const auto at = [&](double angle, double radius) {
      return Vector3d(radius * (std::cos(angle) * start + std::sin(angle) * side.cross(start)));
    };
    run.restart(at(0.0, kRadius_m + 0.001));
    run.move(at(0.0, kRadius_m - kDepth_m), kStep_m);
    for (double angle = 0.0; angle < std::numbers::pi / 2.0; angle += kStep_m / kRadius_m)
      run.step(at(angle, kRadius_m - kDepth_m));
    run.move(at(std::numbers::pi / 2.0, kRadius_m - kDepth_m), kStep_m);
    run.move(at(std::numbers::pi / 2.0, kRadius_m + 0.001), kStep_m);
    EXPECT_EQ(run.felt().force_N.norm(), 0.0);
    const double energy = run.work_on_hand_J() / (0.5 * kDefaultStiffness_N_m * kDepth_m * kDepth_m);
    result.mean += energy / loops;
    result.most = std::max(result.most, energy);
    result.least = std::min(result.least, energy);
    if (run.work_on_hand_J() > kDefaultStiffness_N_m * run.longest_step_m() * run.deepest_m()) ++result.give;
  }
  return result;
}

TEST(Peers, AFrictionlessLoopKeepsItsEnergy) {
  for (const bool shaded : {false, true}) {
    const SceneImage image = SceneBuilder().mesh(icosphere(5, 0.05), {}, shaded ? kShaded : kFlat).image();
    const Loops loops = arc_loops(image, 60, 16);
    const std::string what =
        std::string("frictionless loop @20 480, ") + (shaded ? "shaded" : "flat") + ", in 1/2 K d^2: ";
    figure(what + "mean", loops.mean, "+-0.05");
    figure(what + "most", loops.most, "0.05");
    figure(what + "least", loops.least, "");
    EXPECT_LE(std::abs(loops.mean), 0.05);
    EXPECT_LE(loops.most, 0.05);
    EXPECT_EQ(loops.give, 0);
  }
}

TEST(Peers, ShadingGivesNoEnergy) {
  const SceneImage image = SceneBuilder().mesh(icosphere(3, 0.05), {}, kShaded).image();
  const Loops loops = arc_loops(image, 60, 17);
  figure("shading @1280: loops that give more than K T v x, of 60", loops.give, "0");
  figure("shading @1280: most energy in 1/2 K d^2", loops.most, "0.0125, twice the step over the depth");
  EXPECT_EQ(loops.give, 0);
}

TEST(Peers, SteadyFrictionOnAMesh) {
  const Material steady = {
      .static_friction = 0.6F, .dynamic_friction = 0.4F, .friction_mode = scene::FrictionMode::Steady};
  const SceneImage image = SceneBuilder().mesh(box_mesh({0.2, 0.2, 0.02}, 40), steady).image();
  for (const double speed_m_s : {0.02, 0.1, 0.3}) {
    IdealRun run(image);
    run.step({-0.06, 0.013, 0.011});
    run.move({-0.06, 0.013, 0.008}, 2.5e-5);
    double sum = 0.0;
    int count = 0;
    for (double x = -0.06; x < 0.06; x += speed_m_s / kRate_Hz) {
      const Felt& felt = run.step({x, 0.013 + 0.3 * x, 0.008});
      if (x < -0.055) continue;
      sum += felt.force_N.head<2>().norm() / felt.force_N.z();
      ++count;
    }
    const std::string speed = std::to_string(speed_m_s).substr(0, 4);
    figure("steady |F_t|/F_n on a mesh at " + speed + " m/s, mean", sum / count, "0.398 to 0.402");
    EXPECT_NEAR(sum / count, 0.4, 0.002);
  }
}

}  // namespace
}  // namespace thimble::test
