// A shaded surface keeps its force: while the tip is inside and moves slowly, the force neither vanishes nor jumps. The
// judges are the distance to the surface (tests/support/oracle.h) and the tip's own motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

struct Surface {
  std::string name;
  host::TriangleSoup soup;
  std::optional<double> crease_deg;
  double deepest_m;  // of the strokes
};

std::vector<Surface> surfaces() {
  std::vector<Surface> list;
  list.push_back({"icosphere 320", icosphere(2, 0.03), 60.0, 0.002});
  list.push_back({"icosphere 80", icosphere(1, 0.03), 60.0, 0.002});
  list.push_back({"icosahedron, crease 180", icosphere(0, 0.03), 180.0, 0.003});
  list.push_back({"torus", torus(0.03, 0.012, 24, 12), 60.0, 0.002});
  list.push_back({"rough terrain, crease 40", hostile_terrain(20, 0.002, 0.002, 5), 40.0, 0.003});
  list.push_back({"rough terrain, crease 180", hostile_terrain(20, 0.002, 0.002, 6), 180.0, 0.003});
  list.push_back({"Collada sphere", test_model("Collada/sphere.dae", 0.06), 60.0, 0.002});
  list.push_back({"terrain of 2 mm, crease 60", hostile_terrain(30, 0.001, 0.0005, 8), 60.0, 0.001});
  return list;
}

struct Tally {
  long inside = 0;
  double fastest = 0.0;  // change of force over K times the motion
  long jumps = 0;
  double least = 1.0;  // force over K times the depth
};

// A place on the surface and the way out there.
struct Spot {
  Vector3d at;
  Vector3d out;
};

Spot random_spot(const host::TriangleSoup& soup, const MeshOracle& oracle, Random& random) {
  const auto index = static_cast<std::uint32_t>(random.below(soup.triangles.size()));
  double a = random.uniform(0.0, 1.0);
  double b = random.uniform(0.0, 1.0);
  if (a + b > 1.0) {
    a = 1.0 - a;
    b = 1.0 - b;
  }
  const Vector3d p = oracle.corner(index, 0);
  return {p + a * (oracle.corner(index, 1) - p) + b * (oracle.corner(index, 2) - p), oracle.normal(index)};
}

void stroke(const Surface& surface, const MeshOracle& oracle, const host::TriangleSoup& soup,
            const SceneImage& image, const Material& material, Random& random, Tally& tally) {
  const double stiffness_N_m = kDefaultStiffness_N_m;
  const double breaks = static_cast<double>(material.static_friction - material.dynamic_friction);
  constexpr double kStep_m = 1e-6;
  constexpr double kClear_m = 1e-4;
  constexpr int kTicks = 4000;
  const Spot spot = random_spot(soup, oracle, random);
  Vector3d tip = spot.at + kClear_m * spot.out;
  if (oracle.signed_distance(tip) <= 0.0) return;
  IdealRun run(image);
  run.step(tip);
  const double deep_m = random.uniform(1e-4, surface.deepest_m);
  Vector3d goal = spot.at - deep_m * spot.out;
  Felt before = run.felt();
  for (int tick = 0; tick < kTicks; ++tick) {
    if (tip == goal) goal = tip + random.uniform(1e-4, 3e-3) * random.direction();
    const Vector3d way = goal - tip;
    tip = way.norm() <= kStep_m ? goal : Vector3d(tip + kStep_m * way.normalized());
    const double height_m = oracle.signed_distance(tip);
    const Felt felt = run.step(tip);
    const double force_N = felt.force_N.norm();
    const double moved_m = (felt.tip_m - before.tip_m).norm();
    if (height_m < -2e-5) {
      ++tally.inside;
      tally.least = std::min(tally.least, -force_N / (stiffness_N_m * height_m));
    }
    if (moved_m > 0.5 * kStep_m && height_m < 0.0) {
      const double broken_N = breaks * std::max(force_N, before.force_N.norm());
      const double change = ((felt.force_N - before.force_N).norm() - broken_N) / (stiffness_N_m * moved_m);
      tally.fastest = std::max(tally.fastest, change);
      if (change > 2.0) ++tally.jumps;
    }
    before = felt;
  }
}

