#include "host-tools/compiler/mesh_holes.h"

#include <algorithm>
#include <limits>
#include <set>
#include <unordered_set>

namespace thimble::host {
namespace {

using Eigen::Vector3d;

// A lid of this share of its part's area is the part itself from the other side: the part is a sheet.
constexpr double kSheetShare = 0.9;
constexpr double kNoLid = std::numeric_limits<double>::infinity();

using Loop = std::vector<std::uint32_t>;

struct Hole {
  Loop vertices;  // against the direction of the faces around it: as the lid runs
  std::uint32_t triangle = 0;
};

std::uint64_t hole_edge(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
}

// Cuts a loop where it returns to a vertex: holes that touch at a vertex are a figure of eight.
void append_simple_loops(const Loop& loop, std::uint32_t triangle, std::vector<Hole>& holes) {
  Loop path;
  for (const std::uint32_t v : loop) {
    const auto again = std::find(path.begin(), path.end(), v);
    if (again != path.end()) {
      holes.push_back({Loop(again, path.end()), triangle});
      path.erase(again, path.end());
    }
    path.push_back(v);
  }
  holes.push_back({std::move(path), triangle});
}

// The open edges, chained around each fan of faces.
std::vector<Hole> find_holes(const Surface& surface, const Adjacency& adjacency) {
  std::vector<Hole> holes;
  std::vector<bool> seen(adjacency.neighbour.size());
  for (std::uint32_t start = 0; start < seen.size(); ++start) {
    if (adjacency.neighbour[start] != kNoNeighbour || seen[start]) continue;
    Hole hole;
    hole.triangle = start / 3;
    for (std::uint32_t edge = start; !seen[edge];) {
      seen[edge] = true;
      hole.vertices.push_back(surface.triangles[edge / 3][edge % 3]);
      std::uint32_t next = 3 * (edge / 3) + next_edge(edge % 3);
      while (adjacency.neighbour[next] != kNoNeighbour) {
        const std::uint32_t code = adjacency.neighbour[next];
        next = 3 * (code >> 2U) + next_edge(code & 3U);
      }
      edge = next;
    }
    std::reverse(hole.vertices.begin(), hole.vertices.end());
    append_simple_loops(hole.vertices, hole.triangle, holes);
  }
  return holes;
}

double box_diagonal(const Surface& surface, const Loop& loop) {
  Vector3d lo = surface.point(loop[0]);
  Vector3d hi = lo;
  for (const std::uint32_t v : loop) {
    lo = lo.cwiseMin(surface.point(v));
    hi = hi.cwiseMax(surface.point(v));
  }
  return (hi - lo).norm();
}

// The area of the part that each triangle belongs to.
std::vector<double> part_areas(const Surface& surface, const Adjacency& adjacency) {
  std::vector<double> areas(surface.triangles.size(), -1.0);
  std::vector<std::uint32_t> members;
  for (std::uint32_t seed = 0; seed < areas.size(); ++seed) {
    if (areas[seed] >= 0) continue;
    members.assign(1, seed);
    areas[seed] = 0;
    double sum = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
      const std::uint32_t t = members[i];
      sum += surface.area_vector(t).norm() / 2.0;
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t code = adjacency.neighbour[std::size_t{3} * t + e];
        if (code != kNoNeighbour && areas[code >> 2U] < 0) {
          areas[code >> 2U] = 0;
          members.push_back(code >> 2U);
        }
      }
    }
    for (const std::uint32_t t : members) areas[t] = sum;
  }
  return areas;
}

struct Lid {
  std::vector<TriangleIndices> triangles;
  double area = kNoLid;
};

// The triangulation of least area (Barequet and Sharir 1995): best[i][k] closes the corners i..k.
// A diagonal that is an edge of the surface already would get a third face; it is not taken.
Lid least_area_lid(const Surface& surface, const Loop& loop, const std::unordered_set<std::uint64_t>& edges) {
  const std::size_t n = loop.size();
  std::vector<double> best(n * n, 0.0);
  std::vector<std::size_t> middle(n * n, 0);
  for (std::size_t span = 2; span < n; ++span) {
    for (std::size_t i = 0; i + span < n; ++i) {
      const std::size_t k = i + span;
      best[i * n + k] = kNoLid;
      const bool diagonal = span + 1 < n;
      if (loop[i] == loop[k] || (diagonal && edges.contains(hole_edge(loop[i], loop[k])))) continue;
      const Vector3d a = surface.point(loop[i]);
      const Vector3d side = surface.point(loop[k]) - a;
      for (std::size_t m = i + 1; m < k; ++m) {
        if (loop[m] == loop[i] || loop[m] == loop[k]) continue;
        const double area = side.cross(surface.point(loop[m]) - a).norm() / 2.0;
        const double sum = best[i * n + m] + best[m * n + k] + area;
        if (sum < best[i * n + k]) {
          best[i * n + k] = sum;
          middle[i * n + k] = m;
        }
      }
    }
  }
  Lid lid;
  lid.area = n < 3 ? kNoLid : best[n - 1];
  std::vector<std::pair<std::size_t, std::size_t>> open;
  if (lid.area < kNoLid) open.emplace_back(0, n - 1);
  while (!open.empty()) {
    const auto [i, k] = open.back();
    open.pop_back();
    if (k - i < 2) continue;
    const std::size_t m = middle[i * n + k];
    lid.triangles.push_back({loop[i], loop[m], loop[k]});
    open.emplace_back(i, m);
    open.emplace_back(m, k);
  }
  return lid;
}

}  // namespace

void close_holes(Surface& surface, const Adjacency& adjacency, double max_hole_m, RepairReport& report) {
  const std::vector<Hole> holes = find_holes(surface, adjacency);
  if (holes.empty()) return;
  const std::vector<double> areas = part_areas(surface, adjacency);
  std::unordered_set<std::uint64_t> edges;  // only looked up, never walked
  std::set<TriangleIndices> faces;
  const auto sorted = [](TriangleIndices t) {
    std::sort(t.begin(), t.end());
    return t;
  };
  const auto enter = [&](const TriangleIndices& t) {
    faces.insert(sorted(t));
    for (std::uint32_t e = 0; e < 3; ++e) edges.insert(hole_edge(t[e], t[next_edge(e)]));
  };
  for (const TriangleIndices& t : surface.triangles) enter(t);
  for (const Hole& hole : holes) {
    if (box_diagonal(surface, hole.vertices) > max_hole_m) {
      ++report.holes_too_large;
      continue;
    }
    if (hole.vertices.size() > kMaxHoleEdges) {
      ++report.holes_too_long;
      continue;
    }
    const Lid lid = least_area_lid(surface, hole.vertices, edges);
    const bool repeats = std::any_of(lid.triangles.begin(), lid.triangles.end(),
                                     [&](const TriangleIndices& t) { return faces.contains(sorted(t)); });
    if (repeats || (lid.area < kNoLid && lid.area >= kSheetShare * areas[hole.triangle])) {
      ++report.outlines;
      continue;
    }
    if (lid.triangles.empty()) {
      ++report.holes_folded;
      continue;
    }
    for (const TriangleIndices& t : lid.triangles) {
      surface.triangles.push_back(t);
      enter(t);
    }
    ++report.holes_closed;
    report.hole_triangles += lid.triangles.size();
  }
}

}  // namespace thimble::host
