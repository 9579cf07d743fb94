// No tunnelling: ten million random ticks, with jumps of up to 5 mm per tick, in which the god object never
// passes through a surface.
//
// The oracles share no code with the renderer: signed distances in double precision (closed forms, and
// tests/support/oracle.h for meshes). For a move from one side of a surface to the other there must be a path
// that is never farther from the tip than the god object was: over the faces, or that of the god object by
// definition, or one found through free space. THIMBLE_NO_TUNNEL_TICKS sets the number of ticks,
// THIMBLE_NO_TUNNEL_SEED the seed (docs/bench.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/solids/solid.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

// The shares are rounded down; a hundredth under the sanitizers.
constexpr double kDefaultTicks = kUnderSanitizers ? 1e5 : 1.0001e7;

constexpr double kInside_m = 1e-6;  // deeper than this in a solid is a fall
constexpr double kJump_m = 5e-3;
constexpr double kBall_m = static_cast<double>(control::kPointRadius_m);
constexpr auto kTouchGap_m = static_cast<double>(control::kTouchGap_m);  // a ball touches what is this near
constexpr double kOutAgain_m =
    5e-6;  // a ball moves out of a plane that it is behind by rounding, up to 1 um a step

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}

double total_ticks() { return from_environment("THIMBLE_NO_TUNNEL_TICKS", kDefaultTicks); }

std::uint64_t seed() { return static_cast<std::uint64_t>(from_environment("THIMBLE_NO_TUNNEL_SEED", 1.0)); }

Material material(int kind) {
  switch (kind % 3) {
    case 0:
      return {};
    case 1:
      return {.damping_N_s_m = 2.0F, .static_friction = 0.6F, .dynamic_friction = 0.4F};
    default:
      return {
          .static_friction = 0.5F, .dynamic_friction = 0.3F, .friction_mode = scene::FrictionMode::Steady};
  }
}

Pose random_pose(Random& random) {
  return {random.in_box(Vector3d::Constant(0.05)),
          Eigen::Quaterniond(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian())
              .normalized()};
}

// Walks the tip from one target to the next: in steps of 25 um, of any length, or in one jump, with encoder
// noise.
class Wanderer {
 public:
  Wanderer(Random& random, std::function<Vector3d(const Vector3d&)> next_target)
      : random_(random), next_target_(std::move(next_target)) {}

  Vector3d step(const Vector3d& from) {
    if (left_ == 0) {
      target_ = next_target_(from);
      constexpr double kSteps_m[] = {2.5e-5, 2e-4, 1e-3, kJump_m};
      step_m_ = kSteps_m[random_.below(4)] * random_.uniform(0.2, 1.0);
      left_ = 1 + static_cast<int>(random_.below(60));
    }
    --left_;
    const Vector3d way = target_ - from;
    const double length = way.norm();
    if (length <= step_m_) left_ = 0;
    const Vector3d to = length <= step_m_ ? target_ : Vector3d(from + way * (step_m_ / length));
    return to + 2e-6 * random_.in_box(Vector3d::Ones());
  }

 private:
  Random& random_;
  std::function<Vector3d(const Vector3d&)> next_target_;
  Vector3d target_ = Vector3d::Zero();
  double step_m_ = 0;
  int left_ = 0;
};

struct Tally {
  long ticks = 0;
  long in_contact = 0;
  long falls = 0;     // inside, or on the other side
  long hovering = 0;  // in contact, but on no face
  long silent = 0;    // the tip is in the solid and there is no contact
  long unfelt =
      0;  // the renderer says that the tip has come into a solid before it was known not to begin there
  long farther = 0;  // a move away from the tip
  long strange = 0;  // not finite, or a force without contact
  long to_other_side = 0;
  long not_over_faces = 0;  // of them, those that no way over the faces explains
  double deepest_m = 0;

