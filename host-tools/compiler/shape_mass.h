// The mass of a shape at uniform density: where its centre is, and how it resists rotation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

// For a mass of 1 kg, in the object's frame.
struct ShapeMass {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d inertia_m2 = Eigen::Matrix3d::Zero();  // about the centre
};

// Of what a closed mesh encloses; no value where it is open or encloses nothing. What several closed parts enclose together counts
// once for each of them.
[[nodiscard]] std::optional<ShapeMass> volume_mass(const CompiledMesh& mesh);
// Of the surface of a mesh as a sheet of uniform thickness.
[[nodiscard]] ShapeMass surface_mass(const CompiledMesh& mesh);

// The inertia about another point.
[[nodiscard]] Eigen::Matrix3d inertia_about(const ShapeMass& mass, const Eigen::Vector3d& point_m);

// Principal moments, with their axes in the object's frame: exactly the object's axes where those are principal axes but for rounding.
struct PrincipalInertia {
  Eigen::Vector3d moments = Eigen::Vector3d::Zero();
  Eigen::Quaterniond axes = Eigen::Quaterniond::Identity();
};
[[nodiscard]] PrincipalInertia principal_inertia(const Eigen::Matrix3d& inertia);

}  // namespace thimble::host
