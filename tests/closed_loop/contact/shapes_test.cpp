// The force of frictionless shapes against their closed forms.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

Quaterniond random_rotation(Random& random) {
  return Quaterniond(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian()).normalized();
}

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

// A wall whose free side is local z > 0, at local z = 0.
struct Wall {
  std::string name;
  std::function<void(SceneBuilder&, const Pose&)> add;
};

std::vector<Wall> walls() {
  const Vector3d down(0.0, 0.0, -0.01);
  const auto lowered = [down](const Pose& pose) {
    return Pose{pose.position_m + pose.rotation * down, pose.rotation};
  };
  return {
      {"plane", [](SceneBuilder& b, const Pose& pose) { b.plane(Vector3d::UnitZ(), 0.0, {}, pose); }},
      {"box",
       [=](SceneBuilder& b, const Pose& pose) {
         b.box({0.1, 0.1, 0.02}, {}, lowered(pose));
       }},
      {"cylinder", [=](SceneBuilder& b, const Pose& pose) { b.cylinder(0.05, 0.01, {}, lowered(pose)); }},
      {"cone",  // its base, 10 mm below the centre of mass
       [=](SceneBuilder& b, const Pose& pose) {
         const Quaterniond over(Eigen::AngleAxisd(std::numbers::pi, Vector3d::UnitX()));
         b.cone(0.05, 0.04, {}, {lowered(pose).position_m, pose.rotation * over});
       }},
      {"mesh",
       [=](SceneBuilder& b, const Pose& pose) {
         b.mesh(box_mesh({0.1, 0.1, 0.02}, 13), {}, {}, lowered(pose));
       }},
      {"shaded mesh",
       [=](SceneBuilder& b, const Pose& pose) {
         b.mesh(box_mesh({0.1, 0.1, 0.02}, 13), {}, {host::MeshSide::kOutside, 40.0}, lowered(pose));
       }},
      {"sheet", [](SceneBuilder& b, const Pose& pose) { b.mesh(sheet(0.1, 13), {}, {}, pose); }},
  };
}

TEST(FlatWall, PushesWithStiffnessTimesDepthAndNothingSideways) {
  Random random(1);
  for (const Wall& wall : walls()) {
    double worst = 0.0;
    double worst_sideways = 0.0;
    double worst_allowed = 0.0;
    for (int pose_index = 0; pose_index < 8; ++pose_index) {
      Pose pose;
      if (pose_index > 0) pose = {random.in_box(Vector3d::Constant(0.05)), random_rotation(random)};
      SceneBuilder builder;
      wall.add(builder, pose);
      const SceneImage image = builder.image();
      IdealRun run(image);
      const Vector3d n = pose.rotation * Vector3d::UnitZ();
      run.step(pose.position_m + 0.003 * n);
      for (int tick = 0; tick < 5000; ++tick) {
        // Half the ticks jump anywhere, half slide on from where the tip is.
        const double depth = random.uniform(-0.002, 0.005);
        const Vector3d local = tick % 2 == 0 ? random.in_box({0.03, 0.03, 0.0}) : Vector3d(0.01, 0.02, 0.0);
        const Felt& felt = run.step(pose.position_m + pose.rotation * local - depth * n);
        const double true_depth = std::max(0.0, -n.dot(felt.tip_m - pose.position_m));
        const double push = felt.force_N.dot(n);
        const double allowed = 1e-4 * kDefaultStiffness_N_m * true_depth + 1e-4;
        worst = std::max(worst, std::abs(push - kDefaultStiffness_N_m * true_depth));
        worst_sideways = std::max(worst_sideways, (felt.force_N - push * n).norm());
        worst_allowed =
            std::max({worst_allowed, std::abs(push - kDefaultStiffness_N_m * true_depth) / allowed,
                      (felt.force_N - push * n).norm() / allowed});
      }
    }
    figure("flat wall, " + wall.name + ": |F - K d|, N", worst, "1e-4 K d + 1e-4");
    figure("flat wall, " + wall.name + ": sideways, N", worst_sideways, "1e-4 K d + 1e-4");
    EXPECT_LE(worst_allowed, 1.0) << wall.name;
  }
}