  void common(const Felt& felt, const Vector3d& god_before, bool shaded = false) {
    count(felt);
    if (!shaded) may_not_leave(felt.tip_m, god_before, felt.god_object_m, 0.0);
  }
  // Where several solids are near, the ball may not move away from the tip. Where they are first near, the point
  // becomes the centre of a ball above it.
  void common_of_several(const Felt& felt, const Felt& before) {
    count(felt);
    const bool becomes = before.ball_m == before.god_object_m;
    may_not_leave(felt.tip_m, before.ball_m, felt.ball_m, (becomes ? 2.0 * kBall_m : 0.0) + kOutAgain_m);
    if ((felt.ball_m - felt.god_object_m).norm() > 4.0 * kBall_m + kInside_m) ++hovering;
  }
  void count(const Felt& felt) {
    ++ticks;
    if (felt.contacts > 0) ++in_contact;
    if (felt.inside) ++unfelt;
    if (!felt.force_N.allFinite() || !felt.god_object_m.allFinite()) ++strange;
    if (felt.contacts == 0 && felt.force_N != Vector3d::Zero()) ++strange;
  }
  void may_not_leave(const Vector3d& tip, const Vector3d& before, const Vector3d& now, double allowed_m) {
    if ((now - tip).norm() > (before - tip).norm() + allowed_m + kInside_m) ++farther;
  }
  void report(const std::string& name) const {
    const std::string what = "no tunnel, " + name + ": ";
    figure(what + "ticks", static_cast<double>(ticks), "");
    figure(what + "in contact, %", 100.0 * static_cast<double>(in_contact) / static_cast<double>(ticks),
           "> 25");
    figure(what + "falls", static_cast<double>(falls), "0");
    figure(what + "in contact, but on no face", static_cast<double>(hovering), "0");
    figure(what + "tip inside without contact", static_cast<double>(silent), "0");
    figure(what + "moves away from the tip", static_cast<double>(farther), "0");
    figure(what + "not finite, or a force in free space", static_cast<double>(strange), "0");
    if (unfelt > 0) figure(what + "not felt", static_cast<double>(unfelt), "< 5 %, 0 without a bound");
    if (to_other_side > 0) figure(what + "moves from side to side", static_cast<double>(to_other_side), "");
    if (to_other_side > 0)
      figure(what + "of them, not over the faces", static_cast<double>(not_over_faces), "");
    if (deepest_m < 0.0) figure(what + "god object's deepest, um", 1e6 * deepest_m, ">= -1");
    // The share of a short run (as under the sanitizers) is a matter of luck.
    if (ticks >= 10'000) {
      EXPECT_GT(4 * in_contact, ticks) << name;
    }
    EXPECT_GT(in_contact, 0) << name;
    EXPECT_EQ(falls, 0) << name;
    EXPECT_EQ(hovering, 0) << name;
    EXPECT_EQ(silent, 0) << name;
    EXPECT_LE(unfelt, work_is_bounded() ? ticks / 20 : 0) << name;
    EXPECT_EQ(farther, 0) << name;
    EXPECT_EQ(strange, 0) << name;
  }
};

