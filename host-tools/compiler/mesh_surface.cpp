#include "host-tools/compiler/mesh_surface.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <limits>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;

// Lengths relative to the diagonal of the mesh's box, so that nothing depends on the file's unit.
constexpr double kCapTolerance =
    4.0e-6;  // a triangle lower than this over its longest edge is a cap: no area, no normal
constexpr double kFloatTolerance =
    5.0e-7;  // relative to the largest coordinate: about eight steps of a float
constexpr double kMinSize_m = 1.0e-4;
constexpr std::uint32_t kNone = 0xFFFFFFFFU;

Error bad_mesh(const std::string& slug, const std::string& cause, const std::string& remedy) {
  return Error(ExitCode::kBadInput, slug, cause, remedy);
}

std::string six_digits(double value) {
  std::array<char, 32> text{};
  const int size = std::snprintf(text.data(), text.size(), "%.6g", value);
  return {text.data(), static_cast<std::size_t>(size)};
}

std::uint64_t edge_key(std::uint32_t a, std::uint32_t b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32U) | std::max(a, b);
}

void check_soup(const TriangleSoup& soup, const std::string& name) {
  if (soup.triangles.empty()) {
    throw bad_mesh("empty-mesh", name + ": the mesh has no triangle", "give a mesh with at least one face");
  }
  if (soup.triangles.size() > control::kMaxTriangles) {
    throw bad_mesh("too-many-triangles",
                   name + ": " + std::to_string(soup.triangles.size()) + " triangles, at most " +
                       std::to_string(control::kMaxTriangles) + " are allowed",
                   "simplify the mesh");
  }
  for (const TriangleIndices& triangle : soup.triangles) {
    for (const std::uint32_t v : triangle) {
      if (v >= soup.vertices_m.size()) {
        throw bad_mesh("bad-vertex-index",
                       name + ": a face names vertex " + std::to_string(v) + ", but there are " +
                           std::to_string(soup.vertices_m.size()) + " vertices",
                       "repair the mesh file");
      }
      const Vector3d& p = soup.vertices_m[v];
      if (!p.allFinite()) {
        throw bad_mesh("bad-vertex", name + ": vertex " + std::to_string(v) + " is not a finite number",
                       "repair the mesh file");
      }
      if (p.cwiseAbs().maxCoeff() > static_cast<double>(control::kMaxCoordinate_m)) {
        throw bad_mesh("mesh-too-large",
                       name + ": vertex " + std::to_string(v) + " lies at (" + six_digits(p.x()) + ", " +
                           six_digits(p.y()) + ", " + six_digits(p.z()) + ") m, at most " +
                           six_digits(static_cast<double>(control::kMaxCoordinate_m)) +
                           " m from the object's origin are allowed",
                       "set the mesh's \"scale\" (metres per file unit; 0.001 for a file in mm)");
      }
    }
  }
}

struct CellHash {
  std::size_t operator()(const std::array<std::int64_t, 3>& c) const {
    std::uint64_t h = 0;
    for (const std::int64_t x : c) {
      h = (h ^ static_cast<std::uint64_t>(x)) * 0x9E3779B97F4A7C15ULL;
      h ^= h >> 29U;
    }
    return static_cast<std::size_t>(h);
  }
};

