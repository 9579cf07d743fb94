// The renderer has a fast path for one plain surface and a general path for everything. Both render the same forces, over random
// objects, materials and paths of the tip.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "tests/support/figure.h"
#include "tests/support/heap.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr float kPeriod_s = 2.5e-4F;
constexpr double kAllowed_N = 2.0e-5;

struct Kind {
  std::string name;
  std::function<void(SceneBuilder&, const Material&, const Pose&)> add;
  bool many_rests = false;  // a tip inside stands behind several faces of a mesh
};

host::MeshOptions for_tip(double radius_m) { return {.crease_deg = {}, .tip_radius_m = radius_m}; }

// Small and near the origin, where a float is 1e-9 m fine.
std::vector<Kind> kinds() {
  return {
      {"plane",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.plane({0.0, 0.6, 0.8}, 0.002, m, p);
       }},
      {"sphere", [](SceneBuilder& b, const Material& m, const Pose& p) { b.sphere(0.008, m, p); }},
      {"box",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.box({0.015, 0.02, 0.01}, m, p);
       }},
      {"cylinder", [](SceneBuilder& b, const Material& m, const Pose& p) { b.cylinder(0.007, 0.008, m, p); }},
      {"capsule", [](SceneBuilder& b, const Material& m, const Pose& p) { b.capsule(0.006, 0.007, m, p); }},
      {"edged mesh",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(box_mesh({0.015, 0.02, 0.01}, 4), m, {}, p);
       },
       true},
      {"sheet", [](SceneBuilder& b, const Material& m, const Pose& p) { b.mesh(sheet(0.03, 9), m, {}, p); }},
      {"round mesh",
       [](SceneBuilder& b, const Material& m, const Pose& p) { b.mesh(icosphere(4, 0.008), m, {}, p); },
       true},
      {"ring mesh",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(torus(0.01, 0.005, 40, 24), m, {}, p);
       },
       true},
      {"cone", [](SceneBuilder& b, const Material& m, const Pose& p) { b.cone(0.012, 0.016, m, p); }},
      {"edged mesh, tip of 1 mm",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(box_mesh({0.015, 0.02, 0.01}, 4), m, for_tip(0.001), p).tip_radius(0.001);
       },
       true},
      {"round mesh, tip of 2 mm",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(icosphere(4, 0.008), m, for_tip(0.002), p).tip_radius(0.002);
       },
       true},
      {"ring mesh, tip of 1 mm",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(torus(0.01, 0.005, 40, 24), m, for_tip(0.001), p).tip_radius(0.001);
       },
       true},
      {"ring mesh without rims, tip of 1 mm",
       [](SceneBuilder& b, const Material& m, const Pose& p) {
         b.mesh(torus(0.01, 0.005, 40, 24), m, {}, p).tip_radius(0.001);
       },
       true},
  };
}

// One in four without friction, one in three without damping; static friction above dynamic friction, or equal. A solid mesh is taken
// without friction: the fast path walks on from where rest was a tick ago, so where a tip stands behind several faces, rest may be on
// another one of them. A sheet has one face on either side.
Material random_material(Random& random, bool with_friction) {
  Material m;
  m.stiffness_N_m = static_cast<float>(random.uniform(100.0, 1000.0));
  if (random.below(3) != 0) m.damping_N_s_m = static_cast<float>(random.uniform(0.05, 1.0));
  if (random.below(4) == 0 || !with_friction) return m;
  m.static_friction = static_cast<float>(random.uniform(0.05, 1.2));
  m.dynamic_friction = random.below(3) == 0
                           ? m.static_friction
                           : static_cast<float>(random.uniform(0.2, 1.0)) * m.static_friction;
  if (random.below(2) == 0) m.friction_mode = scene::FrictionMode::Steady;
  return m;
}

// A hand that comes in from outside, wanders over the surface about 1 mm inside it, stops now and then, and leaves it sometimes.
class Hand {
 public:
  Hand(Random& random, const Vector3d& centre_m)
      : random_(random), centre_m_(centre_m), at_m_(centre_m + 0.02 * random.direction()) {}

  const control::Tip& step(const control::Touch& felt) {
    constexpr int kPiece = 200;  // ticks
    if (tick_++ % kPiece == 0) {
      const double speed_m_s = random_.uniform(0.0, 0.08);
      along_m_s_ = speed_m_s * random_.direction();
      depth_m_ = random_.below(6) == 0 ? -0.001 : random_.uniform(0.0002, 0.002);
      pauses_ = random_.below(5) == 0;
    }
    Vector3d wanted = along_m_s_;
    if (felt.contacts != 0) {  // to that depth, and along the surface
      const Vector3d pull = felt.god_object_m.cast<double>() - at_m_;
      const double deep_m = pull.norm();
      if (deep_m > 0.0) wanted += 30.0 * (deep_m - depth_m_) / deep_m * pull;
    } else {
      wanted += depth_m_ < 0.0 ? Vector3d(Vector3d::Zero()) : Vector3d(5.0 * (centre_m_ - at_m_));
    }
    velocity_m_s_ += 0.1 * (wanted + 0.003 * random_.direction() - velocity_m_s_);
    if (pauses_ && felt.contacts != 0) velocity_m_s_.setZero();
    at_m_ += static_cast<double>(kPeriod_s) * velocity_m_s_;
    tip_.position_m = at_m_.cast<float>();
    tip_.velocity_m_s = velocity_m_s_.cast<float>();
    return tip_;
  }