TEST(Shading, KeepsTheForceInside) {
  constexpr int kStrokes = kUnderSanitizers ? 3 : 25;
  for (const Surface& surface : surfaces()) {
    for (const Material& material : {Material{}, Material{.static_friction = 0.4F, .dynamic_friction = 0.4F},
                                     Material{.static_friction = 0.6F, .dynamic_friction = 0.4F}}) {
      const host::CompiledMesh compiled =
          host::compile_mesh(surface.soup, {host::MeshSide::kOutside, surface.crease_deg}, surface.name);
      const host::TriangleSoup soup = as_soup(compiled);
      const MeshOracle oracle(soup);
      const SceneImage image = SceneBuilder().mesh(compiled, material).image();
      Random random(7);
      Tally tally;
      for (int i = 0; i < kStrokes; ++i) stroke(surface, oracle, soup, image, material, random, tally);
      const std::string what =
          surface.name + ", friction " + std::to_string(material.static_friction).substr(0, 3) + ": ";
      figure(what + "ticks inside", static_cast<double>(tally.inside), "");
      figure(what + "least force, K times the depth", tally.least, "0.1");
      figure(what + "jumps of force", static_cast<double>(tally.jumps), "0");
      figure(what + "fastest change of force, K times the motion", tally.fastest, "2");
      EXPECT_GT(tally.inside, kStrokes * 1000);
      EXPECT_GT(tally.least, 0.1);
      EXPECT_EQ(tally.jumps, 0);
    }
  }
}

std::string vector_text(const Vector3d& v) {
  return "[" + std::to_string(v.x()) + ", " + std::to_string(v.y()) + ", " + std::to_string(v.z()) + "]";
}

enum class Beside { kSolid, kMesh, kTexture, kBody, kTexturedBody };

// What a scene allows beyond twice K times the motion.
struct Mixed {
  std::string json;
  double stiffest_N_m = 0.0;
  double breaks = 0.0;  // static less dynamic friction, of the material with the most
  double relief_m = 0.0;
  Vector3d at_m = Vector3d::Zero();
  std::optional<Vector3d> other_m;
  bool moves = false;
};

constexpr double kTile_m = 0.004;

// A shaded icosphere of 320 triangles, and what else `beside` says.
Mixed mixed_scene(Beside beside, Random& random) {
  Mixed scene;
  const auto material = [&](double relief_m) {
    const double stiffness_N_m = 200.0 * std::exp(random.uniform(0.0, 2.0));
    const double friction = random.below(2) == 0 ? 0.0 : random.uniform(0.1, 0.7);
    scene.stiffest_N_m = std::max(scene.stiffest_N_m, stiffness_N_m);
    scene.breaks = std::max(scene.breaks, 0.3 * friction);
    std::string text = R"("material": {"stiffness_N_m": )" + std::to_string(stiffness_N_m) +
                       R"(, "static_friction": )" + std::to_string(friction) + R"(, "dynamic_friction": )" +
                       std::to_string(0.7 * friction);
    if (relief_m > 0.0)
      text +=
          R"(, "texture": {"kind": "height", "pattern": "cos_cos", "tile_m": [0.004, 0.004], "height_m": )" +
          std::to_string(relief_m) + "}";
    return text + "}";
  };
  const bool textured = beside == Beside::kTexture || beside == Beside::kTexturedBody;
  scene.moves = beside == Beside::kBody || beside == Beside::kTexturedBody;
  scene.relief_m = textured ? 1e-5 : 0.0;
  scene.at_m = 0.02 * random.in_box(Vector3d::Ones());
  scene.json = R"({"thimble_scene": 1, "name": "test", "objects": [
    {"name": "shaded", "shape": {"mesh": {"file": "ball.obj", "crease_deg": 60}}, "pose": {"position_m": )" +
               vector_text(scene.at_m) + "}, " + material(scene.relief_m);
  if (scene.moves) {
    scene.json += R"(, "body": {"motion": ")" + std::string(random.below(2) == 0 ? "free" : "translate") +
                  R"(", "mass_kg": 0.5, "spring_N_m": 2000, "damping_N_s_m": 20, "velocity_m_s": )" +
                  vector_text(0.002 * random.in_box(Vector3d::Ones())) + "}";
  }
  scene.json += "}";
  if (beside == Beside::kSolid || beside == Beside::kMesh) {
    const Vector3d there = scene.at_m + random.uniform(0.03, 0.045) * random.direction();
    scene.other_m = there;
    const std::string shape = beside == Beside::kMesh ? R"("mesh": {"file": "ball.obj", "crease_deg": 60})"
                              : random.below(2) == 0  ? R"("box": {"size_m": [0.03, 0.04, 0.03]})"
                                                      : R"("sphere": {"radius_m": 0.02})";
    scene.json += R"(, {"name": "other", "shape": {)" + shape + R"(}, "pose": {"position_m": )" +
                  vector_text(there) + "}, " + material(0.0) + "}";
  }
  scene.json += "]}";
  return scene;
}