// Merges vertices within the tolerance into the first of them, and drops triangles that lose a corner by it.
Surface weld(const TriangleSoup& soup, const std::string& name, double weld_share, MeshReport& report) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vector3d lo = Vector3d::Constant(kInfinity);
  Vector3d hi = Vector3d::Constant(-kInfinity);
  std::vector<char> used(soup.vertices_m.size());
  for (const TriangleIndices& triangle : soup.triangles) {
    for (const std::uint32_t v : triangle) {
      used[v] = 1;
      const Vector3d p = soup.vertices_m[v].cast<float>().cast<double>();
      lo = lo.cwiseMin(p);
      hi = hi.cwiseMax(p);
    }
  }
  report.unused_vertices = static_cast<std::size_t>(std::count(used.begin(), used.end(), 0));
  Surface surface;
  surface.size_m = (hi - lo).norm();
  if (surface.size_m < kMinSize_m) {
    throw bad_mesh("mesh-too-small",
                   name + ": the mesh is " + six_digits(surface.size_m) + " m across, at least " +
                       six_digits(kMinSize_m) + " m are needed",
                   "set the mesh's \"scale\" (metres per file unit)");
  }
  const double tolerance =
      std::max(weld_share * surface.size_m,
               kFloatTolerance * std::max(lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff()));

  // Cells twice the tolerance wide: what is near a point lies in the eight cells around it.
  const double cell = 2.0 * tolerance;
  std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t, CellHash>
      head;  // only looked up, never walked
  std::vector<std::uint32_t> next_in_cell;
  head.reserve(soup.vertices_m.size());
  std::vector<std::uint32_t> merged(soup.vertices_m.size(), kNone);
  for (std::size_t v = 0; v < soup.vertices_m.size(); ++v) {
    if (used[v] == 0) {
      continue;
    }
    const Eigen::Vector3f rounded = soup.vertices_m[v].cast<float>();
    const Vector3d p = rounded.cast<double>();
    std::array<std::array<std::int64_t, 2>, 3> range;
    std::array<std::int64_t, 3> home;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double x = (p[static_cast<Eigen::Index>(axis)] - lo[static_cast<Eigen::Index>(axis)]) / cell;
      home[axis] = static_cast<std::int64_t>(std::floor(x));
      range[axis] = {static_cast<std::int64_t>(std::floor(x - 0.5)),
                     static_cast<std::int64_t>(std::floor(x + 0.5))};
    }
    std::uint32_t found = kNone;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const auto entry =
          head.find({range[0][corner & 1U], range[1][(corner >> 1U) & 1U], range[2][corner >> 2U]});
      for (std::uint32_t i = entry == head.end() ? kNone : entry->second; i != kNone; i = next_in_cell[i]) {
        if (i < found && (surface.point(i) - p).squaredNorm() <= tolerance * tolerance) {
          found = i;
        }
      }
    }
    if (found == kNone) {
      found = static_cast<std::uint32_t>(surface.at_m.size());
      surface.at_m.push_back(rounded);
      const auto [entry, inserted] = head.try_emplace(home, found);
      next_in_cell.push_back(inserted ? kNone : entry->second);
      entry->second = found;
    }
    merged[v] = found;
  }
  for (const TriangleIndices& t : soup.triangles) {
    const TriangleIndices welded{merged[t[0]], merged[t[1]], merged[t[2]]};
    if (welded[0] != welded[1] && welded[1] != welded[2] && welded[2] != welded[0]) {
      surface.triangles.push_back(welded);
    }
  }
  surface.of_soup = std::move(merged);
  return surface;
}

// The longest edge of a cap: three distinct vertices that lie on a line. kNone when the triangle has an area.
std::uint32_t cap_edge(const Surface& surface, const TriangleIndices& t) {
  std::uint32_t longest = 0;
  double length2 = 0;
  for (std::uint32_t e = 0; e < 3; ++e) {
    const double l2 = (surface.at_m[t[next_edge(e)]] - surface.at_m[t[e]]).cast<double>().squaredNorm();
    if (l2 > length2) {
      length2 = l2;
      longest = e;
    }
  }
  const Vector3d a = surface.point(t[0]);
  const double height = (surface.point(t[1]) - a).cross(surface.point(t[2]) - a).norm() / std::sqrt(length2);
  return height <= kCapTolerance * surface.size_m ? longest : kNone;
}

