#include "host-tools/compiler/mesh_pieces.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "control/scene/limits.h"
#include "control/scene/mesh_triangle.h"
#include "host-tools/compiler/convex_hull.h"

namespace thimble::host {
namespace {

using Eigen::Vector3d;
using Polygon = std::vector<Vector3d>;

// The part of a polygon where sign * p[axis] <= sign * at.
Polygon cut(const Polygon& polygon, int axis, double at, double sign) {
  Polygon out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector3d& p = polygon[i];
    const Vector3d& q = polygon[(i + 1) % polygon.size()];
    const double a = sign * (p[axis] - at);
    const double b = sign * (q[axis] - at);
    if (a <= 0) out.push_back(p);
    if ((a < 0 && b > 0) || (a > 0 && b < 0)) out.emplace_back(p + a / (a - b) * (q - p));
  }
  return out;
}

// The flux of (x - from, 0, 0) through a polygon.
double flux(const Polygon& polygon, double from) {
  double sum = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i) {
    const double area_x = (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]).x() / 2;
    sum += area_x * ((polygon[0].x() + polygon[i - 1].x() + polygon[i].x()) / 3 - from);
  }
  return sum;
}

// The volume of the solid within a box: along each line in x, the length of the solid between the box's ends.
double volume_within(const std::vector<Polygon>& surface, const Eigen::AlignedBox3d& box) {
  double volume = 0;
  for (const Polygon& face : surface) {
    Polygon column = face;
    for (const int axis : {1, 2})
      column = cut(cut(column, axis, box.max()[axis], 1), axis, box.min()[axis], -1);
    Polygon beyond = cut(column, 0, box.max().x(), -1);
    for (Vector3d& p : beyond) p.x() = box.max().x();  // the flux of (max - min) through what is there
    volume += flux(cut(cut(column, 0, box.max().x(), 1), 0, box.min().x(), -1), box.min().x()) +
              flux(beyond, box.min().x());
  }
  return volume;
}

struct Part {
  Eigen::AlignedBox3d box;
  std::vector<Polygon> surface;
  Hull hull;
  double volume = 0;

  [[nodiscard]] double excess() const { return hull.volume_m3 - volume; }
};

std::vector<Vector3d> points_of(const std::vector<Polygon>& surface) {
  std::vector<Vector3d> points;
  for (const Polygon& polygon : surface) points.insert(points.end(), polygon.begin(), polygon.end());
  return points;
}

std::vector<Polygon> cut_all(const std::vector<Polygon>& surface, int axis, double at, double sign) {
  std::vector<Polygon> out;
  for (const Polygon& polygon : surface) {
    Polygon left = cut(polygon, axis, at, sign);
    if (left.size() >= 3) out.push_back(std::move(left));
  }
  return out;
}

// The hulls of what lies on each side of kSlabs - 1 planes across an axis, from the hulls of the slabs between them.
constexpr int kSlabs = 12;
struct Cut {
  int axis = -1;
  double at = 0;
  double cost = std::numeric_limits<double>::infinity();
};

void try_cuts(const Part& part, int axis, Cut& best) {
  const double lo = part.box.min()[axis];
  const double step = part.box.sizes()[axis] / kSlabs;
  if (!(step > 0)) return;
  std::array<std::vector<Vector3d>, kSlabs> slabs;
  std::vector<Polygon> rest = part.surface;
  for (int i = 0; i < kSlabs; ++i) {
    const double at = lo + (i + 1) * step;
    const std::vector<Polygon> slab = i + 1 < kSlabs ? cut_all(rest, axis, at, 1) : rest;
    if (i + 1 < kSlabs) rest = cut_all(rest, axis, at, -1);
    std::vector<Vector3d> points = points_of(slab);
    Hull hull = hull_of(points);
    slabs.at(static_cast<std::size_t>(i)) = hull.corners.empty() ? points : hull.corners;
  }
  std::array<double, kSlabs> below{};
  std::array<double, kSlabs> above{};
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i + 1 < kSlabs; ++i) {
    points.insert(points.end(), slabs.at(i).begin(), slabs.at(i).end());
    Hull hull = hull_of(points);
    below.at(i) = hull.volume_m3;
    if (!hull.corners.empty()) points = std::move(hull.corners);
  }
  points.clear();
  for (std::size_t i = kSlabs - 1; i > 0; --i) {
    points.insert(points.end(), slabs.at(i).begin(), slabs.at(i).end());
    Hull hull = hull_of(points);
    above.at(i - 1) = hull.volume_m3;
    if (!hull.corners.empty()) points = std::move(hull.corners);
  }
  for (std::size_t i = 0; i + 1 < kSlabs; ++i) {
    // A little for the balance, so that of cuts that gain nothing yet the middle one is taken.
    constexpr double kBalance = .02;
    const double off = std::abs(2.0 * static_cast<double>(i + 1) / kSlabs - 1);
    const double size = part.box.sizes()[axis] / part.box.sizes().maxCoeff();
    const double cost = below.at(i) + above.at(i) + kBalance * part.hull.volume_m3 * (off + 1 - size);
    if (cost < best.cost) best = {axis, lo + static_cast<double>(i + 1) * step, cost};
  }
}

