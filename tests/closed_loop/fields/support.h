// Scenes with fields for the tests of this folder.
#pragma once

#include <Eigen/Core>
#include <string>

#include "tests/support/ideal_run.h"
#include "tests/support/scene.h"

namespace thimble::test {

inline constexpr double kStiffness_N_m = 500.0;

// One object "it" at the origin, of that stiffness unless told otherwise. `material` and `shape` are JSON objects without their braces.
[[nodiscard]] SceneImage one_object(const std::string& shape,
                                    const std::string& material = "\"stiffness_N_m\": 500",
                                    const std::string& pose = "");

// The largest step of the force along the straight line from a to b, in steps of `step_m`; the first place it happens.
struct ForceStep {
  double most_N = 0;
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();
};
void add_largest_step(IdealRun& run, const Eigen::Vector3d& to, double step_m, ForceStep& step);

}  // namespace thimble::test
