// Where a tip with a size that lies on a face of a mesh touches nothing but this face. Called by compile_mesh.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"
#include "host-tools/compiler/mesh_tree.h"

namespace thimble::host {

struct RimSurface {
  const Surface& surface;
  const MeshTree& tree;
  const Adjacency& adjacency;
  const std::vector<std::uint8_t>& flags;  // scene::TriangleFlag
  const std::vector<Eigen::Vector3d>& face_normals;
};

// Mesh.rims of the scene image (control/scene/scene.fbs). The controller trusts them: a tip that keeps to them needs no look at the
// triangles nearby.
[[nodiscard]] std::vector<std::uint8_t> tip_rims(const RimSurface& mesh, double tip_radius_m);

}  // namespace thimble::host