TEST(FlatWall, PushesInTheFirstTickOfContact) {
  Random random(2);
  for (const Wall& wall : walls()) {
    SceneBuilder builder;
    wall.add(builder, {});
    const SceneImage image = builder.image();
    IdealRun run(image);
    int silent = 0;
    constexpr int kEntries = 2000;
    for (int entry = 0; entry < kEntries; ++entry) {
      run.step(random.in_box({0.03, 0.03, 0.0}) + Vector3d(0.0, 0.0, random.uniform(1e-6, 0.003)));
      const double depth = random.uniform(2e-6, 0.003);
      const Felt& felt = run.step(random.in_box({0.03, 0.03, 0.0}) - Vector3d(0.0, 0.0, depth));
      if (!(felt.force_N.z() > 0.9 * kDefaultStiffness_N_m * depth - 1e-4) || felt.contacts < 1) ++silent;
    }
    figure("first tick of contact without its force, " + wall.name + ", of 2000", silent, "0");
    EXPECT_EQ(silent, 0) << wall.name;
  }
}

TEST(Sphere, PushesAlongItsRadius) {
  Random random(3);
  constexpr double kRadius_m = 0.05;
  double worst_deg = 0.0;
  double worst_allowed = 0.0;
  for (int pose_index = 0; pose_index < 8; ++pose_index) {
    const Pose pose = {random.in_box(Vector3d::Constant(0.05)), random_rotation(random)};
    const SceneImage image = SceneBuilder().sphere(kRadius_m, {}, pose).image();
    IdealRun run(image);
    for (int tick = 0; tick < 20000; ++tick) {
      if (tick % 50 == 0) run.restart(pose.position_m + (kRadius_m + 0.002) * random.direction());
      const Vector3d radial =
          (run.felt().tip_m - pose.position_m).normalized() + 0.02 * random.in_box(Vector3d::Ones());
      run.step(pose.position_m + random.uniform(0.044, 0.0499) * radial.normalized());
      const Vector3d out = run.felt().tip_m - pose.position_m;
      const double expected = kDefaultStiffness_N_m * (kRadius_m - out.norm());
      worst_deg = std::max(worst_deg, expected > 0.5 ? angle_deg(run.felt().force_N, out) : 0.0);
      worst_allowed =
          std::max(worst_allowed, std::abs(run.felt().force_N.norm() - expected) / (1e-4 * expected + 1e-4));
    }
  }
  figure("sphere: direction against the radius, degrees", worst_deg, "0.1");
  figure("sphere: ||F| - K d| over 1e-4 K d + 1e-4 N", worst_allowed, "1");
  EXPECT_LE(worst_deg, 0.1);
  EXPECT_LE(worst_allowed, 1.0);
}