// Removes caps. Each face on the other side of a cap's long edge is split at the cap's middle vertex, so that
// the edges stay shared and no hole opens. The long edges shrink with every split, so this ends; the budget
// bounds it anyway.
void remove_caps(Surface& surface) {
  std::vector<TriangleIndices>& triangles = surface.triangles;
  std::deque<std::uint32_t> caps;
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (cap_edge(surface, triangles[t]) != kNone) {
      caps.push_back(t);
    }
  }
  if (caps.empty()) {
    return;
  }
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> faces_at;  // only looked up, never walked
  const auto enter = [&](std::uint32_t t) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      faces_at[edge_key(triangles[t][e], triangles[t][next_edge(e)])].push_back(t);
    }
  };
  std::vector<char> alive(triangles.size(), 1);
  const auto leave = [&](std::uint32_t t) {
    alive[t] = 0;
    for (std::uint32_t e = 0; e < 3; ++e) {
      std::erase(faces_at[edge_key(triangles[t][e], triangles[t][next_edge(e)])], t);
    }
  };
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    enter(t);
  }
  std::size_t budget = 8 * caps.size() + triangles.size();
  while (!caps.empty()) {
    const std::uint32_t cap = caps.front();
    caps.pop_front();
    if (alive[cap] == 0) {
      continue;
    }
    const std::uint32_t e = cap_edge(surface, triangles[cap]);
    const std::uint32_t from = triangles[cap][e];
    const std::uint32_t to = triangles[cap][next_edge(e)];
    const std::uint32_t middle = triangles[cap][next_edge(next_edge(e))];
    leave(cap);
    const std::vector<std::uint32_t> others = faces_at[edge_key(from, to)];
    for (const std::uint32_t other : others) {
      const TriangleIndices face = triangles[other];
      if (std::find(face.begin(), face.end(), middle) != face.end()) {
        leave(other);  // the same three vertices: another cap
        continue;
      }
      if (budget == 0) {
        break;
      }
      --budget;
      leave(other);
      for (const std::uint32_t replaced : {from, to}) {
        TriangleIndices half = face;
        std::replace(half.begin(), half.end(), replaced, middle);
        const auto added = static_cast<std::uint32_t>(triangles.size());
        triangles.push_back(half);
        alive.push_back(1);
        enter(added);
        if (cap_edge(surface, half) != kNone) {
          caps.push_back(added);
        }
      }
    }
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (alive[t] != 0) {
      triangles[kept++] = triangles[t];
    }
  }
  triangles.resize(kept);
}

// Clears `alive` of the fins that are attached to faces which are closed without them.
void cancel_fins(const std::vector<TriangleIndices>& triangles, const std::vector<std::uint32_t>& fins,
                 std::vector<char>& alive, MeshReport& report) {
  struct Edge {
    std::uint32_t faces = 0;          // that are no fins
    std::vector<std::uint32_t> fins;  // as indices into `fins`
  };
  std::unordered_map<std::uint64_t, Edge> edges;  // only looked up, never walked
  const auto each_edge = [&](std::uint32_t t, auto&& visit) {
    for (std::uint32_t e = 0; e < 3; ++e) {
      visit(edge_key(triangles[t][e], triangles[t][next_edge(e)]));
    }
  };
  for (std::uint32_t i = 0; i < fins.size(); ++i) {
    each_edge(fins[i], [&](std::uint64_t key) { edges[key].fins.push_back(i); });
    alive[fins[i]] = 0;
  }
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    if (alive[t] != 0) {
      each_edge(t, [&](std::uint64_t key) {
        if (const auto edge = edges.find(key); edge != edges.end()) ++edge->second.faces;
      });
    }
  }
  std::vector<char> seen(fins.size());
  std::vector<std::uint32_t> group;
  for (std::uint32_t seed = 0; seed < fins.size(); ++seed) {
    if (seen[seed] != 0) {
      continue;
    }
    seen[seed] = 1;
    group.assign(1, seed);
    bool attached = false;
    bool closed = true;
    for (std::size_t i = 0; i < group.size(); ++i) {
      each_edge(fins[group[i]], [&](std::uint64_t key) {
        const Edge& edge = edges[key];
        attached = attached || edge.faces != 0;
        closed = closed && edge.faces % 2 == 0;
        for (const std::uint32_t other : edge.fins) {
          if (seen[other] == 0) {
            seen[other] = 1;
            group.push_back(other);
          }
        }
      });
    }
    if (attached && closed) {
      report.fins_cancelled += group.size();
    } else {
      for (const std::uint32_t i : group) {
        alive[fins[i]] = 1;
      }
    }
  }
}

