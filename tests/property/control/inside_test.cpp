// A tip that begins inside solids feels all others at once, and those when it has left them. The judges are closed forms
// and distances in double precision, and the same scene without the solids that are not felt.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kClear_m = 1e-6;  // nearer to a surface than this, rounding decides

// A solid: how to add it to a scene, and the distance to its surface, negative inside, in its own frame.
struct Kind {
  std::string name;
  std::function<void(SceneBuilder&, const Material&, const Pose&)> add;
  std::function<double(const Vector3d&)> distance_m;
};

double in_cylinder_m(const Vector3d& p, double radius_m, double half_m) {
  const Vector2d q(p.head<2>().norm() - radius_m, std::abs(p.z()) - half_m);
  return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
}

Kind mesh_kind(const std::string& name, const host::TriangleSoup& soup,
               host::MeshSide side = host::MeshSide::kOutside) {
  const auto compiled =
      std::make_shared<host::CompiledMesh>(host::compile_mesh(soup, {.side = side, .crease_deg = {}}, name));
  const auto oracle = std::make_shared<MeshOracle>(as_soup(*compiled));
  return {name,
          [compiled](SceneBuilder& b, const Material& m, const Pose& pose) { b.mesh(*compiled, m, pose); },
          [oracle](const Vector3d& p) { return oracle->signed_distance(p); }};
}

std::vector<Kind> kinds() {
  std::vector<Kind> all = {
      {"plane",
       [](SceneBuilder& b, const Material& m, const Pose& pose) {
         b.plane({0.0, 0.0, 1.0}, 0.002, m, pose);
       },
       [](const Vector3d& p) { return p.z() - 0.002; }},
      {"sphere", [](SceneBuilder& b, const Material& m, const Pose& pose) { b.sphere(0.012, m, pose); },
       [](const Vector3d& p) { return p.norm() - 0.012; }},
      {"box",
       [](SceneBuilder& b, const Material& m, const Pose& pose) {
         b.box({0.024, 0.018, 0.012}, m, pose);
       },
       [](const Vector3d& p) {
         const Vector3d q = p.cwiseAbs() - Vector3d(0.012, 0.009, 0.006);
         return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
       }},
      {"cylinder",
       [](SceneBuilder& b, const Material& m, const Pose& pose) { b.cylinder(0.01, 0.008, m, pose); },
       [](const Vector3d& p) { return in_cylinder_m(p, 0.01, 0.008); }},
      {"capsule",
       [](SceneBuilder& b, const Material& m, const Pose& pose) { b.capsule(0.008, 0.01, m, pose); },
       [](const Vector3d& p) {
         return (p - Vector3d(0.0, 0.0, std::clamp(p.z(), -0.01, 0.01))).norm() - 0.008;
       }},
      {"cone", [](SceneBuilder& b, const Material& m, const Pose& pose) { b.cone(0.012, 0.024, m, pose); },
       [](const Vector3d& p) {
         return std::max((2.0 * p.head<2>().norm() + p.z() - 0.018) / std::sqrt(5.0), -0.006 - p.z());
       }}};
  all.push_back(mesh_kind("icosphere", icosphere(2, 0.012)));
  all.push_back(mesh_kind("torus", torus(0.012, 0.005, 24, 12)));
  all.push_back(mesh_kind("terrain", hostile_terrain(16, 0.0015, 0.0015, 3)));
  all.push_back(mesh_kind("box mesh", box_mesh({0.02, 0.02, 0.02}, 6)));
  return all;
}

Pose random_pose(Random& random, double within_m) {
  return {
      random.in_box(Vector3d::Constant(within_m)),
      Quaterniond(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian()).normalized()};
}

struct Placed {
  const Kind* kind;
  Pose pose;
  Material material;

  [[nodiscard]] double distance_m(const Vector3d& p) const {
    return kind->distance_m(pose.rotation.conjugate() * (p - pose.position_m));
  }
};

SceneImage image_of(const std::vector<Placed>& solids, std::uint64_t without) {
  SceneBuilder builder;
  for (std::size_t i = 0; i < solids.size(); ++i)
    if (((without >> i) & 1U) == 0) solids[i].kind->add(builder, solids[i].material, solids[i].pose);
  // Far away and of another stiffness, so that the energy account is kept in every scene.
  builder.sphere(0.01, {.stiffness_N_m = 123.0F}, {.position_m = {1.0, 0.0, 0.0}});
  return builder.image();
}

