// Random heaps of primitive solids, with their distances in double precision.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {

[[nodiscard]] Eigen::Quaterniond random_turn(Random& random);

// The distance from a box about the origin, negative inside.
[[nodiscard]] double box_distance(const Eigen::Vector3d& half, const Eigen::Vector3d& p);

// A solid of a heap: its signed distance in its own frame.
struct Solid {
  std::function<double(const Eigen::Vector3d&)> distance_m;
  Pose pose;
};

// The distance to the nearest one, negative inside.
[[nodiscard]] double distance_m(const std::vector<Solid>& solids, const Eigen::Vector3d& p);

// Boxes, cylinders, capsules and balls; half of the boxes and cylinders stand flush on another one.
[[nodiscard]] std::vector<Solid> random_heap(Random& random, SceneBuilder& builder);

}  // namespace thimble::test