 private:
  Random& random_;
  Vector3d centre_m_;
  Vector3d at_m_;
  Vector3d velocity_m_s_ = Vector3d::Zero();
  Vector3d along_m_s_ = Vector3d::Zero();
  double depth_m_ = 0.0;
  bool pauses_ = false;
  int tick_ = 0;
  control::Tip tip_;
};

control::Touch tick(control::Renderer& renderer, const control::Tip& tip) {
  control::Touch touch;
  renderer.tick(std::span(&tip, 1), kPeriod_s, std::span(&touch, 1));
  return touch;
}

// One tick as the general path begins it: what it remembers, and the tip.
struct Tick {
  control::Renderer general;
  control::Tip tip;
};

// The last ticks, the present one last. Steady friction remembers for 2 ms whether the tip stands still, so which side of that boundary
// a tip was on may show in the force 8 ticks later, and what follows from it after as many again.
using Past = std::deque<Tick>;
constexpr std::size_t kPast = 20;

// Whether the general path renders this force for a tip that was beside by what rounding moves it. A tip on the boundary between
// sticking and slipping, or between touching and not, may be on either side of it.
bool is_on_a_boundary(const Past& past, float stiffness_N_m, const Vec3& force_N) {
  constexpr float kBeside_m = 1.0e-7F;
  const float allowed_N = static_cast<float>(kAllowed_N) + 3.0F * stiffness_N_m * kBeside_m;
  for (auto from = past.rbegin(); from != past.rend(); ++from) {
    for (int axis = 0; axis < 3; ++axis) {
      for (const float way : {-kBeside_m, kBeside_m}) {
        control::Renderer renderer = from->general;
        control::Touch felt;
        for (auto at = from.base() - 1; at != past.end(); ++at) {
          control::Tip beside = at->tip;
          beside.position_m[axis] += way;
          felt = tick(renderer, beside);
        }
        if ((felt.force_N - force_N).norm() <= allowed_N) return true;
      }
    }
  }
  return false;
}

// Less than 10 um deep, the direction from tip to god object is known to 1e-8 m over the depth, and so is the damping's.
double rounding_of_damping_N(const Material& material, const control::Tip& tip, const control::Touch& felt) {
  constexpr float kShallow_m = 1.0e-5F;
  constexpr float kRounding_m = 1.0e-8F;
  const float depth_m = (felt.god_object_m - tip.position_m).norm();
  if (depth_m > kShallow_m) return 0.0;
  const float damping_N = material.damping_N_s_m * tip.velocity_m_s.norm();
  return static_cast<double>(damping_N * std::min(kRounding_m / depth_m, 1.0F));
}

struct Tally {
  double worst_N = 0.0;
  int touching = 0;
  int on_a_boundary = 0;
  int apart = 0;  // ticks in which the paths disagree
};

void compare(const Kind& kind, Random& random, Tally& tally) {
  const Material material = random_material(random, !kind.many_rests);
  Pose pose;
  pose.position_m = random.in_box(Vector3d::Constant(0.004));
  if (random.below(3) != 0) {
    Eigen::Vector4d q;  // one draw after the other: the order of a call's arguments is the compiler's choice
    for (double& component : q) component = random.gaussian();
    pose.rotation = Eigen::Quaterniond(q).normalized();
  }
  SceneBuilder builder;
  kind.add(builder, material, pose);
  const SceneImage image = builder.image();
  control::Renderer fast;
  fast.bind(image.view());
  control::Renderer general = fast;
  general.use_general_path_only();
  Hand hand(random, pose.position_m);
  Past past;
  control::Touch felt;
  constexpr int kTicks = 4000;
  for (int i = 0; i < kTicks; ++i) {
    const control::Tip& tip = hand.step(felt);
    past.push_back({general, tip});
    if (past.size() > kPast) past.pop_front();
    felt = tick(fast, tip);
    const control::Touch other = tick(general, tip);
    if (felt.contacts != 0) ++tally.touching;
    const auto difference_N = static_cast<double>((felt.force_N - other.force_N).norm());
    if (difference_N <= kAllowed_N) {
      tally.worst_N = std::max(tally.worst_N, difference_N);
      continue;
    }
    if (difference_N <= kAllowed_N + rounding_of_damping_N(material, tip, felt)) continue;
    ++(is_on_a_boundary(past, material.stiffness_N_m, felt.force_N) ? tally.on_a_boundary : tally.apart);
    general = fast;
    general.use_general_path_only();
    past.clear();
  }
}