// Near the other solid, if there is one, but in front of it.
Spot mixed_spot(const Mixed& scene, const host::TriangleSoup& soup, const MeshOracle& oracle,
                Random& random) {
  constexpr int kTries = 30;
  constexpr double kInFront_m = 0.0305;
  Spot best = random_spot(soup, oracle, random);
  if (!scene.other_m) return best;
  double least_m = 1.0;
  for (int i = 0; i < kTries; ++i) {
    const Spot spot = random_spot(soup, oracle, random);
    const double far_m = (scene.at_m + spot.at - *scene.other_m).norm();
    if (far_m < kInFront_m || far_m > least_m) continue;
    least_m = far_m;
    best = spot;
  }
  return best;
}

// Where a shaded solid meets others, has a texture, or moves: the same, for the tip's motion in the shaded solid's frame.
// A texture may start anew at each facet.
TEST(Shading, KeepsTheForceBesideOtherSolidsWithTexturesAndOnBodies) {
  constexpr int kScenes = kUnderSanitizers ? 2 : 20;
  constexpr int kTicks = 6000;
  constexpr double kStep_m = 2e-6;
  const TemporaryFolder folder;
  const host::TriangleSoup ball = icosphere(2, 0.03);
  write_obj(ball, 1.0, folder.path() / "ball.obj");
  const host::TriangleSoup soup = as_soup(host::compile_mesh(ball, {host::MeshSide::kOutside, 60.0}, "ball"));
  const MeshOracle oracle(soup);
  const std::array<std::string, 5> names = {"beside a solid", "beside a shaded mesh", "textured", "a body",
                                            "a textured body"};
  for (std::size_t kind = 0; kind < names.size(); ++kind) {
    Random random(11 + kind);
    Tally tally;
    for (int n = 0; n < kScenes; ++n) {
      const Mixed scene = mixed_scene(static_cast<Beside>(kind), random);
      const SceneImage image(host::compile_scene_text(scene.json, "test.scene.json", folder.path()).image);
      IdealRun run(image);
      const auto in_frame = [&](const Vector3d& p, Eigen::Quaterniond& turn) {
        turn = Eigen::Quaterniond::Identity();
        if (!scene.moves) return Vector3d(p - scene.at_m);
        const control::BodyState& body = run.renderer().bodies()[0];
        turn = body.rotation.cast<double>();
        return Vector3d(turn.conjugate() * (p - body.position_m.cast<double>()));
      };
      const Spot spot = mixed_spot(scene, soup, oracle, random);
      Vector3d tip = scene.at_m + spot.at + 1e-4 * spot.out;
      run.restart(tip);
      Vector3d goal = scene.at_m + spot.at - random.uniform(2e-4, 1.5e-3) * spot.out;
      Vector3d force_before = Vector3d::Zero();
      Vector3d place_before = Vector3d::Zero();
      bool inside_before = false;
      for (int tick = 0; tick < kTicks; ++tick) {
        if (tip == goal) goal = tip + random.uniform(1e-4, 2e-3) * random.direction();
        const Vector3d way = goal - tip;
        tip = way.norm() <= kStep_m ? goal : Vector3d(tip + kStep_m * way.normalized());
        Eigen::Quaterniond turn;
        const Vector3d place = in_frame(tip.cast<float>().cast<double>(), turn);
        const double height_m = oracle.signed_distance(place, 0.01);
        const Felt felt = run.step(tip);
        const Vector3d force_N = turn.conjugate() * felt.force_N;
        const bool inside = height_m < 0.0;
        if (height_m < -5e-5) {
          ++tally.inside;
          const double least = (force_N.norm() + scene.stiffest_N_m * scene.relief_m) / (200.0 * -height_m);
          tally.least = std::min(tally.least, least);
        }
        const double moved_m = (place - place_before).norm();
        if (inside && inside_before && moved_m > 0.5 * kStep_m) {
          const double most_N = std::max(force_N.norm(), force_before.norm());
          const double slope = std::numbers::pi * scene.relief_m / kTile_m;
          const double texture_N = scene.stiffest_N_m * scene.relief_m + 2.0 * slope * most_N;
          const double change = ((force_N - force_before).norm() - scene.breaks * most_N - texture_N) /
                                (scene.stiffest_N_m * moved_m);
          tally.fastest = std::max(tally.fastest, change);
          if (change > 2.0) ++tally.jumps;
        }
        force_before = force_N;
        place_before = place;
        inside_before = inside;
      }
    }
    const std::string what = "shaded ball " + names[kind] + ": ";
    figure(what + "ticks inside", static_cast<double>(tally.inside), "");
    figure(what + "least force, least K times the depth", tally.least, "0.1");
    figure(what + "jumps of force", static_cast<double>(tally.jumps), "0");
    figure(what + "fastest change of force, K times the motion", tally.fastest, "2");
    EXPECT_GT(tally.inside, kScenes * 1000);
    EXPECT_GT(tally.least, 0.1);
    EXPECT_EQ(tally.jumps, 0);
  }
}