TEST(Inside, EverySolidKnowsItsInside) {
  std::vector<Kind> all = kinds();
  all.push_back(mesh_kind("round room", icosphere(2, 0.0105), host::MeshSide::kInside));
  const int places = kUnderSanitizers ? 200 : 2000;
  for (const Kind& kind : all) {
    Random random(11);
    // Beyond the walls of a room, in the corners of its box, no ray may meet it: such a place is not told.
    const bool room = kind.name == "round room";
    int wrong = 0;
    int inside = 0;
    int not_told = 0;
    for (int scene = 0; scene < 4; ++scene) {
      const Placed solid{&kind, random_pose(random, 0.02), {}};
      IdealRun run(image_of({solid}, 0));
      for (int i = 0; i < places; ++i) {
        // Half of the places are on the axes of the mesh, where rays meet edges and vertices.
        Vector3d local = random.in_box(Vector3d::Constant(0.0099));
        if (i % 2 == 1) local[static_cast<int>(random.below(3))] = 0.0;
        const Vector3d at = solid.pose.position_m + solid.pose.rotation * local;
        run.restart(at);
        const double distance_m = solid.distance_m(run.felt().tip_m);
        if (std::abs(distance_m) < kClear_m) continue;
        inside += distance_m < 0.0 ? 1 : 0;
        const bool told = run.renderer().inside(0) != 0;
        if (room && distance_m < 0.0) {
          not_told += told ? 0 : 1;
        } else {
          wrong += told != (distance_m < 0.0) ? 1 : 0;
        }
        EXPECT_EQ(run.felt().contacts, 0);
        EXPECT_EQ(run.felt().force_N.norm(), 0.0);
      }
      EXPECT_EQ(run.renderer().counters().sweep_bound, 0U);
    }
    figure(kind.name + ": places inside", inside, "some");
    EXPECT_GT(inside, 20);
    if (room) {
      EXPECT_LT(figure(kind.name + ": not told, of these", not_told, "less than all"), inside);
    }
    EXPECT_EQ(figure(kind.name + ": judged wrongly", wrong, "0"), 0);
  }
}

// A mesh whose parts cross has points inside of both, of one and of the other.
TEST(Inside, PartsOfAMeshThatCross) {
  const host::TriangleSoup left =
      transformed(icosphere(3, 0.01), Eigen::Matrix3d::Identity(), {-0.004, 0.0, 0.0});
  host::TriangleSoup both = left;
  const host::TriangleSoup right =
      transformed(icosphere(3, 0.01), Eigen::Matrix3d::Identity(), {0.004, 0.001, 0.0});
  const auto offset = static_cast<std::uint32_t>(both.vertices_m.size());
  both.vertices_m.insert(both.vertices_m.end(), right.vertices_m.begin(), right.vertices_m.end());
  for (auto triangle : right.triangles) {
    for (auto& corner : triangle) corner += offset;
    both.triangles.push_back(triangle);
  }
  const MeshOracle a(left);
  const MeshOracle b(right);
  IdealRun run(SceneBuilder().mesh(both, {}).image());
  Random random(5);
  int wrong = 0;
  int twice = 0;
  for (int i = 0; i < 2000; ++i) {
    run.restart(random.in_box({0.015, 0.011, 0.011}));
    const double in_a = a.signed_distance(run.felt().tip_m);
    const double in_b = b.signed_distance(run.felt().tip_m);
    if (std::abs(in_a) < kClear_m || std::abs(in_b) < kClear_m) continue;
    twice += in_a < 0.0 && in_b < 0.0 ? 1 : 0;
    wrong += (run.renderer().inside(0) != 0) != (std::min(in_a, in_b) < 0.0) ? 1 : 0;
  }
  figure("places in both parts", twice, "some");
  EXPECT_GT(twice, 100);
  EXPECT_EQ(figure("judged wrongly", wrong, "0"), 0);
  // From one part into the other and back, nothing is felt; then from outside it is.
  run.restart({-0.008, 0.0, 0.0});
  run.move({0.008, 0.0, 0.0}, 5e-5);
  run.move({-0.008, 0.0, 0.0}, 5e-5);
  EXPECT_EQ(run.force_variation_N(), 0.0);
  EXPECT_EQ(run.renderer().inside(0), 1U);
  run.move({-0.02, 0.0, 0.0}, 5e-5);
  EXPECT_EQ(run.renderer().inside(0), 0U);
  run.move({-0.012, 0.0, 0.0}, 5e-5);
  EXPECT_NEAR(run.felt().force_N.x(), -2.0, 0.02);
}

