// Depth, normal and points of colliding solids against an oracle in double precision.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "control/bodies/pair_collision.h"
#include "control/contact/world.h"
#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

// A convex solid by its farthest point in a direction.
struct Solid {
  std::string shape;  // in the scene file
  double x, y, z;     // sizes
  Vector3d (*farthest)(const Solid&, const Vector3d&);
};

Vector3d flat(const Vector3d& d, double radius) {
  const double length = std::hypot(d.x(), d.y());
  return length > 0 ? Vector3d(radius * d.x() / length, radius * d.y() / length, 0) : Vector3d(radius, 0, 0);
}
Vector3d of_box(const Solid& s, const Vector3d& d) {
  return {std::copysign(s.x / 2, d.x()), std::copysign(s.y / 2, d.y()), std::copysign(s.z / 2, d.z())};
}
Vector3d of_cylinder(const Solid& s, const Vector3d& d) {
  return flat(d, s.x) + Vector3d(0, 0, std::copysign(s.y / 2, d.z()));
}
Vector3d of_cone(const Solid& s, const Vector3d& d) {
  const Vector3d rim = flat(d, s.x) - Vector3d(0, 0, s.y / 4);
  const Vector3d apex(0, 0, .75 * s.y);
  return d.dot(apex) > d.dot(rim) ? apex : rim;
}

std::vector<Solid> solids() {
  return {{R"("box": {"size_m": [0.03, 0.02, 0.05]})", .03, .02, .05, of_box},
          {R"("cylinder": {"radius_m": 0.012, "height_m": 0.05})", .012, .05, 0, of_cylinder},
          {R"("cylinder": {"radius_m": 0.02, "height_m": 0.006})", .02, .006, 0, of_cylinder},
          {R"("cone": {"radius_m": 0.015, "height_m": 0.03})", .015, .03, 0, of_cone}};
}

struct Posed {
  Solid solid;
  Eigen::Matrix3d rotation;
  Vector3d position;

  [[nodiscard]] Vector3d farthest(const Vector3d& d) const {
    return rotation * solid.farthest(solid, rotation.transpose() * d) + position;
  }
};

double depth_along(const Posed& a, const Posed& b, const Vector3d& n) {
  return n.dot(b.farthest(n) - a.farthest(-n));
}

// The least overlap over all directions: descent from many of them.
double least_depth(const Posed& a, const Posed& b, int starts, Random& random, Vector3d& best) {
  double least = 1e9;
  std::vector<std::pair<double, Vector3d>> from;
  for (int i = 0; i < starts; ++i) {
    const Vector3d n = random.in_box(Vector3d::Ones()).normalized();
    from.emplace_back(depth_along(a, b, n), n);
  }
  for (int i = 0; i < 3; ++i)
    for (const Posed* each : {&a, &b})
      for (const double sign : {1.0, -1.0}) {
        const Vector3d n = sign * each->rotation.col(i);
        from.emplace_back(depth_along(a, b, n), n);
      }
  std::sort(from.begin(), from.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  from.resize(12);
  for (auto [depth, n] : from) {
    for (double step = .1; step > 1e-6; step *= .75) {
      for (int k = 0; k < 12; ++k) {
        const Vector3d to = (n + step * random.in_box(Vector3d::Ones())).normalized();
        const double there = depth_along(a, b, to);
        if (there >= depth) continue;
        depth = there;
        n = to;
      }
    }
    if (depth < least) {
      least = depth;
      best = n;
    }
  }
  return least;
}

TEST(Convex, TheDepthOfEveryPairIsTheLeastOverlap) {
  const std::vector<Solid> kinds = solids();
  Random random(7);
  double worst_m = 0;
  double worst_point_m = 0;
  int met = 0;
  const int pairs = kUnderSanitizers ? 40 : 120;
  for (int i = 0; i < pairs; ++i) {
    Posed a{kinds[static_cast<std::size_t>(i) % kinds.size()], {}, {}};
    Posed b{kinds[static_cast<std::size_t>(i) / kinds.size() % kinds.size()], {}, {}};
    const auto turn = [&] {
      return Eigen::Quaterniond(random.in_box(Vector3d::Ones()).x(), random.in_box(Vector3d::Ones()).x(),
                                random.in_box(Vector3d::Ones()).x(), random.in_box(Vector3d::Ones()).x())
          .normalized()
          .cast<float>();
    };
    const Eigen::Quaternionf qa = turn();
    const Eigen::Quaternionf qb = turn();
    a.rotation = qa.toRotationMatrix().cast<double>();
    b.rotation = qb.toRotationMatrix().cast<double>();
    // Along a random direction until they overlap by a little, or are a little apart.
    const Vector3d away = random.in_box(Vector3d::Ones()).normalized();
    const double wanted = -5e-5 + 2.5e-4 * (i % 5) / 4.0;
    a.position = Vector3d::Zero();
    b.position = Vector3d::Zero();
    Vector3d normal;
    double lo = 0;
    double hi = .12;
    for (int k = 0; k < 14; ++k) {
      a.position = .5 * (lo + hi) * away;
      (least_depth(a, b, 40, random, normal) > wanted ? lo : hi) = .5 * (lo + hi);
    }
    a.position = (.5 * (lo + hi) * away).cast<float>().cast<double>();
    const double depth = least_depth(a, b, 200, random, normal);

    control::World world;
    const SceneImage image = scene_of(R"("objects": [{"name": "a", "shape": {)" + a.solid.shape +
                                      R"(}, "material": {"stiffness_N_m": 1}}, {"name": "b", "shape": {)" +
                                      b.solid.shape + R"(}, "material": {"stiffness_N_m": 1}}])");
    world.bind(image.view());
    world.objects[0].rotation = a.rotation.cast<float>();
    world.objects[1].rotation = b.rotation.cast<float>();
    world.objects[0].turned = world.objects[1].turned = true;
    world.objects[0].position_m = a.position.cast<float>();
    control::Manifold manifold;
    constexpr float kMargin_m = 2e-4F;
    control::PairCollision collision;
    control::Work unbounded;
    collision.begin(world.objects[0], world.objects[1]);
    while (!collision.step(world.objects[0], world.objects[1], kMargin_m, unbounded, manifold)) {
    }
    if (manifold.count == 0) {
      ADD_FAILURE() << i << ": " << a.solid.shape << b.solid.shape << " depth " << depth;
      continue;
    }
    ++met;
    double deepest = -1;
    for (std::size_t k = 0; k < manifold.count; ++k) {
      const auto& point = manifold.points[k];
      deepest = std::max(deepest, static_cast<double>(point.depth_m));
      const Vector3d n = point.normal.cast<double>();
      EXPECT_NEAR(n.norm(), 1, 1e-5);
      // Between the two surfaces: not farther from either along the normal than half the depth.
      const Vector3d p = point.point_m.cast<double>();
      worst_point_m = std::max({worst_point_m, n.dot(p - b.farthest(n)), n.dot(a.farthest(-n) - p)});
    }
    // The oracle's descents can miss the best direction: what is less along the normal that was found is right as well.
    const double along = depth_along(a, b, manifold.points[0].normal.cast<double>());
    worst_m = std::max(worst_m, std::abs(deepest - std::min(depth, along)));
  }
  figure("random pairs that touch: met", met, std::to_string(pairs));
  figure("depth against the least overlap over all directions, at most off, um", 1e6 * worst_m, "< 25");
  figure("points outside of the overlap, um", 1e6 * worst_point_m, "< 100");
  EXPECT_LT(worst_m, 2.5e-5);
  EXPECT_LT(worst_point_m, 1.1e-4);
}

}  // namespace
}  // namespace thimble::test