TEST(RoundShapes, CylinderAndCapsulePushAlongTheirRadius) {
  Random random(4);
  constexpr double kRadius_m = 0.02;
  constexpr double kHalfHeight_m = 0.05;
  for (const bool capsule : {false, true}) {
    const Pose pose = {random.in_box(Vector3d::Constant(0.05)), random_rotation(random)};
    SceneBuilder builder;
    if (capsule) {
      builder.capsule(kRadius_m, kHalfHeight_m, {}, pose);
    } else {
      builder.cylinder(kRadius_m, kHalfHeight_m, {}, pose);
    }
    const SceneImage image = builder.image();
    IdealRun run(image);
    double worst_deg = 0.0;
    double worst_allowed = 0.0;
    double around = 0.0;
    run.step(pose.position_m + pose.rotation * Vector3d(0.03, 0.0, 0.0));
    for (int tick = 0; tick < 40000; ++tick) {
      around += random.uniform(-0.03, 0.05);
      const double reach = capsule ? kHalfHeight_m + 0.018 : kHalfHeight_m - 0.005;
      const double along = reach * std::sin(0.0013 * tick);
      const double beyond = std::max(0.0, std::abs(along) - kHalfHeight_m);
      const double radius =
          std::sqrt(kRadius_m * kRadius_m - beyond * beyond) - random.uniform(0.0005, 0.002);
      if (radius < 0.003) continue;
      run.step(pose.position_m +
               pose.rotation * Vector3d(radius * std::cos(around), radius * std::sin(around), along));
      const Vector3d local = pose.rotation.conjugate() * (run.felt().tip_m - pose.position_m);
      const double middle = capsule ? std::clamp(local.z(), -kHalfHeight_m, kHalfHeight_m) : local.z();
      const Vector3d out = local - Vector3d(0.0, 0.0, middle);
      const double expected = kDefaultStiffness_N_m * (kRadius_m - out.norm());
      const Vector3d force = pose.rotation.conjugate() * run.felt().force_N;
      worst_deg = std::max(worst_deg, angle_deg(force, out));
      worst_allowed = std::max(worst_allowed, std::abs(force.norm() - expected) / (1e-4 * expected + 1e-4));
    }
    const std::string name = capsule ? "capsule" : "cylinder";
    figure(name + ": direction against the radius, degrees", worst_deg, "0.1");
    figure(name + ": ||F| - K d| over 1e-4 K d + 1e-4 N", worst_allowed, "1");
    EXPECT_LE(worst_deg, 0.1) << name;
    EXPECT_LE(worst_allowed, 1.0) << name;
  }
}

// The cones that are tried: radius and height, m.
constexpr std::array<std::array<double, 2>, 3> kCones{{{0.02, 0.05}, {0.03, 0.01}, {0.005, 0.06}}};

// A cone's side in the half-plane through its axis and a direction square to it.
struct ConeSide {
  double radius_m;
  double height_m;

  [[nodiscard]] double length_m() const { return std::hypot(radius_m, height_m); }
  [[nodiscard]] Vector3d apex() const { return {0.0, 0.0, 0.75 * height_m}; }
  [[nodiscard]] Vector3d normal(const Vector3d& direction) const {
    return (height_m * direction + radius_m * Vector3d::UnitZ()) / length_m();
  }
  // The point of the side that is down_m from the apex.
  [[nodiscard]] Vector3d at(const Vector3d& direction, double down_m) const {
    return apex() + down_m / length_m() * (radius_m * direction - height_m * Vector3d::UnitZ());
  }
};

Vector3d round_the_axis(double angle) { return {std::cos(angle), std::sin(angle), 0.0}; }

