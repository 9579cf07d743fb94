// A clean surface from a triangle soup: welded, without degenerate or repeated faces. The first step of compile_mesh.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_tree.h"

namespace thimble::host {

// Positions are exactly the floats that the image will hold; everything is computed from them in double.
struct Surface {
  std::vector<Eigen::Vector3f> at_m;
  std::vector<TriangleIndices> triangles;
  double size_m = 0;                   // diagonal of the box
  std::vector<std::uint32_t> of_soup;  // vertex of the soup to vertex here; 0xFFFFFFFF: unused

  [[nodiscard]] Eigen::Vector3d point(std::uint32_t v) const { return at_m[v].cast<double>(); }

  // Twice the area, along the normal.
  [[nodiscard]] Eigen::Vector3d area_vector(std::size_t t) const {
    const Eigen::Vector3d a = point(triangles[t][0]);
    return (point(triangles[t][1]) - a).cross(point(triangles[t][2]) - a);
  }
};

// The edge after edge e of a triangle.
constexpr std::uint32_t next_edge(std::uint32_t e) { return e == 2 ? 0 : e + 1; }

// Vertices closer than this share of the diagonal of the mesh's box are one.
inline constexpr double kWeldTolerance = 1.0e-6;

// Welds, removes caps (three distinct vertices on a line) without opening holes, and cancels repeated faces.
// Counts what it drops in the report. Throws Error (kBadInput) for a soup that cannot be used; `name` stands
// in the messages.
[[nodiscard]] Surface clean_surface(const TriangleSoup& soup, const std::string& name, MeshReport& report,
                                    double weld_share = kWeldTolerance);

}  // namespace thimble::host