TEST(Inside, ASheetHasNone) {
  IdealRun run(SceneBuilder()
                   .mesh(sheet(0.05, 4), {})
                   .mesh(icosphere(2, 0.01), {}, {.side = host::MeshSide::kBoth, .crease_deg = {}})
                   .image());
  run.restart({0.0, 0.0, -0.001});
  EXPECT_EQ(run.renderer().inside(0), 0U);
  run.move({0.0, 0.0, 0.002}, 5e-5);
  EXPECT_NEAR(run.felt().force_N.z(), -2.0, 1e-3)
      << "the sheet is felt from below, and the shell from within";
}

// Heaps of solids that overlap, with unlike materials and friction. While the tip is inside some of them, all is as if
// they were not there. What it has left is felt, and never entered again.
TEST(Inside, OthersAreFeltMeanwhile) {
  const std::vector<Kind> all = kinds();
  const int scenes = kUnderSanitizers ? 4 : 60;
  const int ticks = kUnderSanitizers ? 400 : 3000;
  long compared = 0;
  long felt_meanwhile = 0;
  long left = 0;
  long unlike = 0;
  double most_N = 0.0;
  long entered = 0;
  long wrong = 0;
  for (int scene = 0; scene < scenes; ++scene) {
    Random random(900 + static_cast<std::uint64_t>(scene));
    std::vector<Placed> solids;
    for (std::uint64_t n = 2 + random.below(5); n > 0; --n) {
      Material m{.stiffness_N_m = static_cast<float>(random.uniform(200.0, 2000.0))};
      if (scene % 3 == 0)
        m.static_friction = m.dynamic_friction = static_cast<float>(random.uniform(0.1, 0.8));
      solids.push_back({&all[random.below(all.size())], random_pose(random, 0.012), m});
    }
    const SceneImage image = image_of(solids, 0);
    IdealRun run(image);  // it takes the general path inside
    const Vector3d start = random.in_box(Vector3d::Constant(0.012));
    run.restart(start);
    std::uint64_t inside = run.renderer().inside(0);
    for (std::size_t i = 0; i < solids.size(); ++i) {
      const double distance_m = solids[i].distance_m(run.felt().tip_m);
      if (std::abs(distance_m) > kClear_m && (((inside >> i) & 1U) != 0) != (distance_m < 0.0)) ++wrong;
    }
    const SceneImage rest_image = image_of(solids, inside);
    IdealRun rest(rest_image);
    run.renderer().use_general_path_only();
    rest.renderer().use_general_path_only();
    rest.restart(start);
    const std::uint64_t at_start = inside;
    Vector3d tip = start;
    Vector3d target = tip;
    for (int tick = 0; tick < ticks; ++tick) {
      const double step_m = scene % 2 == 0 ? 1e-4 : 3e-5;
      if ((target - tip).norm() < step_m)
        target = random.in_box(Vector3d::Constant(tick < ticks / 3 ? 0.012 : 0.025));
      tip += std::min(step_m, (target - tip).norm()) * (target - tip).normalized();
      const Felt felt = run.step(tip);
      const std::uint64_t now = run.renderer().inside(0);
      if ((now & ~inside) != 0) ++wrong;  // none is added
      left += std::popcount(inside & ~now);
      for (std::size_t i = 0; i < solids.size(); ++i) {
        const double tip_m = solids[i].distance_m(felt.tip_m);
        const double god_m = solids[i].distance_m(felt.god_object_m);
        const bool was = ((inside >> i) & 1U) != 0;
        const bool is = ((now >> i) & 1U) != 0;
        if (is && std::min(tip_m, god_m) > kClear_m && solids[i].material.static_friction == 0.0F) ++wrong;
        if (was && !is && std::min(tip_m, god_m) < -kClear_m) ++wrong;
        if (!is && !was && god_m < -2.0 * kClear_m) ++entered;
      }
      inside = now;
      if (inside != at_start || at_start == 0) continue;
      // The same, as long as nothing was left. Not to the last bit: solids nearby that are not felt shorten no path.
      const Felt alone = rest.step(tip);
      ++compared;
      felt_meanwhile += alone.contacts > 0 ? 1 : 0;
      if (alone.force_N != felt.force_N || alone.god_object_m != felt.god_object_m) ++unlike;
      most_N = std::max(most_N, (alone.force_N - felt.force_N).norm());
    }
  }
  figure("ticks inside", static_cast<double>(compared), "many");
  figure("of these in contact with another solid", static_cast<double>(felt_meanwhile), "many");
  figure("solids that were left", static_cast<double>(left), "many");
  EXPECT_GT(felt_meanwhile, kUnderSanitizers ? 1 : 1000);
  EXPECT_GT(left, kUnderSanitizers ? 0 : 40);
  figure("force off that of the scene without these solids, N", most_N, "0");
  EXPECT_EQ(figure("ticks that differ from the scene without these solids", static_cast<double>(unlike), "0"),
            0);
  EXPECT_EQ(figure("ticks with the god object in a solid that is felt", static_cast<double>(entered), "0"),
            0);
  EXPECT_EQ(figure("solids judged wrongly", static_cast<double>(wrong), "0"), 0);
}

