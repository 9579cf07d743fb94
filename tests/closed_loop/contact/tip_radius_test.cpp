// A tip with a radius (tip_radius_m of the scene): where the sphere lies and what pushes it, against closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/heap.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kExact_m = 1e-6;

// In its own frame, with the distance from its surface, negative inside.
struct Convex {
  std::string name;
  std::function<void(SceneBuilder&, const Pose&)> add;
  std::function<double(const Vector3d&)> distance_m;
};

std::vector<Convex> convex_solids() {
  const Vector3d half(0.02, 0.015, 0.01);
  const auto to_box = [half](const Vector3d& p) { return box_distance(half, p); };
  return {{"plane", [](SceneBuilder& b, const Pose& p) { b.plane(Vector3d::UnitZ(), 0.004, {}, p); },
           [](const Vector3d& p) { return p.z() - 0.004; }},
          {"box", [half](SceneBuilder& b, const Pose& p) { b.box(2.0 * half, {}, p); }, to_box},
          {"mesh of a box",
           [half](SceneBuilder& b, const Pose& p) { b.mesh(box_mesh(2.0 * half, 5), {}, {}, p); }, to_box},
          {"fine mesh of a box",
           [half](SceneBuilder& b, const Pose& p) { b.mesh(box_mesh(2.0 * half, 40), {}, {}, p); }, to_box},
          {"sphere", [](SceneBuilder& b, const Pose& p) { b.sphere(0.012, {}, p); },
           [](const Vector3d& p) { return p.norm() - 0.012; }},
          {"cylinder", [](SceneBuilder& b, const Pose& p) { b.cylinder(0.012, 0.015, {}, p); },
           [](const Vector3d& p) {
             const Vector2d q(p.head<2>().norm() - 0.012, std::abs(p.z()) - 0.015);
             return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
           }},
          {"capsule", [](SceneBuilder& b, const Pose& p) { b.capsule(0.01, 0.015, {}, p); },
           [](const Vector3d& p) {
             return (p - Vector3d(0.0, 0.0, std::clamp(p.z(), -0.015, 0.015))).norm() - 0.01;
           }},
          {"cone", [](SceneBuilder& b, const Pose& p) { b.cone(0.012, 0.03, {}, p); },
           [](const Vector3d& p) {  // the triangle of base, side and axis
             const Vector2d at(p.head<2>().norm(), p.z());
             const Vector2d rim(0.012, -0.0075);
             const Vector2d apex(0.0, 0.0225);
             const Vector2d along = (apex - rim).normalized();
             const Vector2d out(along.y(), -along.x());
             const double side = out.dot(at - rim);
             const double base = -0.0075 - at.y();
             if (side <= 0.0 && base <= 0.0) return std::max(side, base);
             const double part = std::clamp(along.dot(at - rim), 0.0, (apex - rim).norm());
             const double to_side = (at - rim - part * along).norm();
             const double to_base = (at - Vector2d(std::min(at.x(), 0.012), -0.0075)).norm();
             return base > 0.0 ? std::min(to_side, to_base) : to_side;
           }}};
}

