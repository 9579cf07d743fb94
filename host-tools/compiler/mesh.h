// Compiles a triangle soup into the mesh of the scene image: weld, orient, creases, tree, quantisation.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// A mesh as a file gives it, already scaled to metres.
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

enum class MeshSide { kOutside, kInside, kBoth };

struct MeshOptions {
  MeshSide side = MeshSide::kOutside;
  std::optional<double> crease_deg;  // none: faceted. Edges sharper than this stay sharp
  bool height_field = false;         // only faces that look up (+z) are shaded, and only into each other
};

// The compiler's report: what a user wants to know about the mesh before touching it.
struct MeshReport {
  std::size_t input_triangles = 0;
  std::size_t triangles = 0;
  std::size_t vertices = 0;
  std::size_t open_edges = 0;
  std::size_t non_manifold_edges = 0;
  std::size_t components = 0;
  std::size_t flipped_components = 0;
  std::size_t degenerate_dropped = 0;
  std::size_t fins_cancelled = 0;   // faces with their own reverse
  std::size_t unused_vertices = 0;  // of the file
  std::size_t pierced_triangles = 0;
  std::size_t bytes = 0;  // mesh and tree together, in the image
  unsigned depth = 0;     // of the tree
};

struct CompiledMesh {
  std::vector<scene::Vertex> vertices;
  std::vector<scene::Triangle> triangles;
  std::vector<std::uint8_t> flags;
  std::vector<std::uint32_t> corner_normals;
  std::vector<scene::BvhNode> nodes;
  scene::Vec3 grid_origin_m;
  float grid_step_m = 0;
  std::uint8_t depth = 0;
  MeshReport report;
};

// Deterministic: the same soup and options give the same bytes on every machine. `name` is used in messages.
// Throws Error (kBadInput) for a mesh without a usable triangle or over the controller's limits.
[[nodiscard]] CompiledMesh compile_mesh(const TriangleSoup& soup, const MeshOptions& options,
                                        const std::string& name);

}  // namespace thimble::host
