// Repairs a triangle soup and says what it did: welds, drops faces without area, cancels fins, orients, closes holes up
// to a stated size, and resolves closed parts that cross to their outer surface. Called by `thimble mesh`.
#pragma once

#include <array>
#include <cstddef>
#include <string>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_resolve.h"

namespace thimble::host {

inline constexpr std::size_t kMaxHoleEdges = 256;  // the triangulation takes the third power of it

struct RepairOptions {
  double max_hole_m = 0;  // diagonal of the box of a hole that is closed; 0: none is closed
  bool resolve = true;    // closed parts that cross
};

struct RepairReport {
  MeshReport before;  // as the compiler takes the input
  MeshReport after;   // as the compiler takes the output
  std::size_t reversed_triangles = 0;
  std::size_t holes_closed = 0;
  std::size_t hole_triangles = 0;  // added for them
  std::size_t holes_too_large = 0;
  std::size_t holes_too_long = 0;  // of more than kMaxHoleEdges edges
  std::size_t outlines = 0;        // of sheets: closing one would only add the reverse of the sheet
  std::size_t holes_folded = 0;    // no triangulation that is free of faces and edges which are there already
  Resolved resolved = Resolved::kNothingToDo;
};

struct RepairedMesh {
  TriangleSoup soup;  // its vertices are floats, each used; a repair of it changes nothing
  RepairReport report;
};

// Deterministic. Throws Error (kBadInput) as compile_mesh; `name` is used in messages.
[[nodiscard]] RepairedMesh repair_mesh(const TriangleSoup& soup, const RepairOptions& options,
                                       const std::string& name);

}  // namespace thimble::host
