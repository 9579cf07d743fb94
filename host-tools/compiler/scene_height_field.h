// The scene file's "height_field": a grid of heights as a closed block that is shaded on top (paper, section
// 3.7: "interpolating height and surface normal between points in this matrix of heights").
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <string_view>

#include "host-tools/compiler/height_grid.h"
#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/scene_value.h"

namespace thimble::host {

struct HeightFieldShape {
  std::string file;  // relative to the scene file
  Eigen::Vector2d size_m;
  double height_m;     // of the value 1
  double thickness_m;  // from the lowest point to the flat bottom
  double crease_deg;
  std::string place;  // "file:line: /pointer" for messages
};

[[nodiscard]] HeightFieldShape read_height_field(const Value& value);

// The block: its first and last points on the edges of size_m, centred on the origin, z = height_m times the
// value; each cell of the top is two triangles whose diagonals alternate from cell to cell, so that the faces
// round a point lie in balance and their mean normal is right to second order. `name` stands in messages.
// Throws Error (kBadInput) for heights out of reach.
[[nodiscard]] TriangleSoup height_field_soup(const HeightFieldShape& shape, const HeightGrid& grid,
                                             const std::string& name);

}  // namespace thimble::host
