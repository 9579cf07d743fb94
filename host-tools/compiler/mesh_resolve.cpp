#include "host-tools/compiler/mesh_resolve.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>

#include "host-tools/compiler/disjoint_sets.h"
#include "host-tools/compiler/exact_points.h"
#include "host-tools/compiler/mesh_tree.h"
#include "host-tools/compiler/plane_graph.h"
#include "host-tools/compiler/portable_math.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Corners = std::array<std::uint32_t, 3>;

constexpr std::size_t kMaxSegments = 20'000;  // in one plane
constexpr double kMaxAngles = 3.0e9;          // solid angles of faces, seen from one face of each patch
constexpr double kUnclear = 0.05;  // a winding number farther from a whole one is asked from another face
constexpr std::size_t kViews = 8;

// One of the arrangement's faces.
struct Cell {
  Corners corners;
  int turns =
      0;  // how many faces of the parts lie here and look along its normal, less those that look against it
  std::uint32_t plane = 0;
};

int main_axis(const GridPoint& normal) {
  int axis = 0;
  normal.cwiseAbs().maxCoeff(&axis);
  return axis;
}

class Arrangement {
 public:
  explicit Arrangement(const Surface& surface, std::vector<TriangleIndices> triangles)
      : surface_(surface), triangles_(std::move(triangles)), planes_(triangles_.size()) {}

  Resolved resolve(std::vector<TriangleIndices>& result, std::vector<Eigen::Vector3f>& at_m) {
    if (!place_on_grid()) return Resolved::kFailed;
    find_meetings();
    if (!cut_faces()) return Resolved::kTooLarge;
    join_patches();
    if (!wind_patches()) return too_large_ ? Resolved::kTooLarge : Resolved::kFailed;
    return collect(result, at_m);
  }

 private:
  struct Face {
    std::array<GridPoint, 3> at;
    GridPlane plane;
    Corners corners{};
    std::vector<PlaneSegment> segments;
    std::vector<std::uint32_t> points;
  };

  bool place_on_grid();
  void find_meetings();
  void meet(std::uint32_t a, std::uint32_t b);
  void meet_in_plane(Face& a, std::uint32_t index_a, Face& b, std::uint32_t index_b);
  void hits(const Face& face, const std::array<int, 3>& sides, const Face& other,
            std::vector<std::uint32_t>& found);
  bool cut_faces();
  bool cut_plane(const std::vector<std::uint32_t>& members);
  void join_patches();
  bool wind_patches();
  std::optional<double> winding(const Cell& cell) const;
  Resolved collect(std::vector<TriangleIndices>& result, std::vector<Eigen::Vector3f>& at_m);

  const Surface& surface_;
  std::vector<TriangleIndices> triangles_;
  ExactPoints points_;
  std::vector<Face> faces_;
  DisjointSets planes_;  // of faces that overlap in one plane
  std::vector<Cell> cells_;
  std::vector<std::uint32_t> patch_of_;
  std::vector<double> inner_;             // of each patch: the winding number on the side where it is higher
  std::vector<std::uint32_t> vertex_of_;  // of each exact point: the surface's vertex
  std::vector<std::uint32_t> plane_of_;   // of each face
  double scale_ = 1;                      // grid steps a metre
  bool too_large_ = false;
  bool changed_ = false;
};

bool Arrangement::place_on_grid() {
  double largest = 0;
  for (const TriangleIndices& t : triangles_)
    for (const std::uint32_t v : t) largest = std::max(largest, surface_.point(v).cwiseAbs().maxCoeff());
  const double scale =
      std::ldexp(1.0, 29 - std::ilogb(largest) - 2);  // a power of two: no rounding of large coordinates
  faces_.reserve(triangles_.size());
  for (const TriangleIndices& t : triangles_) {
    Face& face = faces_.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector3d p = surface_.point(t[i]) * scale;
      face.at[i] = {std::llround(p.x()), std::llround(p.y()), std::llround(p.z())};
      face.corners[i] = points_.add(face.at[i]);
      if (face.corners[i] >= vertex_of_.size()) vertex_of_.resize(face.corners[i] + 1, kNoNeighbour);
      if (vertex_of_[face.corners[i]] == kNoNeighbour) vertex_of_[face.corners[i]] = t[i];
    }
    face.plane = plane_of(face.at[0], face.at[1], face.at[2]);
    if (face.plane.normal == GridPoint::Zero()) return false;
  }
  scale_ = scale;
  return true;
}