// Things a tenth of a millimetre thin whose rim the tip never passes: the god object stays on the side on
// which it came.
TEST(NoTunnel, ThinPlatesAndSheets) {
  struct Thin {
    std::string name;
    std::function<void(SceneBuilder&, const Material&, const Pose&)> add;
    double half_thickness_m;
  };
  const auto plate =
      std::make_shared<host::CompiledMesh>(host::compile_mesh(box_mesh({0.1, 0.1, 1e-4}, 12), {}, "plate"));
  const auto shaded = std::make_shared<host::CompiledMesh>(
      host::compile_mesh(box_mesh({0.1, 0.1, 1e-4}, 12), {host::MeshSide::kOutside, 40.0}, "plate"));
  const auto open = std::make_shared<host::CompiledMesh>(host::compile_mesh(sheet(0.1, 15), {}, "sheet"));
  const std::vector<Thin> things = {
      {"plate of 0.1 mm", [=](auto& b, const auto& m, const auto& p) { b.mesh(*plate, m, p); }, 5e-5},
      {"shaded plate of 0.1 mm", [=](auto& b, const auto& m, const auto& p) { b.mesh(*shaded, m, p); }, 5e-5},
      {"box of 0.1 mm",
       [](auto& b, const auto& m, const auto& p) {
         b.box({0.1, 0.1, 1e-4}, m, p);
       },
       5e-5},
      {"open sheet", [=](auto& b, const auto& m, const auto& p) { b.mesh(*open, m, p); }, 0.0}};
  const auto runs = 6;
  const auto ticks = static_cast<long>(0.3 * total_ticks() / runs / static_cast<double>(things.size()));
  for (const Thin& thin : things) {
    Tally tally;
    for (int run_index = 0; run_index < runs; ++run_index) {
      Random random(seed() * 1000 + static_cast<std::uint64_t>(run_index));
      const Pose pose = run_index < 2 ? Pose{} : random_pose(random);
      SceneBuilder builder;
      thin.add(builder, material(run_index), pose);
      const SceneImage image = builder.image();
      IdealRun run(image);
      const double side = run_index % 2 == 0 ? 1.0 : -1.0;
      // In the plate's own frame. Mostly behind the plate: the side on which it came is the only memory.
      Wanderer wanderer(random, [&](const Vector3d& from) -> Vector3d {
        const Vector3d near = random.below(2) == 0 ? Vector3d(from + random.in_box({0.006, 0.006, 0.0}))
                                                   : random.in_box({0.03, 0.03, 0.0});
        return {std::clamp(near.x(), -0.03, 0.03), std::clamp(near.y(), -0.03, 0.03),
                side * random.uniform(-0.006, 0.002)};
      });
      Vector3d tip(0.0, 0.0, side * 0.002);
      run.step(pose.position_m + pose.rotation * tip);
      for (long tick = 0; tick < ticks; ++tick) {
        tip = wanderer.step(tip);
        const Vector3d before = run.felt().god_object_m;
        const Felt& felt = run.step(pose.position_m + pose.rotation * tip);
        tally.common(felt, before);
        const double height = side * (pose.rotation.conjugate() * (felt.god_object_m - pose.position_m)).z() -
                              thin.half_thickness_m;
        tally.deepest_m = std::min(tally.deepest_m, height);
        if (height < -kInside_m) ++tally.falls;
        const double tip_height =
            side * (pose.rotation.conjugate() * (felt.tip_m - pose.position_m)).z() - thin.half_thickness_m;
        if (tip_height < -kInside_m && felt.contacts == 0) ++tally.silent;
      }
    }
    tally.report(thin.name);
  }
}

// A point just off the faces that p lies on, on their free side.
Vector3d lifted(const MeshOracle& oracle, const Vector3d& p) {
  std::vector<std::uint32_t> faces;
  oracle.near(p, 1e-7, faces);
  Vector3d away = Vector3d::Zero();
  for (const std::uint32_t face : faces) away += oracle.normal(face);
  // In a narrow pit the mean points into a wall: turn towards the face it is worst for until it is good for
  // all.
  for (int turn = 0; turn < 1000; ++turn) {
    const auto worst = std::min_element(faces.begin(), faces.end(), [&](auto a, auto b) {
      return oracle.normal(a).dot(away) < oracle.normal(b).dot(away);
    });
    if (worst == faces.end() || oracle.normal(*worst).dot(away) > 0.05 * away.norm()) break;
    away += oracle.normal(*worst);
  }
  return faces.empty() ? p : Vector3d(p + 2e-7 * away.normalized());
}

bool some_way(const MeshOracle& oracle, const Vector3d& from, const Vector3d& to, const Vector3d& tip,
              double radius_m) {
  constexpr int kSamples[] = {150, 1500, 6000};
  return std::any_of(std::begin(kSamples), std::end(kSamples), [&](int samples) {
    return way_around(oracle, from, to, tip, radius_m, samples, static_cast<std::uint64_t>(samples));
  });
}

// The judge of closed meshes.
class ClosedMeshJudge {
 public:
  ClosedMeshJudge(const MeshOracle& oracle, bool shaded) : oracle_(oracle), shaded_(shaded) {}

  void restart() { known_ = false; }