TEST(Cone, PushesAlongTheNormalOfItsSideFromTheApexToTheRim) {
  Random random(8);
  for (const auto& [radius_m, height_m] : kCones) {
    const ConeSide side{radius_m, height_m};
    const Pose pose = {random.in_box(Vector3d::Constant(0.03)), random_rotation(random)};
    const SceneImage image = SceneBuilder().cone(radius_m, height_m, {}, pose).image();
    IdealRun run(image);
    double worst_deg = 0.0;
    double worst_allowed = 0.0;
    double around = 0.0;
    run.step(pose.position_m + pose.rotation * (side.at(round_the_axis(around), 0.5 * side.length_m()) +
                                                0.004 * side.normal(round_the_axis(around))));
    for (int tick = 0; tick < 40000; ++tick) {
      around += random.uniform(-0.03, 0.05);
      const Vector3d direction = round_the_axis(around);
      const double down = side.length_m() * (0.5 + 0.49 * std::sin(0.0013 * tick));
      // No deeper than half the way to the axis.
      const double deepest = std::min(0.002, 0.5 * down * radius_m / height_m);
      const Vector3d local =
          side.at(direction, down) - random.uniform(0.2, 1.0) * deepest * side.normal(direction);
      run.step(pose.position_m + pose.rotation * local);
      const Vector3d seen = pose.rotation.conjugate() * (run.felt().tip_m - pose.position_m);
      const Vector3d seen_direction = Vector3d(seen.x(), seen.y(), 0.0).normalized();
      const Vector3d normal = side.normal(seen_direction);
      const double expected = kDefaultStiffness_N_m * normal.dot(side.apex() - seen);
      const Vector3d force = pose.rotation.conjugate() * run.felt().force_N;
      if (expected > 0.5) worst_deg = std::max(worst_deg, angle_deg(force, normal));
      worst_allowed = std::max(worst_allowed, (force - expected * normal).norm() / (1e-4 * expected + 1e-4));
    }
    const std::string name = "cone " + std::to_string(radius_m) + " x " + std::to_string(height_m);
    figure(name + ": direction against the side's normal, degrees", worst_deg, "0.1");
    figure(name + ": |F - K d n| over 1e-4 K d + 1e-4 N", worst_allowed, "1");
    EXPECT_LE(worst_deg, 0.1) << name;
    EXPECT_LE(worst_allowed, 1.0) << name;
  }
}

TEST(Cone, StraightFlightsLandOnTheSideOrTheBase) {
  // From outside to a point inside: the flight ends where the straight line meets the cone first, and the push is that of the part it met.
  Random random(9);
  for (const auto& [radius_m, height_m] : kCones) {
    const ConeSide side{radius_m, height_m};
    const SceneImage image = SceneBuilder().cone(radius_m, height_m, {}).image();
    IdealRun run(image);
    const auto outside_m = [&](const Vector3d& p) {
      const Vector3d direction = Vector3d(p.x(), p.y(), 0.0).normalized();
      return std::max(side.normal(direction).dot(p - side.apex()), -0.25 * side.height_m - p.z());
    };
    double worst = 0.0;
    int silent = 0;
    int through_the_base = 0;
    constexpr int kFlights = 4000;
    for (int flight = 0; flight < kFlights; ++flight) {
      Vector3d from;
      do {
        from = random.in_box({2.0 * radius_m, 2.0 * radius_m, 1.5 * height_m});
      } while (outside_m(from) < 1e-4);
      Vector3d to;
      do {
        to = random.in_box({radius_m, radius_m, height_m});
      } while (outside_m(to) > -1e-5);
      run.restart(from);
      const Felt& felt = run.step(to);
      if (felt.contacts == 0) {
        ++silent;
        continue;
      }
      // Where the straight line meets the convex solid, by halving.
      double out = 0.0;
      double in = 1.0;
      for (int halving = 0; halving < 60; ++halving) {
        const double middle = 0.5 * (out + in);
        (outside_m(from + middle * (to - from)) > 0.0 ? out : in) = middle;
      }
      const Vector3d landed = from + out * (to - from);
      const bool on_base = landed.z() < -0.25 * height_m + 1e-7 * height_m;
      if (on_base) ++through_the_base;
      const bool near_rim = std::abs(landed.z() + 0.25 * height_m) < 1e-5 && !on_base;
      if (near_rim) continue;
      const Vector3d direction = Vector3d(felt.tip_m.x(), felt.tip_m.y(), 0.0).normalized();
      const Vector3d normal = on_base ? Vector3d(-Vector3d::UnitZ()) : side.normal(direction);
      const double depth = on_base ? felt.tip_m.z() + 0.25 * height_m : normal.dot(side.apex() - felt.tip_m);
      const double allowed = 1e-4 * kDefaultStiffness_N_m * depth + 1e-4;
      worst = std::max(worst, (felt.force_N - kDefaultStiffness_N_m * depth * normal).norm() / allowed);
    }
    const std::string name = "cone " + std::to_string(radius_m) + " x " + std::to_string(height_m);
    figure(name + ": |F - K d n| after a flight, over 1e-4 K d + 1e-4 N", worst, "1");
    figure(name + ": flights into it without a force", silent, "0");
    figure(name + ": flights through the base, of 4000", through_the_base, "> 100");
    EXPECT_LE(worst, 1.0) << name;
    EXPECT_EQ(silent, 0) << name;
    EXPECT_GT(through_the_base, 100) << name;
  }
}