void Arrangement::find_meetings() {
  const MeshTree tree = build_tree(surface_.at_m, triangles_);
  for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
    Vector3d lo = surface_.point(triangles_[t][0]);
    Vector3d hi = lo;
    for (const std::uint32_t v : triangles_[t]) {
      lo = lo.cwiseMin(surface_.point(v));
      hi = hi.cwiseMax(surface_.point(v));
    }
    visit_box(tree.nodes, tree.grid_box(lo, hi), [&](std::uint32_t i) {
      const std::uint32_t other = tree.order[i];
      if (other > t) meet(t, other);
      return true;
    });
  }
}

// The places where the edges and corners of `face` lie in `other`. sides: of the corners, from the other's plane.
void Arrangement::hits(const Face& face, const std::array<int, 3>& sides, const Face& other,
                       std::vector<std::uint32_t>& found) {
  const auto volume_side = [](const GridPoint& a, const GridPoint& b, const GridPoint& c,
                              const GridPoint& d) { return plane_of(a, b, c).side(d); };
  const int axis = main_axis(other.plane.normal);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    std::array<int, 3> turns{};
    if (sides[i] == 0) {
      for (std::size_t k = 0; k < 3; ++k)
        turns[k] = points_.turn(axis, other.corners[k], other.corners[(k + 1) % 3], face.corners[i]);
    } else if (sides[i] * sides[j] < 0) {
      for (std::size_t k = 0; k < 3; ++k)
        turns[k] = volume_side(face.at[i], face.at[j], other.at[k], other.at[(k + 1) % 3]);
    } else {
      continue;
    }
    const auto [least, most] = std::minmax_element(turns.begin(), turns.end());
    if (*least < 0 && *most > 0) continue;
    found.push_back(sides[i] == 0 ? face.corners[i] : points_.add(face.at[i], face.at[j], other.plane));
  }
}

void Arrangement::meet_in_plane(Face& a, std::uint32_t index_a, Face& b, std::uint32_t index_b) {
  const int axis = main_axis(a.plane.normal);
  // An edge that has the whole of the other face on its outer side or on itself separates the two.
  const auto separated = [&](const Face& one, const Face& other) {
    const int winding = one.plane.normal[axis] > 0 ? 1 : -1;
    for (std::size_t i = 0; i < 3; ++i) {
      if (std::all_of(other.corners.begin(), other.corners.end(), [&](std::uint32_t p) {
            return winding * points_.turn(axis, one.corners[i], one.corners[(i + 1) % 3], p) <= 0;
          }))
        return true;
    }
    return false;
  };
  if (!separated(a, b) && !separated(b, a)) planes_.join(index_a, index_b);
  hits(a, {0, 0, 0}, b, b.points);
  hits(b, {0, 0, 0}, a, a.points);
}

void Arrangement::meet(std::uint32_t index_a, std::uint32_t index_b) {
  Face& a = faces_[index_a];
  Face& b = faces_[index_b];
  for (int axis = 0; axis < 3; ++axis) {
    const auto [lo_a, hi_a] = std::minmax({a.at[0][axis], a.at[1][axis], a.at[2][axis]});
    const auto [lo_b, hi_b] = std::minmax({b.at[0][axis], b.at[1][axis], b.at[2][axis]});
    if (lo_a > hi_b || lo_b > hi_a) return;
  }
  std::array<int, 3> sides_a{};
  std::array<int, 3> sides_b{};
  for (std::size_t i = 0; i < 3; ++i) {
    sides_a[i] = b.plane.side(a.at[i]);
    sides_b[i] = a.plane.side(b.at[i]);
  }
  const auto one_side = [](const std::array<int, 3>& s) { return s[0] != 0 && s[0] == s[1] && s[1] == s[2]; };
  if (one_side(sides_a) || one_side(sides_b)) return;
  if (sides_a == std::array<int, 3>{0, 0, 0}) {
    meet_in_plane(a, index_a, b, index_b);
    return;
  }
  const auto shared = std::count_if(a.corners.begin(), a.corners.end(), [&](std::uint32_t p) {
    return std::find(b.corners.begin(), b.corners.end(), p) != b.corners.end();
  });
  if (shared == 2) return;  // in two planes, they meet in this edge only
  std::vector<std::uint32_t> ends;
  hits(a, sides_a, b, ends);
  hits(b, sides_b, a, ends);
  std::sort(ends.begin(), ends.end());
  ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
  if (ends.empty()) return;
  if (ends.size() == 1) {
    a.points.push_back(ends[0]);
    b.points.push_back(ends[0]);
    return;
  }
  // On a line: two of them are its ends.
  int axis = 0;
  (points_.near(ends[1]) - points_.near(ends[0])).cwiseAbs().maxCoeff(&axis);
  std::sort(ends.begin(), ends.end(), [&](auto p, auto q) { return points_.compare(axis, p, q) < 0; });
  a.segments.push_back({ends.front(), ends.back(), b.plane});
  b.segments.push_back({ends.front(), ends.back(), a.plane});
}