  // In the mesh's own frame.
  void judge(const Vector3d& tip, const Vector3d& god, int contacts, Tally& tally) {
    // On the surface only faces within 2 um matter; in flight the god object is the tip, and any face may be
    // the nearest.
    const Nearest nearest = oracle_.nearest(god, contacts > 0 ? 2e-6 : 0.02);
    if (nearest.triangle == 0xFFFFFFFF) {
      if (contacts > 0) {
        ++tally.hovering;
        show("hovering", tip, god);
      }
      known_ = false;
      god_ = god;
      return;
    }
    const double depth = oracle_.signed_distance(god, nearest.distance_m);
    tally.deepest_m = std::min(tally.deepest_m, depth);
    if (depth < -kInside_m) {
      ++(contacts > 0 ? tally.falls : tally.silent);
      show("inside", tip, god);
    }
    const Vector3d normal = oracle_.normal(nearest.triangle);
    if (known_ && contacts > 0 && normal.dot(normal_) < 0.0 && (god - god_).norm() > 1e-5) {
      ++tally.to_other_side;
      // Shading may ask for a place a little farther from the tip than the last one.
      const double radius = (shaded_ ? 1.5 : 1.0) * (god_ - tip).norm() + 1e-6;
      if (!oracle_.way_over(god_, god, tip, radius)) {  // through the air, then
        ++tally.not_over_faces;
        ReferenceGodObject reference(oracle_);
        reference.place(lifted(oracle_, god_));
        reference.follow(tip);
        const Vector3d to = lifted(oracle_, god);
        if ((god - reference.position()).norm() > 1e-5 &&
            !some_way(oracle_, reference.position(), to, tip, radius) &&
            !some_way(oracle_, lifted(oracle_, god_), to, tip, radius)) {
          ++tally.falls;
          show("no way leads there", tip, god);
        }
      }
    }
    known_ = contacts > 0;
    normal_ = normal;
    god_ = god;
  }

 private:
  // The first few of each run, with what is needed to see them again.
  void show(const char* what, const Vector3d& tip, const Vector3d& god) {
    if (++shown_ > 3) return;
    std::printf("  %s: from (%.9g %.9g %.9g), tip (%.9g %.9g %.9g), god object (%.9g %.9g %.9g)\n", what,
                god_.x(), god_.y(), god_.z(), tip.x(), tip.y(), tip.z(), god.x(), god.y(), god.z());
  }

  const MeshOracle& oracle_;
  bool shaded_;
  int shown_ = 0;
  bool known_ = false;
  Vector3d normal_ = Vector3d::Zero();
  Vector3d god_ = Vector3d::Zero();
};

// From place to place near a mesh's surface, up to 4 mm under it and 2 mm above.
std::function<Vector3d(const Vector3d&)> near_surface(const MeshOracle& oracle, Random& random) {
  return [&](const Vector3d& from) {
    std::uint32_t best = 0;
    double best_m = 1e9;
    for (int i = 0; i < 6; ++i) {
      const auto face = static_cast<std::uint32_t>(random.below(oracle.size()));
      const double distance = (oracle.corner(face, 0) - from).norm();
      if (distance < best_m) {
        best = face;
        best_m = distance;
      }
    }
    const double u = random.uniform(0.0, 1.0);
    const double v = random.uniform(0.0, 1.0 - u);
    const Vector3d point =
        u * oracle.corner(best, 0) + v * oracle.corner(best, 1) + (1.0 - u - v) * oracle.corner(best, 2);
    return Vector3d(point + random.uniform(-0.004, 0.002) * oracle.normal(best));
  };
}

Vector3d free_point(const MeshOracle& oracle, Random& random, double within_m) {
  for (;;) {
    Vector3d p = oracle.bounds().center() + random.in_box(within_m * oracle.bounds().sizes());
    if (oracle.signed_distance(p) > 1e-4) return p;
  }
}

struct MeshCase {
  std::string name;
  host::TriangleSoup soup;
  host::MeshOptions options;
};

void wander_on_mesh(const MeshCase& test, long ticks, Tally& tally) {
  const host::CompiledMesh mesh = host::compile_mesh(test.soup, test.options, test.name);
  ASSERT_EQ(mesh.report.open_edges + mesh.report.non_manifold_edges + mesh.report.pierced_triangles, 0U)
      << test.name;
  const MeshOracle oracle(as_soup(mesh));
  constexpr int kRuns = 3;
  for (int run_index = 0; run_index < kRuns; ++run_index) {
    Random random(seed() * 1000 + 100 + static_cast<std::uint64_t>(run_index));
    const Pose pose = run_index == 0 ? Pose{} : random_pose(random);
    const SceneImage image = SceneBuilder().mesh(mesh, material(run_index), pose).image();
    IdealRun run(image);
    Wanderer wanderer(random, near_surface(oracle, random));
    ClosedMeshJudge judge(oracle, test.options.crease_deg.has_value());
    const auto to_world = [&](const Vector3d& p) { return Vector3d(pose.position_m + pose.rotation * p); };
    const auto to_local = [&](const Vector3d& p) {
      return Vector3d(pose.rotation.conjugate() * (p - pose.position_m));
    };
    Vector3d tip;
    for (long tick = 0; tick < ticks / kRuns; ++tick) {
      if (tick % 5000 == 0) {
        tip = free_point(oracle, random, test.options.side == host::MeshSide::kInside ? 0.4 : 0.6);
        run.restart(to_world(tip));
        judge.restart();
      }
      tip = wanderer.step(tip);
      const Vector3d before = run.felt().god_object_m;
      const Felt& felt = run.step(to_world(tip));
      tally.common(felt, before, test.options.crease_deg.has_value());
      if (felt.inside) {
        judge.restart();
      } else {
        judge.judge(to_local(felt.tip_m), to_local(felt.god_object_m), felt.contacts, tally);
      }
    }
  }
}