TEST(Cone, ATipPressedOnTheApexIsHeldAndOneThatLeavesFeelsNothing) {
  // Straight down, a few micrometres beside the axis: the side that is nearest to the tip holds it. Then out again in any direction
  // that is not downwards: no force outside.
  Random random(10);
  for (const auto& [radius_m, height_m] : kCones) {
    const ConeSide side{radius_m, height_m};
    const SceneImage image = SceneBuilder().cone(radius_m, height_m, {}).image();
    IdealRun run(image);
    double worst = 0.0;
    double outside_N = 0.0;
    for (int poke = 0; poke < 400; ++poke) {
      const Vector3d beside = random.uniform(0.0, 5e-6) * round_the_axis(random.uniform(0.0, 6.28));
      run.restart(side.apex() + beside + Vector3d(0.0, 0.0, 0.002));
      for (int step = 1; step <= 40; ++step) {
        run.step(side.apex() + beside + Vector3d(0.0, 0.0, 0.002 - 1e-4 * step));
        const Vector3d seen = run.felt().tip_m;
        const double across = seen.head<2>().norm();
        const double depth = -(height_m * across + radius_m * (seen.z() - side.apex().z())) / side.length_m();
        if (std::abs(depth) < 1e-6) continue;  // touching or not: either is right
        const double push = run.felt().force_N.norm();
        worst = std::max(worst, std::abs(push - std::max(0.0, kDefaultStiffness_N_m * depth)) /
                                    (1e-4 * kDefaultStiffness_N_m * std::abs(depth) + 1e-3));
      }
      Vector3d direction = random.direction();
      direction.z() =
          std::abs(direction.z());  // down through the base the side would hold it, as a plate would
      run.move(side.apex() + 0.02 * direction, 2e-5);
      outside_N = std::max(outside_N, run.felt().force_N.norm());
    }
    const std::string name = "cone " + std::to_string(radius_m) + " x " + std::to_string(height_m);
    figure(name + ": ||F| - K d| on the apex, over 1e-4 K d + 1e-3 N", worst, "1");
    figure(name + ": force after the tip has left it, N", outside_N, "0");
    EXPECT_LE(worst, 1.0) << name;
    EXPECT_EQ(outside_N, 0.0) << name;
  }
}

// Two walls that meet at 90 degrees on the y axis, the free side above, each with its own stiffness.
struct Groove {
  std::string name;
  double left_N_m;
  double right_N_m;
  std::function<void(SceneBuilder&, const Groove&)> add;
};

std::vector<Groove> grooves() {
  const auto stiff = [](double k) { return Material{.stiffness_N_m = static_cast<float>(k)}; };
  const Vector3d left_n = Vector3d(1.0, 0.0, 1.0).normalized();
  const Vector3d right_n = Vector3d(-1.0, 0.0, 1.0).normalized();
  const Quaterniond tilt(Eigen::AngleAxisd(std::numbers::pi / 4.0, Vector3d::UnitY()));
  // After the tilt local x points along (1, 0, -1) and local z along (1, 0, 1). Each box reaches well past
  // the other's face.
  return {{"two planes", 500.0, 1500.0,
           [=](SceneBuilder& b, const Groove& g) {
             b.plane(left_n, 0.0, stiff(g.left_N_m)).plane(right_n, 0.0, stiff(g.right_N_m));
           }},
          {"two boxes", 700.0, 1200.0,
           [=](SceneBuilder& b, const Groove& g) {
             b.box({0.2, 0.2, 0.04}, stiff(g.left_N_m), {-0.02 * left_n, tilt});
             b.box({0.04, 0.2, 0.2}, stiff(g.right_N_m), {-0.02 * right_n, tilt});
           }},
          {"plane and mesh box", 1500.0, 400.0,
           [=](SceneBuilder& b, const Groove& g) {
             b.plane(left_n, 0.0, stiff(g.left_N_m));
             b.mesh(box_mesh({0.04, 0.2, 0.2}, 7), stiff(g.right_N_m), {}, {-0.02 * right_n, tilt});
           }},
          {"one mesh", 1000.0, 1000.0, [=](SceneBuilder& b, const Groove& g) {
             b.mesh(v_groove(90.0, 0.03, 0.2, 11), stiff(g.left_N_m));
           }}};
}