Part part_of(std::vector<Polygon> surface, const std::vector<Polygon>& whole,
             const Eigen::AlignedBox3d& within) {
  Part part;
  part.surface = std::move(surface);
  std::vector<Vector3d> points = points_of(part.surface);
  for (const Vector3d& p : points) part.box.extend(p);
  if (!points.empty()) part.hull = hull_of(points);
  part.box = part.box.isEmpty() ? part.box : part.box.intersection(within);
  part.volume = part.hull.corners.empty() ? 0 : volume_within(whole, part.box);
  return part;
}

// At most `most` corners of a hull, those whose hull leaves the least out; returns how far out the rest reaches.
double thin_out(std::vector<Vector3d>& corners, std::size_t most) {
  std::vector<Vector3d> kept;
  const auto keep = [&](const Vector3d& p) {
    if (std::find(kept.begin(), kept.end(), p) == kept.end()) kept.push_back(p);
  };
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        if (kept.size() >= most || (x == 0 && y == 0 && z == 0)) continue;
        const Vector3d direction(x, y, z);
        keep(*std::max_element(corners.begin(), corners.end(), [&](const Vector3d& a, const Vector3d& b) {
          return direction.dot(a) < direction.dot(b);
        }));
      }
  for (;;) {
    const Hull hull = hull_of(kept);
    double farthest = 0;
    const Vector3d* next = nullptr;
    for (const Vector3d& p : corners) {
      double out = hull.faces.empty() ? 1.0 / static_cast<double>(kept.size()) : 0;
      for (const HullFace& face : hull.faces) out = std::max(out, face.normal.dot(p) - face.offset_m);
      if (hull.faces.empty() && std::find(kept.begin(), kept.end(), p) != kept.end()) continue;
      if (out <= farthest) continue;
      farthest = out;
      next = &p;
    }
    constexpr double kSame_m = 1e-6;
    if (next == nullptr || farthest < kSame_m || kept.size() >= most) {
      corners = kept;
      return next == nullptr ? 0 : farthest;
    }
    kept.push_back(*next);
  }
}

}  // namespace

MeshPieces convex_pieces(const CompiledMesh& mesh) {
  std::vector<Polygon> whole;
  for (const scene::Triangle& triangle : mesh.triangles) {
    Polygon corners;
    for (std::uint32_t i = 0; i < 3; ++i) {
      const scene::Vec3& p = mesh.vertices[control::vertex_of(triangle, i)].position_m();
      corners.push_back(Eigen::Vector3f(p.x(), p.y(), p.z()).cast<double>());
    }
    whole.push_back(std::move(corners));
  }
  constexpr double kEverywhere = std::numeric_limits<double>::infinity();
  const Eigen::AlignedBox3d everywhere(Vector3d::Constant(-kEverywhere), Vector3d::Constant(kEverywhere));
  MeshPieces pieces;
  std::vector<Part> parts{part_of(whole, whole, everywhere)};
  const double volume = parts.front().volume;
  if (parts.front().hull.corners.empty() || !(volume > 0)) return pieces;
  constexpr double kEnough = .005;  // of the volume
  while (parts.size() < control::kMaxPieces) {
    const auto worst = std::max_element(parts.begin(), parts.end(),
                                        [](const Part& a, const Part& b) { return a.excess() < b.excess(); });
    if (worst->excess() < kEnough * volume) break;
    Cut best;
    for (const int axis : {0, 1, 2}) try_cuts(*worst, axis, best);
    if (best.axis < 0) break;
    Eigen::AlignedBox3d below = worst->box;
    Eigen::AlignedBox3d above = worst->box;
    below.max()[best.axis] = above.min()[best.axis] = best.at;
    Part first = part_of(cut_all(worst->surface, best.axis, best.at, 1), whole, below);
    Part second = part_of(cut_all(worst->surface, best.axis, best.at, -1), whole, above);
    *worst = std::move(first);
    parts.push_back(std::move(second));
  }
  constexpr std::size_t kCorners = 256;
  constexpr std::size_t kLeast = 24;
  const std::size_t most = std::clamp(kCorners / parts.size(), kLeast, control::kMaxPieceCorners);
  double together = 0;
  for (Part& part : parts) {
    constexpr double kNothing = 1e-6;  // of the volume: a sliver
    if (part.hull.volume_m3 < kNothing * volume) continue;
    together += part.hull.volume_m3;
    pieces.left_out_m = std::max(pieces.left_out_m, thin_out(part.hull.corners, most));
    pieces.corners_m.push_back(std::move(part.hull.corners));
  }
  pieces.excess = together / volume - 1;
  return pieces;
}

}  // namespace thimble::host