TEST(NoTunnel, ClosedMeshes) {
  const host::MeshOptions flat;
  const host::MeshOptions shaded = {host::MeshSide::kOutside, 50.0};
  const std::vector<MeshCase> cases = {
      {"plate of 0.1 mm, over the rim", box_mesh({0.03, 0.03, 1e-4}, 5), flat},
      {"groove of 40 degrees", v_groove(40.0, 0.01, 0.05, 7), flat},
      {"groove of 90 degrees", v_groove(90.0, 0.01, 0.05, 7), flat},
      {"knife of 8 degrees", knife(8.0, 0.03, 0.05, 9), flat},
      {"icosphere 80", icosphere(1, 0.03), flat},
      {"icosphere 1280, shaded", icosphere(3, 0.03), shaded},
      {"icosphere 20480", icosphere(5, 0.05), flat},
      {"torus", torus(0.02, 0.006, 40, 20), flat},
      {"torus, shaded", torus(0.02, 0.006, 40, 20), shaded},
      {"uv sphere", uv_sphere(96, 48, 0.03), flat},
      {"hostile terrain", hostile_terrain(40, 0.001, 0.002, 7), flat},
      {"hostile terrain, shaded", hostile_terrain(40, 0.001, 0.002, 7), shaded},
      {"cube room", box_mesh({0.04, 0.04, 0.04}, 6), {host::MeshSide::kInside, {}}},
      {"icosphere 1280 from inside", icosphere(3, 0.03), {host::MeshSide::kInside, {}}},
      {"OBJ/empty_mat.obj", test_model("OBJ/empty_mat.obj", 0.06), flat},
      {"3DS/fels.3ds", test_model("3DS/fels.3ds", 0.1), flat},
      {"Collada/sphere.dae", test_model("Collada/sphere.dae", 0.06), shaded},
      {"FBX/animation_with_skeleton.fbx", test_model("FBX/animation_with_skeleton.fbx", 0.06), flat},
      {"BLEND/TorusLightsCams_250_compressed.blend",
       test_model("BLEND/TorusLightsCams_250_compressed.blend", 0.06), flat},
      {"BLEND/HUMAN.blend", test_model("BLEND/HUMAN.blend", 0.2), flat},
      {"BLEND/HUMAN.blend, shaded", test_model("BLEND/HUMAN.blend", 0.1), shaded},
      {"AC/SphereWithLight.ac", test_model("AC/SphereWithLight.ac", 0.1), flat}};
  const auto ticks = static_cast<long>(0.5 * total_ticks() / static_cast<double>(cases.size()));
  for (const MeshCase& test : cases) {
    Tally tally;
    wander_on_mesh(test, ticks, tally);
    tally.report(test.name);
  }
}