TEST(Inside, EachArmHasItsOwn) {
  const SceneImage image =
      SceneBuilder().sphere(0.01, {}).box({0.02, 0.02, 0.02}, {}, {.position_m = {0.03, 0.0, 0.0}}).image();
  control::Renderer renderer;
  renderer.bind(image.view());
  std::array<control::Tip, 2> tips;
  std::array<control::Touch, 2> touches;
  tips[0].position_m = {0.0F, 0.0F, 0.0F};
  tips[1].position_m = {0.03F, 0.0F, 0.0F};
  const auto tick = [&] { renderer.tick(tips, 2.5e-4F, touches); };
  tick();
  EXPECT_EQ(renderer.inside(0), 1U);
  EXPECT_EQ(renderer.inside(1), 2U);
  // The first tip goes into the other's box, which it feels.
  for (int i = 1; i <= 220; ++i) {
    tips[0].position_m.x() = 1e-4F * static_cast<float>(i);
    tick();
  }
  EXPECT_EQ(renderer.inside(0), 0U);
  EXPECT_EQ(renderer.inside(1), 2U);
  EXPECT_NEAR(touches[0].force_N.x(), -2.0F, 1e-3F);
  EXPECT_EQ(touches[1].contacts, 0);
  // Other materials change nothing; a pause and a new scene begin anew.
  renderer.bind(image.view(), control::Binding::kKeepState);
  tick();
  EXPECT_EQ(renderer.inside(0), 0U);
  EXPECT_NEAR(touches[0].force_N.x(), -2.0F, 1e-3F);
  renderer.reset();
  tick();
  EXPECT_EQ(renderer.inside(0), 2U);
  EXPECT_EQ(touches[0].contacts, 0);
  renderer.bind({});
  tick();
  EXPECT_EQ(renderer.inside(0), 0U);
}

SceneImage scene_of(const std::string& members) {
  return SceneImage(host::compile_scene_text(R"({"thimble_scene": 1, "name": "test", )" + members + "}",
                                             "test.scene.json", ".")
                        .image);
}