TEST(Groove, PushesWithBothWallsFromTheFirstTickEachWithItsOwnStiffness) {
  Random random(5);
  const Vector3d left_n = Vector3d(1.0, 0.0, 1.0).normalized();
  const Vector3d right_n = Vector3d(-1.0, 0.0, 1.0).normalized();
  for (const Groove& groove : grooves()) {
    SceneBuilder builder;
    groove.add(builder, groove);
    const SceneImage image = builder.image();
    IdealRun run(image);
    double worst_first = 0.0;
    double worst_later = 0.0;
    int fewer = 0;
    for (int entry = 0; entry < 2000; ++entry) {
      run.restart({random.uniform(-0.001, 0.001), random.uniform(-0.05, 0.05), random.uniform(0.002, 0.01)});
      for (int tick = 0; tick < 20; ++tick) {
        const double left_m = random.uniform(1e-5, 0.004);
        const double right_m = random.uniform(1e-5, 0.004);
        const Vector3d along(0.0, run.felt().tip_m.y() + random.uniform(-0.003, 0.003), 0.0);
        const Felt& felt = run.step(along - left_m * left_n - right_m * right_n);
        const Vector3d expected = -groove.left_N_m * left_n.dot(felt.tip_m) * left_n -
                                  groove.right_N_m * right_n.dot(felt.tip_m) * right_n;
        double& worst = tick == 0 ? worst_first : worst_later;
        // What the force is off, as a shift of the stiffer wall.
        worst =
            std::max(worst, (felt.force_N - expected).norm() / std::max(groove.left_N_m, groove.right_N_m));
        if (felt.contacts < 2) ++fewer;
      }
    }
    figure("groove, " + groove.name + ": error in the first tick, um at K", 1e6 * worst_first, "1");
    figure("groove, " + groove.name + ": error later, um at K", 1e6 * worst_later, "1");
    figure("groove, " + groove.name + ": ticks with fewer than two contacts", fewer, "0");
    EXPECT_LE(worst_first, 1e-6) << groove.name;
    EXPECT_LE(worst_later, 1e-6) << groove.name;
    EXPECT_EQ(fewer, 0) << groove.name;
  }
}

