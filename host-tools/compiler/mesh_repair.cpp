#include "host-tools/compiler/mesh_repair.h"

#include <algorithm>

#include "host-tools/compiler/mesh_holes.h"
#include "host-tools/compiler/mesh_orient.h"
#include "host-tools/compiler/mesh_surface.h"
#include "host-tools/compiler/mesh_tree.h"

namespace thimble::host {
namespace {

// Where faces cross at narrow angles, new vertices lie closer together than a face must be high.
constexpr double kResolvedWeld = 1.0e-5;
constexpr std::uint32_t kUnused = 0xFFFFFFFFU;

struct Oriented {
  Surface surface;  // in the tree's order
  Adjacency adjacency;
  std::vector<std::uint32_t> order;  // its triangle i was triangle order[i]
};

Oriented orient_surface(const Surface& given, MeshReport& report) {
  Oriented result{given, {}, {}};
  const MeshTree tree = build_tree(given.at_m, given.triangles);
  for (std::size_t i = 0; i < given.triangles.size(); ++i)
    result.surface.triangles[i] = given.triangles[tree.order[i]];
  result.adjacency = orient(result.surface, tree, false, report);
  result.order = tree.order;
  return result;
}

// The winding that the compiler would use, for the triangles in the order of the input. A turned
// triangle has its vertices 0 and 2 exchanged.
std::size_t wind(Surface& surface) {
  MeshReport ignored;
  const Oriented oriented = orient_surface(surface, ignored);
  std::size_t reversed = 0;
  for (std::size_t i = 0; i < oriented.order.size(); ++i) {
    TriangleIndices& t = surface.triangles[oriented.order[i]];
    reversed += t != oriented.surface.triangles[i] ? 1U : 0U;
    t = oriented.surface.triangles[i];
  }
  return reversed;
}

MeshReport compiled(const TriangleSoup& soup, const std::string& name) {
  return compile_mesh(soup, {}, name).report;
}

TriangleSoup to_soup(const Surface& surface) {
  TriangleSoup soup;
  std::vector<std::uint32_t> index(surface.at_m.size(), kUnused);
  for (const TriangleIndices& t : surface.triangles) {
    TriangleIndices& out = soup.triangles.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      if (index[t[i]] == kUnused) {
        index[t[i]] = static_cast<std::uint32_t>(soup.vertices_m.size());
        soup.vertices_m.push_back(surface.point(t[i]));
      }
      out[i] = index[t[i]];
    }
  }
  return soup;
}

// Rounding to float can make faces of the result touch: then vertices that are near each other are one, and it is resolved
// again. Keeps the best, which is never worse than what was given.
void resolve(TriangleSoup& soup, const std::string& name, RepairReport& report) {
  constexpr int kRounds = 4;
  double weld_share = kResolvedWeld;
  TriangleSoup next = soup;
  for (int round = 0; round < kRounds; ++round, weld_share *= 2.0) {
    MeshReport ignored;
    Surface surface = clean_surface(next, name, ignored);
    wind(surface);
    Oriented oriented = orient_surface(surface, ignored);
    const Resolved resolved = resolve_crossings(oriented.surface, oriented.adjacency);
    if (round == 0) report.resolved = resolved;
    if (report.resolved != Resolved::kYes) return;
    surface = clean_surface(to_soup(oriented.surface), name, ignored, weld_share);
    wind(surface);
    next = to_soup(surface);
    const MeshReport after = compiled(next, name);
    const bool worse = after.pierced_triangles > report.after.pierced_triangles ||
                       after.open_edges > report.after.open_edges;
    if (worse && round == 0) report.resolved = Resolved::kFailed;
    if (worse) return;
    soup = next;
    report.after = after;
    if (after.pierced_triangles == 0) return;
  }
}

}  // namespace

RepairedMesh repair_mesh(const TriangleSoup& soup, const RepairOptions& options, const std::string& name) {
  RepairedMesh result;
  RepairReport& report = result.report;
  report.before = compiled(soup, name);
  MeshReport cleaning;
  Surface surface = clean_surface(soup, name, cleaning);
  report.reversed_triangles = wind(surface);
  MeshReport ignored;
  Oriented oriented = orient_surface(surface, ignored);
  const std::size_t before = surface.triangles.size();
  close_holes(oriented.surface, oriented.adjacency, options.max_hole_m, report);
  surface.triangles.insert(surface.triangles.end(),
                           oriented.surface.triangles.begin() + static_cast<std::ptrdiff_t>(before),
                           oriented.surface.triangles.end());
  if (report.holes_closed != 0) wind(surface);  // a part that is closed now is wound outwards
  result.soup = to_soup(surface);
  report.after = compiled(result.soup, name);
  if (options.resolve) resolve(result.soup, name, report);
  return result;
}

}  // namespace thimble::host
