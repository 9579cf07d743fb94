// The scene file as plain data, read and checked: every key, unit, range and default is documented in
// docs/scene-format.md. Used by compile_scene.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/scene_body.h"
#include "host-tools/compiler/scene_field.h"
#include "host-tools/compiler/scene_height_field.h"
#include "host-tools/compiler/scene_surface.h"
#include "host-tools/compiler/scene_tissue.h"

namespace thimble::host {

struct PlaneShape {
  Eigen::Vector3d normal;  // of unit length
  double offset_m;
};
struct SphereShape {
  double radius_m;
};
struct BoxShape {
  Eigen::Vector3d size_m;
};
struct CylinderShape {
  double radius_m;
  double height_m;
};
struct CapsuleShape {
  double radius_m;
  double height_m;
};
struct MeshShape {
  std::string file;  // relative to the scene file
  double scale_m;
  MeshOptions options;
  std::string place;  // "file:line: /pointer" for messages
};

struct SceneMaterial {
  double stiffness_N_m;
  double damping_N_s_m;
  double static_friction;
  double dynamic_friction;
  scene::FrictionMode friction_mode;
  SceneSurface surface;
};

struct SceneObject {
  std::string name;
  std::variant<PlaneShape, SphereShape, BoxShape, CylinderShape, CapsuleShape, MeshShape, HeightFieldShape,
               VectorFieldShape, PotentialFieldShape, NeedleShape, TissueShape>
      shape;
  std::string shape_word;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  SceneMaterial material;
  std::optional<SceneBody> body;
};

struct SceneFile {
  std::string name;
  std::vector<SceneObject> objects;
  Eigen::Vector3d gravity_m_s2 = Eigen::Vector3d::Zero();
};

// `name` stands in messages. Throws Error (kBadInput) with file, line, JSON pointer, the value and what is
// allowed.
[[nodiscard]] SceneFile read_scene_file(const std::string& text, const std::string& name);

}  // namespace thimble::host