// A tip whose centre is outside a convex solid: the god object is one radius from the nearest place, over faces, edges and corners.
TEST(TipRadius, StandsOffOneRadiusFromConvexSolids) {
  for (const Convex& solid : convex_solids()) {
    double worst_m = 0.0;
    double worst_N = 0.0;
    int touched = 0;
    Random random(11);
    for (const double radius_m : {1e-4, 1e-3, 4e-3, 1e-2}) {
      const Pose pose = {random.in_box(Vector3d::Constant(0.03)), random_turn(random)};
      SceneBuilder builder;
      solid.add(builder, pose);
      const SceneImage image = builder.tip_radius(radius_m).image();
      IdealRun run(image);
      const auto distance_m = [&](const Vector3d& p) {
        return solid.distance_m(pose.rotation.conjugate() * (p - pose.position_m));
      };
      const auto away = [&](const Vector3d& p) {
        constexpr double kStep_m = 1e-7;
        Vector3d out;
        for (int axis = 0; axis < 3; ++axis)
          out[axis] =
              distance_m(p + kStep_m * Vector3d::Unit(axis)) - distance_m(p - kStep_m * Vector3d::Unit(axis));
        return Vector3d(out.normalized());
      };
      for (int poke = 0; poke < 40; ++poke) {
        // To somewhere less than a radius over the surface, then along it.
        Vector3d tip = pose.position_m + random.in_box({0.02, 0.02, 0.02});
        for (int slide = 0; slide < 4; ++slide) {
          for (int i = 0; i < 20; ++i)
            tip += (random.uniform(0.1, 0.9) * radius_m - distance_m(tip)) * away(tip);
          if (distance_m(tip) < 0.05 * radius_m) break;
          if (slide == 0) run.restart(tip + (radius_m + 0.001) * away(tip));
          run.move(tip, 3e-4);
          for (int settle = 0; settle < 4; ++settle) run.step(tip);
          const Felt& felt = run.felt();
          const double depth_m = radius_m - distance_m(felt.tip_m);
          if (depth_m < 0.0) continue;
          ++touched;
          const Vector3d expected = felt.tip_m + depth_m * away(felt.tip_m);
          worst_m = std::max(worst_m, (felt.god_object_m - expected).norm());
          worst_N =
              std::max(worst_N, (felt.force_N - kDefaultStiffness_N_m * depth_m * away(felt.tip_m)).norm());
          tip += 0.5 * radius_m * random.in_box(Vector3d::Ones());
        }
      }
    }
    figure("tip radius, " + solid.name + ": god object off the closed form, um", 1e6 * worst_m, "2");
    figure("tip radius, " + solid.name + ": force off the closed form, N", worst_N, "2e-3");
    EXPECT_GT(touched, 300) << solid.name;
    EXPECT_LT(worst_m, 2.0 * kExact_m) << solid.name;
    EXPECT_LT(worst_N, 2e-3) << solid.name;
  }
}