TEST(RendererPaths, FastAndGeneralPathRenderTheSameForces) {
  Random random(12);
  constexpr int kScenes = kUnderSanitizers ? 3 : 12;  // of each kind
  for (const Kind& kind : kinds()) {
    Tally tally;
    for (int scene = 0; scene < kScenes; ++scene) compare(kind, random, tally);
    figure("fast and general path, " + kind.name + ": force apart, N", tally.worst_N, "2e-5");
    figure("fast and general path, " + kind.name + ": ticks in contact", tally.touching, "reported");
    figure("fast and general path, " + kind.name + ": ticks on a boundary", tally.on_a_boundary,
           "0.1 % of those in contact");
    figure("fast and general path, " + kind.name + ": other ticks apart", tally.apart, "0");
    EXPECT_GT(tally.touching, kScenes * 800) << kind.name;
    EXPECT_LE(tally.on_a_boundary, tally.touching / 1000) << kind.name;
    EXPECT_EQ(tally.apart, 0) << kind.name;
  }
}

// The fast path does not look at the others while the tip stays within what was clear: it has to look again in time. The tip slides over a
// floor into a box, and back into a wall.
TEST(RendererPaths, TheFastPathMeetsWhatIsInItsWay) {
  const Material material{.stiffness_N_m = 800};
  const SceneImage image = SceneBuilder()
                               .box({0.4, 0.4, 0.02}, material, {.position_m = {0, 0, -0.01}})
                               .box({0.04, 0.04, 0.04}, material, {.position_m = {0.08, 0, 0.02}})
                               .plane({1, 0, 0}, -0.09, material)
                               .image();
  control::Renderer fast;
  fast.bind(image.view());
  control::Renderer general = fast;
  general.use_general_path_only();
  float most_N = 0, least_N = 0;
  for (int i = 0; i < 8000; ++i) {
    const double x_m = i < 4000 ? 5e-5 * std::min(i, 4000 - i) : -3e-5 * (i - 4000);
    const control::Tip tip{.position_m = Vector3d(x_m, 0.001, i < 10 ? 0.001 : -0.002).cast<float>()};
    const control::Touch felt = tick(fast, tip);
    const control::Touch other = tick(general, tip);
    ASSERT_LE((felt.force_N - other.force_N).norm(), static_cast<float>(kAllowed_N)) << "tick " << i;
    most_N = std::max(most_N, felt.force_N.x());
    least_N = std::min(least_N, felt.force_N.x());
  }
  EXPECT_LT(least_N, -1) << "the box pushes back";
  EXPECT_GT(most_N, 1) << "the wall pushes back";
}

// Several unlike solids at once, plain, textured by nothing but shaded or not, some of which touch.
SceneImage random_heap(Random& random, const Vector3d& centre_m) {
  SceneBuilder builder;
  const std::vector<Kind> all = kinds();
  const std::uint64_t solids = 1 + random.below(4);
  for (std::uint64_t i = 0; i < solids; ++i) {
    const Pose pose{centre_m + random.in_box(Vector3d::Constant(i == 0 ? 0.002 : 0.015)),
                    random_turn(random)};
    const Material material = random_material(random, true);
    constexpr std::uint64_t kPoints = 9;  // the kinds after them have a tip with a radius
    switch (const std::uint64_t kind = random.below(kPoints + 2)) {
      case kPoints:
        builder.mesh(icosphere(3 + static_cast<int>(random.below(3)), 0.008), material, {.crease_deg = 50.0},
                     pose);
        break;
      case kPoints + 1:
        builder.mesh(torus(0.01, 0.005, 40, 24), material, {.crease_deg = 50.0}, pose);
        break;
      default:
        all[kind].add(builder, material, pose);
    }
  }
  return builder.image();
}

// The faces and the lists of triangles, and the free space round a tip, are copies of what is in the scene.
TEST(RendererPaths, WhatIsKeptFromTickToTickChangesNoBit) {
  Random random(7);
  constexpr int kScenes = kUnderSanitizers ? 12 : 120;
  constexpr int kTicks = 4000;
  int touching = 0, apart = 0, differ = 0;
  for (int scene = 0; scene < kScenes; ++scene) {
    const Vector3d centre_m = random.in_box(Vector3d::Constant(0.004));
    const SceneImage image = random_heap(random, centre_m);
    control::Renderer keeps;
    keeps.bind(image.view());
    control::Renderer forgets = keeps;
    forgets.keep_nothing();
    Hand hand(random, centre_m);
    control::Touch felt;
    for (int i = 0; i < kTicks; ++i) {
      const control::Tip& tip = hand.step(felt);
      felt = tick(keeps, tip);
      const control::Touch other = tick(forgets, tip);
      ++(felt.contacts != 0 ? touching : apart);
      if (felt.force_N != other.force_N || felt.god_object_m != other.god_object_m ||
          felt.contacts != other.contacts)
        ++differ;
    }
  }
  figure("kept from tick to tick: ticks in contact", touching, "");
  figure("kept from tick to tick: ticks in free space", apart, "");
  figure("kept from tick to tick: ticks that differ without", differ, "0");
  EXPECT_GT(touching, kScenes * kTicks / 4);
  EXPECT_GT(apart, kScenes * kTicks / 20);
  EXPECT_EQ(differ, 0);
}

}  // namespace
}  // namespace thimble::test
