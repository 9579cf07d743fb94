// Scenes without files: shapes and meshes written directly into a scene image, like the compiler does.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "control/scene/scene_view.h"
#include "host-tools/compiler/mesh.h"

namespace thimble::test {

inline constexpr double kDefaultStiffness_N_m = 1000.0;

struct Material {
  float stiffness_N_m = static_cast<float>(kDefaultStiffness_N_m);
  float damping_N_s_m = 0.0F;
  float static_friction = 0.0F;
  float dynamic_friction = 0.0F;
  scene::FrictionMode friction_mode = scene::FrictionMode::StickSlip;
};

struct Pose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
};

// The bytes of an image and its view for the renderer. Moving keeps the view valid; it cannot be copied.
class SceneImage {
 public:
  explicit SceneImage(
      std::vector<std::byte> bytes);  // throws std::runtime_error with the name of the status if refused
  SceneImage(SceneImage&&) = default;
  SceneImage& operator=(SceneImage&&) = default;

  [[nodiscard]] const control::SceneView& view() const { return view_; }
  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
  control::SceneView view_;
};

class SceneBuilder {
 public:
  SceneBuilder();
  ~SceneBuilder();
  SceneBuilder(const SceneBuilder&) = delete;
  SceneBuilder& operator=(const SceneBuilder&) = delete;

  SceneBuilder& plane(const Eigen::Vector3d& normal, double offset_m, const Material& material,
                      const Pose& pose = {});
  SceneBuilder& sphere(double radius_m, const Material& material, const Pose& pose = {});
  SceneBuilder& box(const Eigen::Vector3d& size_m, const Material& material, const Pose& pose = {});
  SceneBuilder& cylinder(double radius_m, double half_height_m, const Material& material,
                         const Pose& pose = {});
  SceneBuilder& capsule(double radius_m, double half_height_m, const Material& material,
                        const Pose& pose = {});
  SceneBuilder& cone(double radius_m, double height_m, const Material& material, const Pose& pose = {});
  SceneBuilder& mesh(const host::CompiledMesh& mesh, const Material& material, const Pose& pose = {});
  SceneBuilder& mesh(const host::TriangleSoup& soup, const Material& material,
                     const host::MeshOptions& options = {}, const Pose& pose = {});

  SceneBuilder& tip_radius(double radius_m);

  [[nodiscard]] std::vector<std::byte> bytes();  // may be called once
  [[nodiscard]] SceneImage image() { return SceneImage(bytes()); }

 private:
  struct State;
  std::unique_ptr<State> state_;  // keeps the FlatBuffers builder out of this header
};

// The triangles of the image, after welding, orientation and rounding to float; an oracle must use these.
[[nodiscard]] host::TriangleSoup as_soup(const host::CompiledMesh& mesh);

}  // namespace thimble::test