// Open, crossing and non-manifold meshes have no inside. What must hold: the god object only ever comes
// nearer to the tip, stays on a face while in contact, and a flight with no contact at either end has met no
// face. Where parts of a mesh lie along each other it may be the point under a ball (control/contact/ball.h):
// then this holds for the point or for the ball, whose surface touches a face.
TEST(NoTunnel, OpenAndBrokenMeshes) {
  const std::vector<std::string> files = {"OBJ/spider.obj", "OFF/Wuson.off", "Collada/duck.dae",
                                          "STL/sphereWithHole.stl", "OBJ/regr01.obj"};
  const auto ticks = static_cast<long>(0.1 * total_ticks() / static_cast<double>(files.size()));
  for (const std::string& file : files) {
    const host::CompiledMesh mesh = host::compile_mesh(test_model(file, 0.1), {}, file);
    const MeshOracle oracle(as_soup(mesh));
    const SceneImage image = SceneBuilder().mesh(mesh, material(1)).image();
    Random random(seed() * 1000 + 200);
    IdealRun run(image);
    Wanderer wanderer(random, near_surface(oracle, random));
    Tally tally;
    const bool seams = mesh.report.seam_triangles > 0;
    Vector3d tip(0.0, 0.0, 0.09);
    run.step(tip);
    Felt last = run.felt();
    for (long tick = 0; tick < ticks; ++tick) {
      if (tick % 500 == 0) {
        run.restart(0.09 * random.direction());
        last = run.felt();
        tip = last.tip_m;
      }
      tip = wanderer.step(tip);
      const Felt& felt = run.step(tip);
      const bool comes_nearer =
          (felt.god_object_m - felt.tip_m).norm() <= (last.god_object_m - felt.tip_m).norm() + kInside_m;
      if (seams && !comes_nearer) {
        tally.common_of_several(felt, last);
      } else {
        tally.common(felt, last.god_object_m);
      }
      if (felt.contacts > 0) {
        const auto on_face = [&](const Vector3d& p, double gap_m) {
          return oracle.nearest(p, gap_m + kInside_m).triangle != 0xFFFFFFFF;
        };
        if (!on_face(felt.god_object_m, 0.0) && !(seams && on_face(felt.ball_m, kBall_m + kTouchGap_m)))
          ++tally.hovering;
      } else if (last.contacts == 0) {
        // Straight through a face only if it slid round it within the tick. A graze within the surface's
        // tolerance is no passage.
        const Vector3d way = felt.god_object_m - last.god_object_m;
        const std::vector<Crossing> met = oracle.crossings(last.god_object_m, felt.god_object_m);
        const bool through = std::any_of(met.begin(), met.end(), [&](const Crossing& crossing) {
          const double steep = std::abs(oracle.normal(crossing.triangle).dot(way));
          return crossing.inwards && std::min(crossing.t, 1.0 - crossing.t) * steep > kInside_m;
        });
        if (through && !some_way(oracle, last.god_object_m, felt.god_object_m, felt.tip_m,
                                 (last.god_object_m - felt.tip_m).norm() + kInside_m)) {
          ++tally.falls;
        }
      }
      last = felt;
    }
    tally.report(file);
  }
}

