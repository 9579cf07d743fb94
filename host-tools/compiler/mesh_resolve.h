// Resolves faces of closed parts that cross, touch or coincide to the outer surface of the parts: the boundary of where
// they wind around at least once. A step of repair_mesh.
#pragma once

#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

enum class Resolved {
  kNothingToDo,  // no closed part meets itself or another one
  kYes,
  kTooLarge,  // more work than the bounds allow
  kFailed,    // what came out was not closed
};

// Replaces the surface's closed parts; open ones remain as they are. Vertices that remain keep their places. Exact but for
// the rounding of new vertices to float. Unless the result is kYes, the surface is not changed.
[[nodiscard]] Resolved resolve_crossings(Surface& surface, const Adjacency& adjacency);

}  // namespace thimble::host
