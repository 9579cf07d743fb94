// The part of the scene file about objects that move: `body` of an object. docs/scene-format.md, "Moving objects".
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>

#include "host-tools/compiler/scene_control.h"
#include "host-tools/compiler/scene_value.h"
#include "host-tools/compiler/shape_mass.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

struct SceneBody {
  scene::Motion motion = scene::Motion::Free;
  double mass_kg = 0;
  std::optional<Eigen::Vector3d>
      centre_m;  // of mass, in the object's frame; absent: the shape's at uniform density
  std::optional<Eigen::Vector3d> inertia_kg_m2;  // absent: the shape's at uniform density
  double restitution = 0;
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_rad_s = Eigen::Vector3d::Zero();
  double spring_N_m = 0;
  double damping_N_s_m = 0;
  double angular_damping_N_m_s = 0;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();
  std::optional<Eigen::Vector3d> pivot_m;  // absent: the object's position
  std::optional<SceneControlElement> control;
  std::string place;  // in the scene file, for errors
};

[[nodiscard]] SceneBody read_body(const Value& value);
[[nodiscard]] bool rotates(scene::Motion motion);

// mass: of the shape; stiffest_N_m: of the surface, anywhere; position and rotation are the object's.
// Error `body-too-light` for a body that would oscillate by itself under a fingertip, and the errors of write_control.
[[nodiscard]] flatbuffers::Offset<scene::Body> write_body(flatbuffers::FlatBufferBuilder& builder,
                                                          const SceneBody& body, const ShapeMass& mass,
                                                          double stiffest_N_m,
                                                          const Eigen::Vector3d& position_m,
                                                          const Eigen::Quaterniond& rotation);

}  // namespace thimble::host