bool Arrangement::cut_faces() {
  std::vector<std::vector<std::uint32_t>> members(faces_.size());
  for (std::uint32_t f = 0; f < faces_.size(); ++f) members[planes_.find(f)].push_back(f);
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (members[f].empty()) continue;
    const Face& face = faces_[f];
    const auto own = [&face](std::uint32_t p) {
      return std::find(face.corners.begin(), face.corners.end(), p) != face.corners.end();
    };
    const bool whole = members[f].size() == 1 && std::all_of(face.points.begin(), face.points.end(), own) &&
                       std::all_of(face.segments.begin(), face.segments.end(),
                                   [&](const PlaneSegment& s) { return own(s.a) && own(s.b); });
    if (whole) {
      cells_.push_back({face.corners, 1, f});
    } else if (!cut_plane(members[f])) {
      return false;
    }
  }
  return true;
}

bool Arrangement::cut_plane(const std::vector<std::uint32_t>& members) {
  changed_ = true;
  const Face& first = faces_[members[0]];
  const int axis = main_axis(first.plane.normal);
  PlaneGraph graph(points_, first.plane, axis);
  std::size_t segments = 3 * members.size();
  for (const std::uint32_t f : members) {
    const Face& face = faces_[f];
    segments += face.segments.size();
    for (std::size_t i = 0; i < 3; ++i) {
      const GridPoint& from = face.at[i];
      const GridPoint& to = face.at[(i + 1) % 3];
      const GridPoint across = (to - from).cross(GridPoint(GridPoint::Unit(axis)));
      graph.add_segment({face.corners[i], face.corners[(i + 1) % 3], {across, from}});
    }
  }
  if (segments > kMaxSegments) return false;
  for (const std::uint32_t f : members) {
    for (const PlaneSegment& s : faces_[f].segments) graph.add_segment(s);
    for (const std::uint32_t p : faces_[f].points) graph.add_point(p);
  }
  if (!graph.triangulate()) return false;
  std::vector<int> turns(graph.triangles().size());
  std::vector<char> covered(turns.size());
  for (std::size_t m = 0; m < members.size(); ++m) {
    const std::vector<char> inside = graph.enclosed_by(3 * m, 3);
    const int sign = faces_[members[m]].plane.normal[axis] > 0 ? 1 : -1;
    for (std::size_t t = 0; t < turns.size(); ++t) {
      turns[t] += inside[t] != 0 ? sign : 0;
      covered[t] = static_cast<char>(covered[t] | inside[t]);
    }
  }
  for (std::size_t t = 0; t < turns.size(); ++t) {
    if (covered[t] != 0 && turns[t] != 0) cells_.push_back({graph.triangles()[t], turns[t], members[0]});
  }
  return true;
}

// Cells that meet at an edge where no other one does have the same space on either side.
void Arrangement::join_patches() {
  std::vector<std::pair<std::uint64_t, std::uint32_t>> edges;
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(cells_[c].corners[i], cells_[c].corners[(i + 1) % 3]);
      edges.emplace_back((static_cast<std::uint64_t>(low) << 32U) | high, c);
    }
  }
  std::sort(edges.begin(), edges.end());
  DisjointSets patches(cells_.size());
  for (std::size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    while (end < edges.size() && edges[end].first == edges[begin].first) ++end;
    if (end - begin == 2) patches.join(edges[begin].second, edges[begin + 1].second);
  }
  patch_of_.resize(cells_.size());
  for (std::uint32_t c = 0; c < cells_.size(); ++c) patch_of_[c] = patches.find(c);
}

