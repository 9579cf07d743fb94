// Reads a mesh file into a triangle soup: .plg by our own reader, everything else (OBJ, STL, PLY, OFF, glTF
// ...) by assimp.
#pragma once

#include <filesystem>
#include <string>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

// All meshes of the file, each under its node's transform, polygons cut into triangles, points and lines
// dropped. Lengths are multiplied by scale_m. `name` stands in messages. Throws Error (kBadInput): missing or
// unreadable file, no face, a coordinate that is not finite.
[[nodiscard]] TriangleSoup read_mesh_file(const std::filesystem::path& file, double scale_m,
                                          const std::string& name);

}  // namespace thimble::host