// On a plane, a sphere feels what a point feels that is one radius lower: springs, damping, friction, textures, maps and clicks.
TEST(TipRadius, OnAPlaneFeelsAsAPointOneRadiusLower) {
  const std::vector<std::pair<std::string, std::string>> materials = {
      {"plain", R"("damping_N_s_m": 2, "static_friction": 0, "dynamic_friction": 0)"},
      {"stick-slip", R"("damping_N_s_m": 2, "static_friction": 0.6, "dynamic_friction": 0.4)"},
      {"steady friction",
       R"("damping_N_s_m": 0, "static_friction": 0.5, "dynamic_friction": 0.3, "friction_mode": "steady")"},
      {"texture and click",
       R"("damping_N_s_m": 1, "static_friction": 0.2, "dynamic_friction": 0.1,
          "click": {"amplitude_N": 1, "frequency_Hz": 150, "decay_per_s": 60},
          "texture": {"kind": "height", "pattern": "cos_cos", "tile_m": [0.004, 0.004], "height_m": 0.0003})"}};
  for (const auto& [name, material] : materials) {
    const auto text = [&material](double radius_m) {
      return R"("tip_radius_m": )" + std::to_string(radius_m) + R"(, "objects": [{"name": "floor", "shape":
        {"plane": {"normal": [0, 0, 1], "offset_m": 0}}, "material": {"stiffness_N_m": 900, )" +
             material + "}}]";
    };
    constexpr double kRadius_m = 0.003;
    SceneImage point_image = SceneBuilder().image();
    try {
      point_image = scene_of(text(0.0));
    } catch (const std::exception& error) {
      FAIL() << name << ": " << error.what();
    }
    const SceneImage ball_image = scene_of(text(kRadius_m));
    IdealRun point(point_image);
    IdealRun ball(ball_image);
    Random random(12);
    Vector3d tip(0.0, 0.0, 0.002);
    double worst_N = 0.0;
    double most_N = 0.0;
    Vector3d target = tip;
    for (int tick = 0; tick < 8000; ++tick) {
      if (tick % 400 == 0)
        target = random.in_box({0.01, 0.01, 0.0}) + Vector3d(0.0, 0.0, random.uniform(-0.003, 0.001));
      tip += std::min(1.0, 2e-5 / std::max((target - tip).norm(), 1e-9)) * (target - tip);
      // The same floats after the radius is added and subtracted.
      const Vector3d a = point.step(tip).force_N;
      const Vector3d b = ball.step(tip + Vector3d(0.0, 0.0, kRadius_m)).force_N;
      most_N = std::max(most_N, a.norm());
      // Damping begins with a step, in a tick that rounding decides.
      if (std::abs(tip.z()) > 1e-6) worst_N = std::max(worst_N, (a - b).norm());
    }
    figure("tip radius, plane, " + name + ": against the point, N", worst_N, "5e-3");
    EXPECT_GT(most_N, 1.0) << name;
    EXPECT_LT(worst_N, 5e-3) << name;
  }
}

// Planes, each with its own stiffness, that meet at an angle with the free side in it, and a floor across them.
TEST(TipRadius, LiesInCornersOfTwoAndThreeWalls) {
  for (const double angle_deg : {60.0, 90.0, 120.0}) {
    for (const bool third : {false, true}) {
      double worst_m = 0.0;
      double worst_N = 0.0;
      Random random(13);
      for (int index = 0; index < 12; ++index) {
        const double half = 0.5 * angle_deg * std::numbers::pi / 180.0;
        const Pose pose = {random.in_box(Vector3d::Constant(0.03)), random_turn(random)};
        const double radius_m = random.uniform(0.0005, 0.008);
        std::vector<Vector3d> normals = {{std::cos(half), 0.0, std::sin(half)},
                                         {-std::cos(half), 0.0, std::sin(half)}};
        if (third) normals.push_back(Vector3d(0.0, 1.0, 0.0));
        std::vector<double> stiffness_N_m;
        SceneBuilder builder;
        for (const Vector3d& normal : normals) {
          stiffness_N_m.push_back(random.uniform(300.0, 1500.0));
          builder.plane(normal, 0.0, {.stiffness_N_m = static_cast<float>(stiffness_N_m.back())}, pose);
        }
        const SceneImage image = builder.tip_radius(radius_m).image();
        IdealRun run(image);
        Eigen::MatrixXd rows(static_cast<Eigen::Index>(normals.size()), 3);
        for (std::size_t i = 0; i < normals.size(); ++i)
          rows.row(static_cast<Eigen::Index>(i)) = normals[i].transpose();
        // Where the sphere touches all walls; along their line it goes with the tip.
        const Vector3d corner =
            rows.completeOrthogonalDecomposition().solve(Eigen::VectorXd::Constant(rows.rows(), radius_m));
        run.restart(pose.position_m + pose.rotation * (corner + Vector3d(0.0, third ? 0.02 : 0.0, 0.02)));
        for (int press = 0; press < 10; ++press) {
          Vector3d pull = Vector3d::Zero();
          std::vector<double> lambda_m;
          for (const Vector3d& normal : normals) {
            lambda_m.push_back(random.uniform(0.0002, 0.002));
            pull -= lambda_m.back() * normal;
          }
          const Vector3d along =
              third ? Vector3d(Vector3d::Zero()) : Vector3d(0.0, random.uniform(-0.01, 0.01), 0.0);
          const Felt& felt = run.move(pose.position_m + pose.rotation * (corner + along + pull), 3e-4);
          Vector3d force = Vector3d::Zero();
          for (std::size_t i = 0; i < normals.size(); ++i)
            force += stiffness_N_m[i] * lambda_m[i] * normals[i];
          worst_m = std::max(worst_m,
                             (felt.god_object_m - pose.position_m - pose.rotation * (corner + along)).norm());
          // Unlike walls that are not square have no potential: the energy account may lower the force.
          if (angle_deg == 90.0) worst_N = std::max(worst_N, (felt.force_N - pose.rotation * force).norm());
          EXPECT_EQ(felt.contacts, third ? 3 : 2);
        }
      }
      const std::string name = "tip radius, corner of " + std::to_string(third ? 3 : 2) + " walls at " +
                               std::to_string(static_cast<int>(angle_deg)) + " degrees: ";
      figure(name + "god object off the closed form, um", 1e6 * worst_m, "1");
      EXPECT_LT(worst_m, kExact_m) << name;
      if (angle_deg == 90.0) figure(name + "force off the closed form, N", worst_N, "5e-3");
      EXPECT_LT(worst_N, 5e-3) << name;
    }
  }
}

// A groove of a mesh: the centre is radius / sin(half the angle) above the bottom line.
TEST(TipRadius, LiesInAGrooveOfAMesh) {
  for (const double angle_deg : {40.0, 60.0, 90.0, 120.0}) {
    double worst_m = 0.0;
    for (const double radius_m : {5e-4, 2e-3}) {
      const SceneImage image =
          SceneBuilder().mesh(v_groove(angle_deg, 0.012, 0.06, 11), {}).tip_radius(radius_m).image();
      IdealRun run(image);
      const double height_m = radius_m / std::sin(0.5 * angle_deg * std::numbers::pi / 180.0);
      run.restart({0.0, 0.0, 0.06});
      run.move({0.0, 0.0, height_m - 0.001}, 2e-4);
      Random random(14);
      for (int press = 0; press < 20; ++press) {
        const Vector3d tip(random.uniform(-1e-4, 1e-4), random.uniform(-0.02, 0.02),
                           height_m - random.uniform(5e-4, 0.002));
        const Felt& felt = run.move(tip, 2e-4);
        worst_m = std::max(worst_m, (felt.god_object_m - Vector3d(0.0, felt.tip_m.y(), height_m)).norm());
      }
    }
    const std::string name =
        "tip radius, mesh groove of " + std::to_string(static_cast<int>(angle_deg)) + " degrees: ";
    figure(name + "god object off the closed form, um", 1e6 * worst_m, "1");
    EXPECT_LT(worst_m, kExact_m) << name;
  }
}

// Two blocks with level tops: a sphere wider than the gap lies on their edges, a narrower one goes through.
TEST(TipRadius, EntersNoSlotNarrowerThanItself) {
  constexpr double kRadius_m = 0.002;
  for (const bool mesh : {false, true}) {
    for (const double gap_m : {0.0, 5e-6, 1e-3, 3.9e-3, 3.99e-3, 4.01e-3, 6e-3}) {
      SceneBuilder builder;
      for (const double side : {-1.0, 1.0}) {
        const Pose pose{{side * (0.01 + 0.5 * gap_m), 0.0, -0.005}, Quaterniond::Identity()};
        if (mesh) {
          builder.mesh(box_mesh({0.02, 0.04, 0.01}, 6), {}, {}, pose);
        } else {
          builder.box({0.02, 0.04, 0.01}, {}, pose);
        }
      }
      const SceneImage image = builder.tip_radius(kRadius_m).image();
      IdealRun run(image);
      run.restart({0.0, 0.0, 0.005});
      const Felt& felt = run.move({0.0, 0.001, -0.004}, 1e-4);
      const double half_m = 0.5 * gap_m;
      const double expected_m =
          half_m < kRadius_m ? std::sqrt(kRadius_m * kRadius_m - half_m * half_m) : -0.004;
      const std::string name = std::string("tip radius 2 mm, ") + (mesh ? "mesh" : "box") + " gap of " +
                               std::to_string(1e3 * gap_m) + " mm: height off the closed form, um";
      figure(name, 1e6 * (felt.god_object_m.z() - expected_m), "+-3");
      EXPECT_NEAR(felt.god_object_m.z(), expected_m, 3e-6) << name;
      // Over the gap from side to side: no wall.
      run.restart({-0.008, 0.0, 0.005});
      run.move({-0.008, 0.0, 0.0005}, 1e-4);
      const Felt& over = run.move({0.008, 0.0, 0.0005}, 1e-4);
      if (gap_m < 3e-3) {
        EXPECT_NEAR(over.god_object_m.x(), 0.008, 1e-5) << name;
      }
    }
  }
}

// A ring with a hole of 6 mm: a sphere of 10 mm lies on it, one of 5 mm falls through.
TEST(TipRadius, EntersNoHoleNarrowerThanItself) {
  constexpr double kRing_m = 0.012;
  constexpr double kTube_m = 0.006;
  for (const double radius_m : {0.005, 0.0055, 0.007, 0.01}) {
    const SceneImage image =
        SceneBuilder().mesh(torus(kRing_m, kTube_m, 96, 48), {}).tip_radius(radius_m).image();
    IdealRun run(image);
    run.restart({0.0, 0.0, 0.03});
    run.move({0.0, 0.0, 0.0}, 1e-4);
    const Felt& felt = run.move({0.0, 0.0, -0.03}, 1e-4);
    const double both_m = radius_m + kTube_m;
    const double expected_m = both_m > kRing_m ? std::sqrt(both_m * both_m - kRing_m * kRing_m) : -0.03;
    figure("tip radius " + std::to_string(1e3 * radius_m) +
               " mm, ring with a hole: height off the closed form, mm",
           1e3 * (felt.god_object_m.z() - expected_m), "+-0.1");
    EXPECT_NEAR(felt.god_object_m.z(), expected_m, 1e-4) << radius_m;
    EXPECT_EQ(felt.contacts > 0, both_m > kRing_m) << radius_m;
  }
}

// A shaded icosphere feels as the sphere that it approximates.
TEST(TipRadius, ShadingSmoothsFacets) {
  constexpr double kBall_m = 0.03;
  constexpr double kRadius_m = 0.002;
  const SceneImage image = SceneBuilder()
                               .mesh(icosphere(3, kBall_m), {}, {host::MeshSide::kOutside, 60.0})
                               .tip_radius(kRadius_m)
                               .image();
  IdealRun run(image);
  Random random(15);
  double worst = 0.0;
  int touched = 0;
  run.restart({0.0, 0.0, 0.04});
  Vector3d direction = Vector3d::UnitZ();
  for (int tick = 0; tick < 4000; ++tick) {
    if (tick % 200 == 0) direction = random.direction();
    const Vector3d now = (run.felt().tip_m.normalized() + 0.01 * direction).normalized();
    const Felt& felt = run.step((kBall_m + kRadius_m - 0.001) * now);
    if (tick < 10) continue;
    ++touched;
    const double depth_m = kBall_m + kRadius_m - felt.tip_m.norm();
    const Vector3d expected = kDefaultStiffness_N_m * depth_m * felt.tip_m.normalized();
    worst = std::max(worst, (felt.force_N - expected).norm() / expected.norm());
  }
  figure("tip radius, shaded icosphere: force against the sphere's, part of it", worst, "0.2");
  EXPECT_LT(worst, 0.2);
  EXPECT_GT(touched, 3000);
}

// A tip that begins nearer to a solid than its radius is let out without force; the other solid is felt.
TEST(TipRadius, ASphereThatBeginsInASolidIsLetOut) {
  for (const bool mesh : {false, true}) {
    SceneBuilder builder;
    builder.plane(Vector3d::UnitX(), -0.02, {});
    if (mesh) {
      builder.mesh(box_mesh({0.2, 0.2, 0.02}, 9), {}, {}, {{0.0, 0.0, -0.01}, Quaterniond::Identity()});
    } else {
      builder.box({0.2, 0.2, 0.02}, {}, {{0.0, 0.0, -0.01}, Quaterniond::Identity()});
    }
    const SceneImage image = builder.tip_radius(0.004).image();
    IdealRun run(image);
    for (const double start_m : {-0.005, -0.001, 0.001, 0.0039}) {
      run.restart({0.0, 0.0, start_m});
      double kick_N = 0.0;
      for (double z = start_m; z < 0.0042; z += 2e-5)
        kick_N = std::max(kick_N, run.step({0.0, 0.0, z}).force_N.norm());
      figure("tip radius, begun in a solid: force on the way out, N", kick_N, "0");
      EXPECT_EQ(kick_N, 0.0) << start_m << (mesh ? " mesh" : " box");
      EXPECT_NEAR(run.move({0.0, 0.0, 0.003}, 2e-5).force_N.z(), 1.0, 2e-3);  // afterwards it is felt
    }
    run.restart({0.0, 0.0, 0.002});
    EXPECT_NEAR(run.move({-0.017, 0.0, 0.002}, 2e-5).force_N.x(), 1.0, 2e-3);  // the wall is felt meanwhile
  }
}

// Whatever the path, the springs give back what the hand put in.
TEST(TipRadius, ClosedPathsDoNoWork) {
  double worst_J = -1.0;
  double least_J = 1.0;
  for (int index = 0; index < 12; ++index) {
    Random random(300 + static_cast<std::uint64_t>(index));
    SceneBuilder builder;
    builder.mesh(hostile_terrain(12, 0.003, 0.001, 40 + static_cast<std::uint64_t>(index)), {});
    builder.sphere(0.006, {}, {random.in_box({0.01, 0.01, 0.002}), Quaterniond::Identity()});
    const SceneImage image = builder.tip_radius(random.uniform(0.001, 0.006)).image();
    IdealRun run(image);
    for (int loop = 0; loop < 4; ++loop) {
      const Vector3d start(0.0, 0.0, 0.03);
      run.restart(start);
      for (int leg = 0; leg < 6; ++leg)
        run.move(random.in_box({0.012, 0.012, 0.0}) + Vector3d(0.0, 0.0, random.uniform(0.0, 0.006)), 2e-5);
      run.move(start, 2e-5);
      worst_J = std::max(worst_J, run.work_mean_force_J());
      least_J = std::min(least_J, run.work_mean_force_J());
    }
  }
  figure("tip radius, closed paths: most work on the hand, uJ", 1e6 * worst_J, "20");
  figure("tip radius, closed paths: least work on the hand, uJ", 1e6 * least_J, "");
  EXPECT_LT(worst_J, 2e-5);
}

}  // namespace
}  // namespace thimble::test