// How often the parts wind round what is on the cell's inner side, seen from its middle. None: not near a whole number, as
// where the cell is smaller than rounding.
std::optional<double> Arrangement::winding(const Cell& cell) const {
  const Vector3d middle =
      (points_.near(cell.corners[0]) + points_.near(cell.corners[1]) + points_.near(cell.corners[2])) / 3.0;
  double sum = 0;
  for (std::uint32_t f = 0; f < faces_.size(); ++f) {
    if (plane_of_[f] == cell.plane) continue;  // seen edge-on
    const Vector3d a = faces_[f].at[0].cast<double>() - middle;
    const Vector3d b = faces_[f].at[1].cast<double>() - middle;
    const Vector3d c = faces_[f].at[2].cast<double>() - middle;
    const double la = a.norm();
    const double lb = b.norm();
    const double lc = c.norm();
    sum += portable::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  const double mean = sum / (2.0 * std::numbers::pi);
  const double higher = mean + 0.5 * std::abs(cell.turns);
  if (std::abs(higher - std::round(higher)) > kUnclear) return std::nullopt;
  return std::round(higher);
}

bool Arrangement::wind_patches() {
  plane_of_.resize(faces_.size());
  for (std::uint32_t f = 0; f < faces_.size(); ++f) plane_of_[f] = planes_.find(f);
  std::map<std::uint32_t, std::vector<std::uint32_t>> patches;
  for (std::uint32_t c = 0; c < cells_.size(); ++c) patches[patch_of_[c]].push_back(c);
  if (static_cast<double>(patches.size()) * static_cast<double>(faces_.size()) > kMaxAngles) {
    too_large_ = true;
    return false;
  }
  const auto area = [this](std::uint32_t c) {
    const Corners& t = cells_[c].corners;
    return (points_.near(t[1]) - points_.near(t[0]))
        .cross(points_.near(t[2]) - points_.near(t[0]))
        .squaredNorm();
  };
  inner_.assign(cells_.size(), 0.0);
  for (auto& [patch, members] : patches) {
    std::sort(members.begin(), members.end(), [&](auto a, auto b) {
      const double x = area(a);
      const double y = area(b);
      return x != y ? x > y : a < b;
    });
    std::optional<double> inner;
    for (std::size_t i = 0; i < std::min(members.size(), kViews) && !inner; ++i)
      inner = winding(cells_[members[i]]);
    // A patch too thin to be seen: as if outside, and the check of what is kept tells whether that fits.
    inner_[patch] = inner.value_or(0.0);
  }
  return true;
}

Resolved Arrangement::collect(std::vector<TriangleIndices>& result, std::vector<Eigen::Vector3f>& at_m) {
  std::vector<TriangleIndices> kept;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> balance;
  for (std::uint32_t c = 0; c < cells_.size(); ++c) {
    const Cell& cell = cells_[c];
    const double inner = inner_[patch_of_[c]];
    if (inner < 1.0 || inner - std::abs(cell.turns) >= 1.0) {
      changed_ = true;
      continue;
    }
    Corners t = cell.corners;
    if (cell.turns < 0) std::swap(t[1], t[2]);
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t from = t[i];
      const std::uint32_t to = t[(i + 1) % 3];
      balance[std::minmax(from, to)] += from < to ? 1 : -1;
    }
    kept.push_back(t);
  }
  if (!changed_) return Resolved::kNothingToDo;
  if (kept.empty() ||
      std::any_of(balance.begin(), balance.end(), [](const auto& e) { return e.second != 0; }))
    return Resolved::kFailed;
  vertex_of_.resize(points_.size(), kNoNeighbour);
  for (const Corners& t : kept) {
    TriangleIndices& out = result.emplace_back();
    for (std::size_t i = 0; i < 3; ++i) {
      std::uint32_t& vertex = vertex_of_[t[i]];
      if (vertex == kNoNeighbour) {
        vertex = static_cast<std::uint32_t>(at_m.size());
        at_m.push_back((points_.near(t[i]) / scale_).cast<float>());
      }
      out[i] = vertex;
    }
  }
  return Resolved::kYes;
}

}  // namespace

Resolved resolve_crossings(Surface& surface, const Adjacency& adjacency) {
  std::vector<TriangleIndices> closed;
  std::vector<TriangleIndices> result;
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    (adjacency.open[t] != 0 ? result : closed).push_back(surface.triangles[t]);
  if (closed.empty()) return Resolved::kNothingToDo;
  std::vector<Eigen::Vector3f> at_m = surface.at_m;
  const Resolved resolved = Arrangement(surface, std::move(closed)).resolve(result, at_m);
  if (resolved == Resolved::kYes) {
    surface.triangles = std::move(result);
    surface.at_m = std::move(at_m);
  }
  return resolved;
}

}  // namespace thimble::host