// A hand that strokes into a shaded and textured mesh does next to no work there, and the account keeps most of the force. When it then
// presses, the force comes back.
TEST(Shading, WithATextureTheForceComesBackWhenPressed) {
  constexpr int kStrokes = kUnderSanitizers ? 12 : 80;
  constexpr int kTicks = 800;  // of a stroke of 12 mm, and of a press of 2 mm
  constexpr double kRadius_m = 0.02;
  constexpr double kPressedBy_m = 0.002;
  constexpr double kStiffness_N_m = 1000.0;
  const TemporaryFolder folder;
  write_obj(icosphere(0, kRadius_m), 1.0, folder.path() / "icosahedron.obj");
  Random random(21);
  std::vector<double> before;  // force over K times the depth
  std::vector<double> after;
  for (int n = 0; n < kStrokes; ++n) {
    const std::array<const char*, 3> patterns = {"ridges", "noise", "cos_cos"};
    const std::string tile = std::to_string(random.uniform(0.004, 0.01));
    const std::string crease = std::to_string(random.uniform(60.0, 180.0));
    std::string json =
        R"({ "thimble_scene": 1, "name": "textured", "materials": { "m": { "stiffness_N_m": 1000, "texture": { "kind": "height",
"height_m": 0.0004, "pattern": ")";
    json += patterns[static_cast<std::size_t>(n) % 3];
    json += R"(", "tile_m": [)";
    json += tile;
    json += ", ";
    json += tile;
    json +=
        R"(] } } }, "objects": [ { "name": "s", "material": "m", "shape": { "mesh": { "file": "icosahedron.obj", "crease_deg": )";
    json += crease;
    json += "} } } ] }";
    IdealRun run(SceneImage(host::compile_scene_text(json, "test.scene.json", folder.path()).image));
    const auto share = [&] {
      const Felt& felt = run.felt();
      return felt.force_N.norm() / (kStiffness_N_m * (felt.god_object_m - felt.tip_m).norm());
    };
    const Vector3d from = random.direction();
    const Vector3d across = from.cross(random.direction()).normalized();
    const double radius_m = random.uniform(0.82, 0.92) * kRadius_m;  // a face is 0.79 of it from the centre
    run.step(2.0 * kRadius_m * from);
    Vector3d out;
    for (int tick = 0; tick < kTicks; ++tick) {
      const double angle = 0.6 * tick / kTicks;
      out = std::cos(angle) * from + std::sin(angle) * across;
      run.step(radius_m * out);
    }
    if ((run.felt().god_object_m - run.felt().tip_m).norm() < 3e-4) continue;
    before.push_back(share());
    for (int tick = 0; tick < kTicks; ++tick) run.step((radius_m - kPressedBy_m * tick / kTicks) * out);
    after.push_back(share());
  }
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  figure("strokes into a shaded and textured icosahedron", static_cast<double>(after.size()), "> an eighth");
  figure("force over K times the depth, median", before[before.size() / 2], "");
  figure("force over K times the depth after the press, median", after[after.size() / 2], "0.8");
  figure("force over K times the depth after the press, least", after.front(), "0.5");
  EXPECT_GT(8 * after.size(), static_cast<std::size_t>(kStrokes));
  EXPECT_GT(after[after.size() / 2], 0.8);
  EXPECT_GT(after.front(), 0.5);
}

