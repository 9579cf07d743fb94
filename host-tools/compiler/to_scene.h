// A vector as the scene image holds it.
#pragma once

#include <Eigen/Core>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

[[nodiscard]] inline scene::Vec3 to_scene(const Eigen::Vector3f& v) { return {v.x(), v.y(), v.z()}; }
[[nodiscard]] inline scene::Vec3 to_scene(const Eigen::Vector3d& v) {
  return to_scene(Eigen::Vector3f(v.cast<float>()));
}

}  // namespace thimble::host