TEST(Corner, PushesWithThreeWallsEachWithItsOwnStiffness) {
  Random random(6);
  const Vector3d stiffness(600.0, 1000.0, 1400.0);
  const auto stiff = [&](int axis) { return Material{.stiffness_N_m = static_cast<float>(stiffness[axis])}; };
  for (const bool mesh : {false, true}) {
    const Quaterniond turn = random_rotation(random);
    SceneBuilder builder;
    if (mesh) {  // the near low corner of a room seen from inside
      builder.mesh(box_mesh({0.1, 0.1, 0.1}, 9), {}, {host::MeshSide::kInside, {}},
                   {turn * Vector3d::Constant(0.05), turn});
    } else {
      for (int axis = 0; axis < 3; ++axis)
        builder.plane(Vector3d::Unit(axis), 0.0, stiff(axis), {Vector3d::Zero(), turn});
    }
    const SceneImage image = builder.image();
    IdealRun run(image);
    double worst = 0.0;
    int fewer = 0;
    for (int entry = 0; entry < 4000; ++entry) {
      if (entry % 4 == 0)
        run.restart(turn * (Vector3d::Constant(0.006) + random.in_box(Vector3d::Constant(0.005))));
      const Vector3d depth = Vector3d::Constant(0.0021) + random.in_box(Vector3d::Constant(0.002));
      const Felt& felt = run.step(turn * -depth);
      const Vector3d seen = turn.conjugate() * felt.tip_m;
      const Vector3d pushes =
          -(mesh ? Vector3d(Vector3d::Constant(kDefaultStiffness_N_m)) : stiffness).cwiseProduct(seen);
      worst = std::max(worst, (felt.force_N - turn * pushes).norm() / stiffness.maxCoeff());
      if (felt.contacts != 3) ++fewer;
    }
    const std::string name = mesh ? "mesh room" : "three planes";
    figure("corner, " + name + ": error, um at K", 1e6 * worst, "1");
    figure("corner, " + name + ": ticks without three contacts", fewer, "0");
    EXPECT_LE(worst, 1e-6) << name;
    EXPECT_EQ(fewer, 0) << name;
  }
}

TEST(Damping, AddsOnTheWayInAndNeverPulls) {
  Random random(7);
  const Material damped = {.damping_N_s_m = 2.0F};
  struct Case {
    std::string name;
    SceneImage image;
    std::function<Vector3d(const Vector3d&)> normal;
    double surface_m;  // along the normal from the origin
  };
  const auto up = [](const Vector3d&) { return Vector3d(Vector3d::UnitZ()); };
  const auto radial = [](const Vector3d& p) { return Vector3d(p.normalized()); };
  std::vector<Case> cases;
  cases.push_back({"plane", SceneBuilder().plane(Vector3d::UnitZ(), 0.0, damped).image(), up, 0.0});
  cases.push_back({"box", SceneBuilder().box({0.1, 0.1, 0.1}, damped).image(), up, 0.05});
  cases.push_back({"sphere", SceneBuilder().sphere(0.05, damped).image(), radial, 0.05});
  cases.push_back({"mesh box", SceneBuilder().mesh(box_mesh({0.1, 0.1, 0.1}, 5), damped).image(), up, 0.05});
  for (const Case& test : cases) {
    IdealRun run(test.image);
    double lowest = 0.0;
    double worst = 0.0;
    run.step({0.0, 0.0, test.surface_m + 0.001});
    for (int tick = 0; tick < 20000; ++tick) {
      const Vector3d before = run.felt().tip_m;
      const double height = 0.002 * std::sin(0.05 * tick) - 0.0005 + 2e-5 * random.gaussian();
      const Felt& felt = run.step({0.0, 0.0, test.surface_m + height});
      const Vector3d n = test.normal(felt.tip_m);
      const double depth = test.surface_m - n.dot(felt.tip_m);
      const double inwards_m_s = -n.dot(felt.tip_m - before) * kRate_Hz;
      const double push = felt.force_N.dot(n);
      lowest = std::min(lowest, push);
      if (std::abs(depth) < 1e-6) continue;  // touching or not: either is right
      const double expected = depth > 0.0 ? std::max(0.0, 1000.0 * depth + 2.0 * inwards_m_s) : 0.0;
      worst = std::max(worst, std::abs(push - expected) / (1e-4 * expected + 1e-3));
    }
    figure("damping, " + test.name + ": lowest push, N", lowest, ">= 0");
    figure("damping, " + test.name + ": |F - max(0, K d + B v)| over 1e-4 F + 1e-3 N", worst, "1");
    EXPECT_GE(lowest, 0.0) << test.name;
    EXPECT_LE(worst, 1.0) << test.name;
  }
}

}  // namespace
}  // namespace thimble::test
