// Polygons into triangles. Used by the mesh readers.
#pragma once

#include <cstdint>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

inline constexpr std::size_t kMaxPolygonPoints = 4096;

// Appends the triangles of a polygon over soup.vertices_m, wound as it is. Concave polygons are cut along
// their ears; a polygon without an ear (it crosses itself) becomes a fan. Fewer than three points: nothing. At most
// kMaxPolygonPoints.
void append_polygon(std::vector<std::uint32_t> polygon, TriangleSoup& soup);

}  // namespace thimble::host