// A shaded mesh elsewhere in the scene changes no force on plain solids.
TEST(Shading, LeavesContactsOfPlainSolidsAlone) {
  const auto boxes = [](bool beside_shaded) {
    SceneBuilder builder;
    builder.box({0.02, 0.02, 0.01}, {.stiffness_N_m = 200.0F}, {Vector3d(-0.0099, 0.0, -0.005)});
    builder.box({0.02, 0.02, 0.01},
                {.stiffness_N_m = 1500.0F, .static_friction = 0.5F, .dynamic_friction = 0.3F},
                {Vector3d(0.0099, 0.0, -0.005)});
    if (beside_shaded)
      builder.mesh(icosphere(1, 0.02), {}, {host::MeshSide::kOutside, 60.0}, {Vector3d(0.0, 0.0, -0.2)});
    return builder.image();
  };
  const SceneImage plain = boxes(false), beside = boxes(true);
  IdealRun alone(plain), both(beside);
  Random random(3);
  Vector3d tip(-0.005, 0.0, 0.003);
  int touching = 0, unlike = 0;
  for (int leg = 0; leg < 40; ++leg) {
    const Vector3d goal(random.uniform(-0.012, 0.012), random.uniform(-0.005, 0.005),
                        random.uniform(-0.004, 0.001));
    const Vector3d step = 5e-5 * (goal - tip).normalized();
    for (; (goal - tip).norm() > 5e-5; tip += step) {
      const Felt felt = alone.step(tip);
      touching += felt.contacts > 0 ? 1 : 0;
      unlike += both.step(tip).force_N != felt.force_N ? 1 : 0;
    }
  }
  figure("boxes of unlike stiffness, a shaded ball elsewhere: ticks in contact", touching, "above 1000");
  figure("the same: ticks with another force than without the ball", unlike, "0");
  EXPECT_GT(touching, 1000);
  EXPECT_EQ(unlike, 0);
}

// Two arms on one shaded mesh: each feels what it would feel alone.
TEST(Shading, OfTwoArmsIsThatOfEach) {
  const SceneImage image = SceneBuilder()
                               .mesh(icosphere(2, 0.03), {.static_friction = 0.5F, .dynamic_friction = 0.3F},
                                     {host::MeshSide::kOutside, 60.0})
                               .image();
  IdealRun first(image), second(image);
  control::Renderer renderer;
  renderer.bind(image.view());
  std::array<control::Tip, 2> tips{};
  std::array<control::Touch, 2> touches;
  int unlike = 0;
  double least_N = 1e9;
  for (int tick = 0; tick < 3000; ++tick) {
    const double angle = 4e-4 * tick;
    const double radius_m = std::max(0.031 - 1e-5 * tick, 0.028);
    const std::array<Vector3d, 2> at = {radius_m * Vector3d(std::cos(angle), std::sin(angle), 0.1),
                                        radius_m * Vector3d(0.2, std::sin(-angle), std::cos(angle))};
    const std::array<Felt, 2> felt = {first.step(at[0]), second.step(at[1])};
    for (std::size_t arm = 0; arm < 2; ++arm) {
      const Vec3 before_m = tips[arm].position_m;
      tips[arm].position_m = at[arm].cast<float>();
      tips[arm].velocity_m_s =
          tick == 0 ? Vec3(Vec3::Zero()) : Vec3((tips[arm].position_m - before_m) * 4000.0F);
    }
    renderer.tick(tips, 1.0F / static_cast<float>(kRate_Hz), touches);
    for (std::size_t arm = 0; arm < 2; ++arm) {
      unlike += touches[arm].force_N.cast<double>() != felt[arm].force_N ? 1 : 0;
      if (tick > 1000) least_N = std::min(least_N, felt[arm].force_N.norm());
    }
  }
  figure("two arms on a shaded ball: forces unlike those of one arm alone", unlike, "0");
  EXPECT_EQ(unlike, 0);
  EXPECT_GT(least_N, 0.1);
}

// New materials in contact: the force is that of the new stiffness at once, also where the old force was bound.
TEST(Shading, TakesNewMaterialsInContact) {
  const auto ball = [](float stiffness_N_m) {
    return SceneBuilder()
        .mesh(icosphere(2, 0.03), {.stiffness_N_m = stiffness_N_m}, {host::MeshSide::kOutside, 60.0})
        .image();
  };
  const SceneImage soft = ball(400.0F), stiff = ball(800.0F);
  IdealRun run(soft);
  const Vector3d out = Vector3d(0.3, 0.5, 0.8).normalized();
  run.restart(0.031 * out);
  run.move(0.0285 * out, 1e-5);
  const Vector3d before_N = run.step(0.0285 * out).force_N;
  run.renderer().bind(stiff.view(), control::Binding::kKeepState);
  const Vector3d after_N = run.step(0.0285 * out).force_N;
  figure("shaded contact, twice the stiffness: force over the one before", after_N.norm() / before_N.norm(),
         "2");
  EXPECT_GT(before_N.norm(), 0.3);
  EXPECT_LT((after_N - 2.0 * before_N).norm(), 0.01 * after_N.norm());
  run.move(0.031 * out, 1e-5);
  EXPECT_EQ(run.felt().force_N.norm(), 0.0);
}

}  // namespace
}  // namespace thimble::test