// Several objects of every shape, in each other's way.
TEST(NoTunnel, ManyObjects) {
  struct Solid {
    std::function<double(const Vector3d&)> distance;  // signed, in its own frame
    Pose pose;
  };
  constexpr int kScenes = 12;
  const auto ticks = static_cast<long>(0.1 * total_ticks() / kScenes);
  const host::CompiledMesh ball = host::compile_mesh(icosphere(3, 0.012), {}, "ball");
  const MeshOracle ball_oracle(as_soup(ball));
  Tally tally;
  for (int scene_index = 0; scene_index < kScenes; ++scene_index) {
    Random random(seed() * 1000 + 300 + static_cast<std::uint64_t>(scene_index));
    SceneBuilder builder;
    std::vector<Solid> solids;
    const auto at = [&] {
      Pose pose = random_pose(random);
      pose.position_m = random.in_box(Vector3d::Constant(0.02));
      return pose;
    };
    for (int object = 0; object < 8; ++object) {
      const Pose pose = at();
      const Material m = material(static_cast<int>(random.below(3)));
      switch (object) {
        case 0:
          builder.plane(Vector3d::UnitZ(), -0.02, m);
          solids.push_back({[](const Vector3d& p) { return p.z() + 0.02; }, {}});
          break;
        case 1:
          builder.sphere(0.012, m, pose);
          solids.push_back({[](const Vector3d& p) { return p.norm() - 0.012; }, pose});
          break;
        case 2:
        case 3: {
          const Vector3d half(0.012, 0.009, object == 2 ? 0.00005 : 0.006);
          builder.box(2.0 * half, m, pose);
          solids.push_back({[half](const Vector3d& p) {
                              const Vector3d q = p.cwiseAbs() - half;
                              return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
                            },
                            pose});
          break;
        }
        case 4:
          builder.cylinder(0.01, 0.008, m, pose);
          solids.push_back({[](const Vector3d& p) {
                              const Eigen::Vector2d q(p.head<2>().norm() - 0.01, std::abs(p.z()) - 0.008);
                              return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
                            },
                            pose});
          break;
        case 5:
          builder.capsule(0.008, 0.01, m, pose);
          solids.push_back({[](const Vector3d& p) {
                              return (p - Vector3d(0.0, 0.0, std::clamp(p.z(), -0.01, 0.01))).norm() - 0.008;
                            },
                            pose});
          break;
        case 6:
          builder.cone(0.01, 0.02, m, pose);
          solids.push_back(
              {[](const Vector3d& p) {  // to the side's and the base's planes: less than the distance outside
                 const double side = (2.0 * p.head<2>().norm() + p.z() - 0.015) / std::sqrt(5.0);
                 return std::max(side, -0.005 - p.z());
               },
               pose});
          break;
        default:
          builder.mesh(ball, m, pose);
          solids.push_back({[&](const Vector3d& p) { return ball_oracle.signed_distance(p); }, pose});
      }
    }
    const SceneImage image = builder.image();
    const auto depth = [&](const Vector3d& p) {
      double least = 1.0;
      for (const Solid& solid : solids) {
        least =
            std::min(least, solid.distance(solid.pose.rotation.conjugate() * (p - solid.pose.position_m)));
      }
      return least;
    };
    IdealRun run(image);
    Wanderer wanderer(random, [&](const Vector3d& from) {
      return random.below(2) == 0 ? Vector3d(from + random.in_box(Vector3d::Constant(0.006)))
                                  : random.in_box(Vector3d::Constant(0.03));
    });
    Vector3d tip = Vector3d::Zero();
    for (long tick = 0; tick < ticks; ++tick) {
      if (tick % 2000 == 0) {
        do {
          tip = random.in_box(Vector3d::Constant(0.04));
        } while (depth(tip) < 1e-3);
        run.restart(tip);
      }
      tip = wanderer.step(tip);
      const Felt before = run.felt();
      const Felt& felt = run.step(tip);
      tally.common_of_several(felt, before);
      const double god = depth(felt.god_object_m);
      tally.deepest_m = std::min(tally.deepest_m, god);
      if (god < -kInside_m && !felt.inside) ++(felt.contacts > 0 ? tally.falls : tally.silent);
    }
  }
  tally.report("eight objects in each other's way");
}

// A slide round a solid makes a detour outside it (control/solids/round.h): what stands in its way there must not lead the god object
// away from the tip.
TEST(NoTunnel, RoundSolidsBetweenPlates) {
  constexpr int kScenesEach = 10;
  constexpr double kRadius_m = 0.009;
  const std::vector<std::pair<std::string, std::function<void(SceneBuilder&)>>> kinds = {
      {"sphere", [](SceneBuilder& b) { b.sphere(kRadius_m, {}); }},
      {"cylinder", [](SceneBuilder& b) { b.cylinder(kRadius_m, 0.01, {}); }},
      {"capsule", [](SceneBuilder& b) { b.capsule(kRadius_m, 0.008, {}); }},
      {"cone", [](SceneBuilder& b) { b.cone(kRadius_m, 0.02, {}); }}};
  const auto ticks =
      static_cast<long>(0.02 * total_ticks() / kScenesEach / static_cast<double>(kinds.size()));
  for (const auto& [name, add] : kinds) {
    Tally tally;
    for (int scene_index = 0; scene_index < kScenesEach; ++scene_index) {
      Random random(seed() * 1000 + 500 + static_cast<std::uint64_t>(scene_index));
      SceneBuilder builder;
      add(builder);
      for (int plate = 0; plate < 4; ++plate) {
        Pose pose = random_pose(random);
        pose.position_m = kRadius_m * random.uniform(1.1, 1.8) * random.direction();
        builder.box({0.014, 0.01, 0.0005}, {}, pose);
      }
      const SceneImage image = builder.image();
      IdealRun run(image);
      for (long tick = 0; tick < ticks; ++tick) {
        if (tick % 200 == 0) run.restart(0.03 * random.direction());
        const Felt before = run.felt();
        tally.common_of_several(run.step(random.in_box(Vector3d::Constant(kRadius_m))), before);
      }
    }
    tally.report(name + " between plates");
  }
}

}  // namespace
}  // namespace thimble::test
