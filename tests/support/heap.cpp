#include "tests/support/heap.h"

#include <algorithm>
#include <cmath>

namespace thimble::test {

using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;

Quaterniond random_turn(Random& random) {
  return Quaterniond(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian()).normalized();
}

double box_distance(const Vector3d& half, const Vector3d& p) {
  const Vector3d q = p.cwiseAbs() - half;
  return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
}

double distance_m(const std::vector<Solid>& solids, const Vector3d& p) {
  double least = 1.0;
  for (const Solid& solid : solids)
    least = std::min(least, solid.distance_m(solid.pose.rotation.conjugate() * (p - solid.pose.position_m)));
  return least;
}

std::vector<Solid> random_heap(Random& random, SceneBuilder& builder) {
  std::vector<Solid> solids;
  Pose last;
  Vector3d last_half = Vector3d::Zero();
  for (int object = 0; object < 7; ++object) {
    const Material m{.stiffness_N_m = 1000.0F};
    Pose pose{random.in_box(Vector3d::Constant(0.015)), random_turn(random)};
    const Vector3d half(random.uniform(0.003, 0.009), random.uniform(0.003, 0.009),
                        random.uniform(0.003, 0.009));
    const bool flush = last_half.x() > 0.0 && random.below(2) == 0;
    if (flush) {
      const double shift = random.below(2) == 0 ? 0.0 : random.uniform(-0.006, 0.006);
      pose = {last.position_m +
                  last.rotation * Vector3d(last_half.x() + half.x(), shift, last_half.z() - half.z()),
              last.rotation};
    }
    const std::uint64_t kind = flush ? 0 : random.below(4);
    if (kind == 0) {
      builder.box(2.0 * half, m, pose);
      solids.push_back({[half](const Vector3d& p) { return box_distance(half, p); }, pose});
      last = pose;
      last_half = half;
    } else if (kind == 1) {
      builder.cylinder(half.x(), half.z(), m, pose);
      solids.push_back({[half](const Vector3d& p) {
                          const Vector2d q(p.head<2>().norm() - half.x(), std::abs(p.z()) - half.z());
                          return q.maxCoeff() < 0.0 ? q.maxCoeff() : q.cwiseMax(0.0).norm();
                        },
                        pose});
    } else if (kind == 2) {
      builder.capsule(half.x(), half.z(), m, pose);
      solids.push_back({[half](const Vector3d& p) {
                          return (p - Vector3d(0.0, 0.0, std::clamp(p.z(), -half.z(), half.z()))).norm() -
                                 half.x();
                        },
                        pose});
    } else {
      builder.sphere(half.x(), m, pose);
      solids.push_back({[half](const Vector3d& p) { return p.norm() - half.x(); }, pose});
    }
  }
  return solids;
}

}  // namespace thimble::test
