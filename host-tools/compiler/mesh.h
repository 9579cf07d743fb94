// Compiles a triangle soup into the mesh of the scene image: weld, orient, creases, tree, quantisation.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// A mesh as a file gives it, already scaled to metres.
struct TriangleSoup {
  std::vector<Eigen::Vector3d> vertices_m;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<Eigen::Vector2d> vertices_uv;  // texture coordinates; empty: none, NaN: not of this vertex
};

enum class TextureMapping : std::uint8_t {
  kAuto,  // by coordinates where the file has them and they have few seams, else blended
  kCoordinates,
  kBlended,
};

struct MeshTexture {
  TextureMapping mapping = TextureMapping::kAuto;
  std::array<double, 2> tile_m{};
};

enum class MeshSide { kOutside, kInside, kBoth };

struct MeshOptions {
  MeshSide side = MeshSide::kOutside;
  std::optional<double> crease_deg;  // none: faceted. Edges sharper than this stay sharp
  bool height_field = false;         // only faces that look up (+z) are shaded, and only into each other
  std::optional<MeshTexture> texture{};
  double tip_radius_m = 0.0;  // of the scene
  std::function<void(double)>
      progress{};  // called between the steps, with the share of the time that has passed
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
  std::size_t fins_cancelled = 0;     // faces with their own reverse
  std::size_t unused_vertices = 0;    // of the file
  std::size_t pierced_triangles = 0;  // that touch or cross others
  std::size_t seam_triangles = 0;     // near another part of the mesh
  std::array<std::size_t, 2>
      texture_tiles{};                     // in a unit of the file's coordinates; 0: blended, or no texture
  std::array<double, 2> texture_tile_m{};  // mean length of a tile then
  double texture_faded = 0.0;              // part of the area where it fades towards seams
  std::size_t bytes = 0;                   // mesh and tree together, in the image
  unsigned depth = 0;                      // of the tree
};

struct CompiledMesh {
  std::vector<scene::Vertex> vertices;
  std::vector<scene::Triangle> triangles;
  std::vector<std::uint8_t> flags;
  std::vector<std::uint32_t> corner_normals;
  std::vector<scene::BvhNode> nodes;
  std::vector<std::uint32_t> texture_weights;
  std::vector<std::uint32_t> texture_corners;
  std::vector<scene::TexturePoint> texture_points;
  std::vector<std::uint8_t> rims;
  scene::Vec3 grid_origin_m;
  float grid_step_m = 0;
  std::uint8_t depth = 0;
  bool seams = false;  // any flag Seam
  MeshReport report;
};

// Deterministic: the same soup and options give the same bytes on every machine. `name` is used in messages.
// Throws Error (kBadInput) for a mesh without a usable triangle or over the controller's limits.
[[nodiscard]] CompiledMesh compile_mesh(const TriangleSoup& soup, const MeshOptions& options,
                                        const std::string& name);

}  // namespace thimble::host