// Faces with the same three vertices, one after another, as indices.
std::vector<std::vector<std::uint32_t>> repeated_faces(const std::vector<TriangleIndices>& triangles) {
  std::vector<TriangleIndices> sorted = triangles;
  for (TriangleIndices& t : sorted) {
    std::sort(t.begin(), t.end());
  }
  std::vector<std::uint32_t> order(triangles.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return sorted[a] != sorted[b] ? sorted[a] < sorted[b] : a < b;
  });
  std::vector<std::vector<std::uint32_t>> groups;
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    while (end < order.size() && sorted[order[end]] == sorted[order[begin]]) {
      ++end;
    }
    if (end - begin > 1) {
      groups.emplace_back(order.begin() + static_cast<std::ptrdiff_t>(begin),
                          order.begin() + static_cast<std::ptrdiff_t>(end));
    }
  }
  return groups;
}

// Whether two faces with the same vertices wind the same way.
bool wind_alike(const TriangleIndices& a, const TriangleIndices& b) {
  const auto at = std::find(b.begin(), b.end(), a[0]);
  return b[next_edge(static_cast<std::uint32_t>(at - b.begin()))] == a[1];
}

// Of faces with the same three vertices one remains, wound as most of them. Where as many wind one way as the other they are
// a fin, which encloses nothing: fins that hang together are cancelled if what they are attached to is closed there without
// them. Others remain as one layer: a sheet that its file draws from both sides.
void cancel_repeated_faces(Surface& surface, MeshReport& report) {
  std::vector<TriangleIndices>& triangles = surface.triangles;
  std::vector<char> alive(triangles.size(), 1);
  std::vector<std::uint32_t> fins;  // the first face of each
  for (const std::vector<std::uint32_t>& group : repeated_faces(triangles)) {
    std::ptrdiff_t sum = 0;
    for (const std::uint32_t t : group) {
      sum += wind_alike(triangles[group[0]], triangles[t]) ? 1 : -1;
      alive[t] = t == group[0] ? 1 : 0;
    }
    if (sum < 0) {
      std::swap(triangles[group[0]][1], triangles[group[0]][2]);
    } else if (sum == 0) {
      fins.push_back(group[0]);
    }
  }
  if (!fins.empty()) {
    cancel_fins(triangles, fins, alive, report);
  }
  std::size_t kept = 0;
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (alive[t] != 0) {
      triangles[kept++] = triangles[t];
    }
  }
  triangles.resize(kept);
}

}  // namespace

Surface clean_surface(const TriangleSoup& soup, const std::string& name, MeshReport& report,
                      double weld_share) {
  check_soup(soup, name);
  report.input_triangles = soup.triangles.size();
  Surface surface = weld(soup, name, weld_share, report);
  for (const TriangleIndices& t : surface.triangles) {
    report.degenerate_dropped += cap_edge(surface, t) != kNone ? 1U : 0U;
  }
  report.degenerate_dropped += soup.triangles.size() - surface.triangles.size();
  remove_caps(surface);
  cancel_repeated_faces(surface, report);
  if (surface.triangles.empty()) {
    throw bad_mesh(
        "empty-mesh",
        name + ": none of the mesh's " + std::to_string(soup.triangles.size()) + " triangles has an area",
        "repair the mesh file, or check its \"scale\"");
  }
  if (surface.triangles.size() > control::kMaxTriangles) {
    throw bad_mesh("too-many-triangles",
                   name + ": " + std::to_string(surface.triangles.size()) +
                       " triangles after repair, at most " + std::to_string(control::kMaxTriangles) +
                       " are allowed",
                   "simplify the mesh");
  }
  return surface;
}

}  // namespace thimble::host
