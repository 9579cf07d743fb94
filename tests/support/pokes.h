// What the tests that poke into meshes have in common.
#pragma once

#include <Eigen/Geometry>

#include "tests/support/random.h"
#include "tests/support/scene.h"

namespace thimble::test {

inline Eigen::Quaterniond random_turn(Random& random) {
  return Eigen::Quaterniond(random.gaussian(), random.gaussian(), random.gaussian(), random.gaussian())
      .normalized();
}

// Half of them without friction.
inline Material random_material(Random& random) {
  Material material{.stiffness_N_m = 1000.0F};
  if (random.below(2) == 0) return material;
  material.static_friction = static_cast<float>(random.uniform(0.1, 1.0));
  material.dynamic_friction = static_cast<float>(random.uniform(0.5, 1.0)) * material.static_friction;
  return material;
}

}  // namespace thimble::test
