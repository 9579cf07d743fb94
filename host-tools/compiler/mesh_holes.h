// The holes of an oriented surface: finds and closes them. A step of repair_mesh.
#pragma once

#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_repair.h"
#include "host-tools/compiler/mesh_surface.h"

namespace thimble::host {

// Appends the triangles that close the surface's holes, wound as the faces around them, and counts
// in the report what was closed, and what was left open and why.
void close_holes(Surface& surface, const Adjacency& adjacency, double max_hole_m, RepairReport& report);

}  // namespace thimble::host
