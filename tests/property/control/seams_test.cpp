// Solids that touch feel as one: where their level faces meet there is no gap to fall into and no wall, whatever
// kinds and materials they are of, and nowhere does the god object stop short of a place nearer to the tip that it could
// go to. The judges are closed forms and distances in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "tests/support/figure.h"
#include "tests/support/heap.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBall_m = static_cast<double>(control::kPointRadius_m);

// Blocks side by side, their tops level with z = 0 of a frame that is turned at random. Each is a box, or a mesh, or
// both are cut from one mesh file; they overlap, or are flush, or have a gap of up to 10 um between them. Discs and cones
// with the base upwards stand in some of them.
struct Floor {
  static constexpr double kHalf_m = 0.03;

  Pose frame;
  std::vector<Material> materials;
  SceneImage image;
  bool friction = false;
};

struct Joint {
  std::string name;
  double overlap_m;
  bool unlike;
  bool one_file = false;
};

Floor make_floor(Random& random, const Joint& joint, bool friction) {
  Floor floor{.frame = {random.in_box(Vector3d::Constant(0.05)), random_turn(random)},
              .materials = {},
              .image = SceneBuilder().image(),
              .friction = friction};
  SceneBuilder builder;
  host::TriangleSoup one_file;  // blocks that are parts of one mesh
  const auto material = [&] {
    Material m{.stiffness_N_m = joint.unlike ? static_cast<float>(random.uniform(200.0, 2000.0)) : 1000.0F};
    if (friction) {
      m.static_friction = joint.unlike ? static_cast<float>(random.uniform(0.1, 0.8)) : 0.5F;
      m.dynamic_friction = 0.7F * m.static_friction;
    }
    floor.materials.push_back(m);
    return m;
  };
  const auto placed = [&](const Vector3d& centre, const Quaterniond& turn = Quaterniond::Identity()) {
    return Pose{floor.frame.position_m + floor.frame.rotation * centre, floor.frame.rotation * turn};
  };
  // Two rows of blocks, cut at different places.
  const double row = random.uniform(-0.01, 0.01);
  for (const int side : {-1, 1}) {
    const double v0 = side < 0 ? -Floor::kHalf_m : row;
    const double v1 = side < 0 ? row : Floor::kHalf_m;
    double u0 = -Floor::kHalf_m;
    while (u0 < Floor::kHalf_m) {
      double u1 = std::min(u0 + random.uniform(0.008, 0.03), Floor::kHalf_m);
      if (Floor::kHalf_m - u1 < 0.005) u1 = Floor::kHalf_m;
      const double height = random.uniform(0.008, 0.02);
      const Vector3d size(u1 - u0 + joint.overlap_m, v1 - v0 + joint.overlap_m, height);
      const Vector3d centre(0.5 * (u0 + u1), 0.5 * (v0 + v1), -0.5 * height);
      const Pose pose = placed(centre);
      const int cells = 1 + static_cast<int>(random.below(4));
      if (joint.one_file) {
        const host::TriangleSoup block =
            transformed(box_mesh(size, cells), Eigen::Matrix3d::Identity(), centre);
        const auto first = static_cast<std::uint32_t>(one_file.vertices_m.size());
        one_file.vertices_m.insert(one_file.vertices_m.end(), block.vertices_m.begin(),
                                   block.vertices_m.end());
        for (const auto& t : block.triangles)
          one_file.triangles.push_back({first + t[0], first + t[1], first + t[2]});
      } else if (random.below(3) == 0) {
        builder.mesh(box_mesh(size, cells), material(), {}, pose);
      } else {
        builder.box(size, material(), pose);
      }
      u0 = u1;
    }
  }
  if (joint.one_file) builder.mesh(one_file, material(), {}, placed(Vector3d::Zero()));
  for (int extra = joint.one_file ? 3 : 0; extra < 3; ++extra) {
    const Vector3d at = random.in_box({0.02, 0.02, 0.0});
    const double radius = random.uniform(0.003, 0.008);
    if (random.below(2) == 0) {
      builder.cylinder(radius, 0.005, material(), placed(at - Vector3d(0.0, 0.0, 0.005)));
    } else {
      const Quaterniond over(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
      builder.cone(radius, 0.012, material(), placed(at - Vector3d(0.0, 0.0, 0.003), over));
    }
  }
  floor.image = builder.image();
  return floor;
}

TEST(Seams, LevelFacesAreOneFace) {
  const std::vector<Joint> joints = {{"flush", 0.0, false},
                                     {"flush, unlike", 0.0, true},
                                     {"1 mm over each other", 1e-3, false},
                                     {"1 um over each other, unlike", 1e-6, true},
                                     {"10 um apart", -9.9e-6, false},
                                     {"5 um apart, unlike", -5e-6, true},
                                     {"flush, one mesh", 0.0, false, true},
                                     {"1 mm over each other, one mesh", 1e-3, false, true},
                                     {"10 um apart, one mesh", -9.9e-6, false, true}};
  const int scenes = kUnderSanitizers ? 1 : 8;
  for (const Joint& joint : joints) {
    double off_plane_m = 0.0;
    double aside_m = 0.0;
    double aside_N = 0.0;
    double off_N = 0.0;
    double over_cone = 0.0;
    double jump = 0.0;
    for (int index = 0; index < 2 * scenes; ++index) {
      Random random(500 + static_cast<std::uint64_t>(index));
      const Floor floor = make_floor(random, joint, index % 2 == 1);
      double stiffest = 0.0;
      double most_friction = 0.0;
      for (const Material& m : floor.materials) {
        stiffest = std::max(stiffest, static_cast<double>(m.stiffness_N_m));
        most_friction = std::max(most_friction, static_cast<double>(m.static_friction));
      }
      IdealRun run(floor.image);
      Vector3d tip(0.0, 0.0, 0.002);
      const auto to_world = [&](const Vector3d& p) -> Vector3d {
        return floor.frame.position_m + floor.frame.rotation * p;
      };
      run.step(to_world(tip));
      for (int stroke = 0; stroke < 60; ++stroke) {
        const Vector3d target(random.uniform(-0.024, 0.024), random.uniform(-0.024, 0.024),
                              -random.uniform(1e-4, 0.004));
        const double step_m = random.below(4) == 0 ? 1e-3 : random.uniform(1e-5, 1e-4);
        const int steps = static_cast<int>((target - tip).norm() / step_m) + 1;
        const Vector3d from = tip;
        for (int i = 1; i <= steps; ++i) {
          tip = from + (target - from) * (1.0 * i / steps);
          const Vector3d before_N = run.felt().force_N;
          const Felt& felt = run.step(to_world(tip));
          if (tip.z() > -2e-6) continue;
          const Quaterniond back = floor.frame.rotation.conjugate();
          const Vector3d god = back * (felt.god_object_m - floor.frame.position_m);
          const Vector3d force_N = back * felt.force_N;
          off_plane_m = std::max(off_plane_m, std::abs(god.z()));
          if (floor.friction) {
            over_cone = std::max(over_cone, force_N.head<2>().norm() - most_friction * force_N.z());
          } else {
            aside_m = std::max(aside_m, (god - tip).head<2>().norm());
            aside_N = std::max(aside_N, force_N.head<2>().norm());
            if (!joint.unlike) {
              off_N = std::max(off_N, std::abs(force_N.z() + stiffest * tip.z()));
              if (i > 1)
                jump = std::max(jump, (felt.force_N - before_N).norm() /
                                          (stiffest * (target - from).norm() / steps + 1e-3));
            }
          }
        }
      }
    }
    const std::string what = "seams, " + joint.name + ": ";
    figure(what + "god object off the plane, um", 1e6 * off_plane_m, "1");
    figure(what + "god object beside the tip, um", 1e6 * aside_m, "2");
    figure(what + "force along the plane, N", aside_N, "0.002");
    figure(what + "friction beyond its cone, N", over_cone, "0.002");
    if (!joint.unlike) {
      figure(what + "force off K d, N", off_N, "0.002");
      figure(what + "change of the force by K times the motion", jump, "1.1");
      EXPECT_LT(off_N, 0.002) << joint.name;
      EXPECT_LT(jump, 1.1) << joint.name;
    }
    EXPECT_LT(off_plane_m, 1e-6) << joint.name;
    EXPECT_LT(aside_m, 2e-6) << joint.name;
    EXPECT_LT(aside_N, 0.002) << joint.name;
    EXPECT_LT(over_cone, 0.002) << joint.name;
  }
}

// Where the tip rests, no place that the ball could go to straight is nearer to it: no seam is a wall.
TEST(Seams, NothingHoldsTheGodObjectButSolids) {
  const int scenes = kUnderSanitizers ? 2 : 60;
  long rests = 0;
  long held = 0;
  long silent = 0;
  double worst_m = 0.0;
  double deepest_m = 0.0;
  for (int index = 0; index < scenes; ++index) {
    Random random(900 + static_cast<std::uint64_t>(index));
    SceneBuilder builder;
    const std::vector<Solid> solids = random_heap(random, builder);
    const SceneImage image = builder.image();
    IdealRun run(image);
    const auto distance_m = [&](const Vector3d& p) { return test::distance_m(solids, p); };
    const auto free = [&](const Vector3d& from, const Vector3d& way) {
      constexpr int kPieces = 8;
      for (int i = 1; i <= kPieces; ++i)
        if (distance_m(from + way * (1.0 * i / kPieces)) < kBall_m + 1e-6) return false;
      return true;
    };
    for (int poke = 0; poke < 40; ++poke) {
      run.restart(0.05 * random.direction());
      if (distance_m(run.felt().tip_m) < 1e-3) continue;
      Vector3d tip = random.in_box(Vector3d::Constant(0.012));
      run.move(tip, 1e-4);
      for (int slide = 0; slide < 4; ++slide) {
        tip += random.in_box(Vector3d::Constant(0.004));
        run.move(tip, 1e-4);
        for (int settle = 0; settle < 20; ++settle) run.step(tip);
        const Felt& felt = run.felt();
        deepest_m = std::max(deepest_m, -distance_m(felt.god_object_m));
        if (felt.contacts == 0) {
          if ((felt.god_object_m - felt.tip_m).norm() > 1e-6) ++silent;
          continue;
        }
        ++rests;
        double nearer_m = 0.0;
        for (int n = 0; n < 120; ++n) {
          const Vector3d way = std::pow(10.0, random.uniform(-4.5, -3.3)) * random.direction();
          const double gain = (felt.ball_m - felt.tip_m).norm() - (felt.ball_m + way - felt.tip_m).norm();
          if (gain > 2e-6 && gain > nearer_m && free(felt.ball_m, way)) nearer_m = gain;
        }
        if (nearer_m > 0.0) ++held;
        worst_m = std::max(worst_m, nearer_m);
      }
    }
  }
  figure("seams, random heaps: places of rest in contact", static_cast<double>(rests), "");
  figure("seams, random heaps: god object deepest in a solid, um", 1e6 * deepest_m, "1");
  figure("seams, random heaps: of them held by nothing", static_cast<double>(held), "0");
  figure("seams, random heaps: held without contact", static_cast<double>(silent), "0");
  figure("seams, random heaps: nearest place that was free, um nearer", 1e6 * worst_m, "0");
  EXPECT_GT(rests, kUnderSanitizers ? 50 : 2000);
  EXPECT_LT(deepest_m, 1e-6);
  EXPECT_EQ(held, 0);
  EXPECT_EQ(silent, 0);
}

// A floor and a wall that leaves an acute groove over it, or a ball or a roller that touches it: pressed into the floor and along it into the
// groove, then past its bottom and back, the tip is held all the way. The ball that the god object is there stops where the groove is as wide
// as the ball.
TEST(Seams, AcuteGroovesHold) {
  using Add = std::function<void(SceneBuilder&, const Pose&)>;
  struct Kind {
    std::string name;
    Add add;
  };
  const Material soft{.stiffness_N_m = 500.0F};
  const auto box = [&](SceneBuilder& b, const Pose& p) { b.box({0.2, 0.2, 0.2}, soft, p); };
  const auto mesh = [&](SceneBuilder& b, const Pose& p) {
    b.mesh(box_mesh({0.2, 0.2, 0.2}, 4), soft, {}, p);
  };
  const auto plane = [&](SceneBuilder& b, const Pose& p) { b.plane(Vector3d::UnitZ(), 0.1, soft, p); };
  const std::vector<Kind> floors = {
      {"plane", plane}, {"box", box}, {"mesh", mesh}, {"cylinder", [&](SceneBuilder& b, const Pose& p) {
                                                         b.cylinder(0.1, 0.1, soft, p);
                                                       }}};
  const std::vector<Kind> walls = {{"plane", plane}, {"box", box}, {"mesh", mesh}};
  const std::vector<Kind> rounds = {
      {"ball", [&](SceneBuilder& b, const Pose& p) { b.sphere(0.02, soft, p); }},
      {"roller", [&](SceneBuilder& b, const Pose& p) {
         b.cylinder(0.02, 0.05, soft, {p.position_m, p.rotation * Quaterniond(0.5, 0.5, 0.5, 0.5)});
       }}};
  Random random(31);
  long ticks = 0;
  long silent = 0;
  double farthest = 0.0;  // from the bottom of the groove, over what the ball allows
  double jump_N = 0.0;
  const auto press = [&](const Kind& floor, const Kind& wall, double angle, bool round) {
    const Pose frame{random.in_box(Vector3d::Constant(0.05)), random_turn(random)};
    const auto placed = [&](const Vector3d& at, const Quaterniond& turn) {
      return Pose{frame.position_m + frame.rotation * at, frame.rotation * turn};
    };
    SceneBuilder builder;
    floor.add(builder, placed({0.0, 0.0, -0.1}, Quaterniond::Identity()));
    // The free side of the wall looks down and to -x; its face goes through the origin.
    const Vector3d normal(-std::sin(angle), 0.0, -std::cos(angle));
    if (round) {
      wall.add(builder, placed({0.0, 0.0, 0.02}, Quaterniond::Identity()));
    } else {
      wall.add(builder, placed(-0.1 * normal, Quaterniond::FromTwoVectors(Vector3d::UnitZ(), normal)));
    }
    const SceneImage image = builder.image();
    IdealRun run(image);
    const auto to_world = [&](const Vector3d& p) { return Vector3d(frame.position_m + frame.rotation * p); };
    run.restart(to_world({-0.03, 0.0, 0.03 * std::tan(0.5 * std::min(angle, 1.4))}));
    Vector3d last = Vector3d::Zero();
    const Vector3d stops[] = {{-0.03, 0.0, -0.004}, {0.001, 0.0, -0.004}, {-0.02, 0.0, -0.004}};
    Vector3d tip = run.felt().tip_m;
    for (const Vector3d& stop : stops) {
      const Vector3d to = to_world(stop);
      const int steps = static_cast<int>((to - tip).norm() / 2.5e-5);
      for (int step = 1; step <= steps; ++step) {
        const Felt& felt = run.step(tip + (to - tip) * (1.0 * step / steps));
        ++ticks;
        if (felt.contacts == 0 && (felt.god_object_m - felt.tip_m).norm() > 1e-6) ++silent;
        if (!round && felt.contacts > 0 && last != Vector3d::Zero())
          jump_N = std::max(jump_N, (felt.force_N - last).norm());
        last = felt.contacts > 0 ? felt.force_N : Vector3d(Vector3d::Zero());
      }
      tip = to;
      if (stop.x() < 0.0 || round) continue;
      const Vector3d at = frame.rotation.conjugate() * (run.felt().god_object_m - frame.position_m);
      farthest = std::max(farthest, Vector2d(at.x(), at.z()).norm() / (kBall_m / std::sin(0.5 * angle)));
    }
  };
  for (const Kind& floor : floors) {
    for (const Kind& wall : walls)
      for (const double angle_deg : {5.0, 10.0, 20.0, 30.0, 60.0, 90.0})
        press(floor, wall, angle_deg * std::numbers::pi / 180.0, false);
    for (const Kind& wall : rounds) press(floor, wall, 0.5 * std::numbers::pi, true);
  }
  figure("seams, acute grooves: ticks", static_cast<double>(ticks), "");
  figure("seams, acute grooves: held without contact", static_cast<double>(silent), "0");
  figure("seams, acute grooves: from the bottom, of the ball's distance", farthest, "< 1.1");
  figure("seams, acute grooves: greatest change of force in a tick, N", jump_N, "0.1");
  EXPECT_GT(ticks, 100'000);
  EXPECT_EQ(silent, 0);
  EXPECT_LT(farthest, 1.1);
  EXPECT_LT(jump_N, 0.1);
}

}  // namespace
}  // namespace thimble::test
