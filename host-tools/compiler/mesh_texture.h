// Where a texture is on a mesh: what each corner of a triangle has for it in the scene image (control/scene/scene.fbs).
// The last step of compile_mesh.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

// Faces whose normals have a dot product above this join: the texture goes on over their edge. At a convex corner of 90
// degrees or more no tip is pressed from one face to the other.
inline constexpr double kTextureCorner = 1.0e-3;

struct OrientedSurface {
  const Surface& surface;
  const Adjacency& adjacency;
  const std::vector<Eigen::Vector3d>& face_normals;
  std::function<bool(std::uint32_t, std::uint32_t)> joins;  // neighbouring triangles
};

// Writes texture_weights, or texture_corners and texture_points, or none where all axes are those of the faces; and what the
// report says about it. Throws Error (kBadInput) for coordinates that are asked for and cannot be used.
void lay_texture(const TriangleSoup& soup, const OrientedSurface& faces, const MeshTexture& texture,
                 const std::string& name, CompiledMesh& mesh);

}  // namespace thimble::host
