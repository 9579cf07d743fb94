// The scene file as plain data, read and checked: every key, unit, range and default is documented in
// docs/scene-format.md. Used by compile_scene.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/compiler/scene_body.h"
#include "host-tools/compiler/scene_shape.h"
#include "host-tools/compiler/scene_surface.h"

namespace thimble::host {

struct SceneMaterial {
  double stiffness_N_m = 1;
  double damping_N_s_m = 0;
  double static_friction = 0;
  double dynamic_friction = 0;
  scene::FrictionMode friction_mode = scene::FrictionMode::StickSlip;
  SceneSurface surface;
};

struct SceneObject {
  std::string name;
  SceneShape shape;
  std::string shape_word;
  scene::Shape kind{};  // in the image
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  SceneMaterial material;
  std::optional<SceneBody> body;
};

struct SceneFile {
  std::string name;
  std::vector<SceneObject> objects;
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
  double tip_radius_m = 0;
};

// `name` stands in messages. Throws SceneErrors (kBadInput) with all that is wrong: each with file, line, JSON pointer, the value and what is
// allowed.
[[nodiscard]] SceneFile read_scene_file(const std::string& text, const std::string& name);

}  // namespace thimble::host
