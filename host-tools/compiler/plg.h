// Reader of .plg, the polygon files of REND386, VR386 and AVRIL (Bernie Roehl, 1992-94), in which the paper's
// asteroid came.
#pragma once

#include <string>
#include <string_view>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

// The file's units, mirrored (z changes sign) from the format's left-handed frame to a right-handed one,
// which keeps faces counter-clockwise as seen. All objects of the file together; of the levels of detail of a
// #MULTI file the finest one. Facets of one or two points are dropped. `name` stands in messages. Throws
// Error (kBadInput) with the line.
[[nodiscard]] TriangleSoup read_plg(std::string_view text, const std::string& name);

}  // namespace thimble::host