// A body that the tip began in moves as if the tip were not there, and is felt when it has moved away. A volume in front
// of it in the scene shifts its index.
TEST(Inside, ABodyFallsOffTheTip) {
  const SceneImage image = scene_of(R"("gravity_m_s2": [0, 0, -9.81], "objects": [
      {"name": "pad", "pose": {"position_m": [1, 0, -0.5]}, "shape": {"tissue": {"size_m": [0.1, 0.1],
       "contact_radius_m": 0.005, "relaxed_stiffness_N_m": 100, "recovery_s": 1}}, "material": {"stiffness_N_m": 500}},
      {"name": "ball", "shape": {"sphere": {"radius_m": 0.01}}, "material": {"stiffness_N_m": 500},
       "body": {"mass_kg": 0.1, "motion": "free"}},
      {"name": "floor", "pose": {"position_m": [0, 0, -0.2]}, "shape": {"plane": {"normal": [0, 0, 1]}},
       "material": {"stiffness_N_m": 500}}])");
  IdealRun run(image);
  run.step({0.002, 0.0, 0.001});
  EXPECT_EQ(run.renderer().inside(0), 2U) << "index 1 of the image";
  int ticks = 1;
  while (run.renderer().inside(0) != 0 && ticks < 1000) {
    EXPECT_EQ(run.step({0.002, 0.0, 0.001}).contacts, 0);
    ++ticks;
  }
  const double fallen_m = -static_cast<double>(run.renderer().bodies()[0].position_m.z());
  const double time_s = ticks / kRate_Hz;
  EXPECT_NEAR(figure("fallen off the tip, m", fallen_m, "1/2 g t (t + T)"),
              0.5 * 9.81 * time_s * (time_s + 1.0 / kRate_Hz), 1e-6);
  EXPECT_NEAR(fallen_m, std::sqrt(1e-4 - 4e-6) - 0.001, 2e-4) << "then it is below the tip";
  for (int i = 0; i < 4000; ++i) run.step({0.002, 0.0, 0.001});
  const double top_m = static_cast<double>(run.renderer().bodies()[0].position_m.z()) + 0.01;
  run.move({0.0, 0.0, top_m + 0.001}, 1e-4);
  run.move({0.0, 0.0, top_m - 0.001}, 1e-5);
  EXPECT_GT(run.felt().force_N.z(), 0.3) << "it is pressed against the floor";
}

TEST(Inside, AControlElementLetsTheTipOut) {
  IdealRun run(scene_of(R"("objects": [{"name": "key", "shape": {"box": {"size_m": [0.02, 0.02, 0.01]}},
      "material": {"stiffness_N_m": 800}, "body": {"mass_kg": 0.05, "motion": "slide", "axis": [0, 0, 1],
      "control": {"stiffness_N_m": 300, "damping_N_s_m": 2, "low_m": -0.004, "high_m": 0}}}])"));
  run.step({0.0, 0.0, 0.0});
  EXPECT_EQ(run.renderer().inside(0), 1U);
  run.move({0.0, 0.0, 0.006}, 2e-5);
  EXPECT_EQ(run.force_variation_N(), 0.0);
  EXPECT_EQ(run.renderer().inside(0), 0U);
  run.move({0.0, 0.0, 0.004}, 2e-5);
  EXPECT_GT(run.felt().force_N.z(), 0.2);
}

// Where no ray ends within its bound, the mesh counts as one that the tip is in: it exerts no force.
TEST(Inside, AMeshWithoutAnAnswerIsNotFelt) {
  host::TriangleSoup soup;
  const auto tetrahedron = [&](const Vector3d& at, double size_m) {
    const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (const Vector3d& p : {Vector3d(1.0, 1.0, 1.0), Vector3d(-1.0, -1.0, 1.0), Vector3d(-1.0, 1.0, -1.0),
                              Vector3d(1.0, -1.0, -1.0)})
      soup.vertices_m.emplace_back(at + size_m * p);
    for (const auto& t :
         std::initializer_list<std::array<std::uint32_t, 3>>{{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}})
      soup.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  };
  constexpr int kMany = 4000;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < kMany; ++i)
        tetrahedron(side * (0.005 + 0.09 * i / kMany) * Vector3d::Unit(axis), 2e-6);
  IdealRun run(SceneBuilder().mesh(soup, {}).image());
  run.step(Vector3d(0.0, 0.0, 0.0));
  EXPECT_EQ(run.renderer().inside(0), 1U);
  EXPECT_EQ(run.felt().contacts, 0);
  EXPECT_GE(figure("rays without an answer are counted", run.renderer().counters().sweep_bound, "1"), 1U);
  run.move({0.003, 0.003, 0.003}, 1e-4);
  EXPECT_EQ(run.renderer().inside(0), 0U) << "rays from here meet nothing";
}

}  // namespace
}  // namespace thimble::test
