// Whether a point is in the solid that a closed mesh encloses, or outside of the free space that it encloses.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "control/solids/mesh.h"
#include "control/solids/mesh_topology.h"

namespace thimble::control {

using namespace topology;  // NOLINT(google-build-using-namespace): this file is about nothing else

namespace {

constexpr int kMaxRayNodes = 1024;  // of one ray

// A ray along an axis of the mesh, to the nearer or the farther end of its grid. u, v and the axis are right-handed.
struct Ray {
  Vec3 from;
  std::size_t axis, u, v;
  bool up;
  std::array<std::uint32_t, 3> lo, hi;  // in the mesh's grid
};

// False: `from` is outside of the mesh's grid.
bool prepare(const MeshView& mesh, const Vec3& from, std::size_t axis, bool farther, Ray& ray) {
  constexpr std::uint32_t kGridEnd = 65535;
  constexpr float kMargin = 2.0F;  // rounding, in grid steps
  const Vec3 at = (from - mesh.grid_origin_m) * mesh.grid_scale;
  if (!(at.minCoeff() >= -kMargin && at.maxCoeff() <= static_cast<float>(kGridEnd) + kMargin)) return false;
  ray = {from, axis, (axis + 1) % 3, (axis + 2) % 3, false, {}, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const float here = at[static_cast<Eigen::Index>(i)];
    ray.lo[i] = static_cast<std::uint32_t>(std::max(here - kMargin, 0.0F));
    ray.hi[i] = std::min(static_cast<std::uint32_t>(here + kMargin), kGridEnd);
  }
  ray.up = (2 * ray.lo[axis] > kGridEnd) != farther;
  (ray.up ? ray.hi : ray.lo)[axis] = ray.up ? kGridEnd : 0;
  return true;
}

struct Crossing {
  float distance_m;
  bool leaves;  // through the back of a face
};

struct Crossings {
  int count = 0;
  int winding = 0;
  Crossing first{std::numeric_limits<float>::infinity(), false};
  Crossing last{-1.0F, false};

  void add(const Crossing& crossing) {
    ++count;
    winding += crossing.leaves ? 1 : -1;
    if (crossing.distance_m < first.distance_m) first = crossing;
    if (crossing.distance_m > last.distance_m) last = crossing;
  }
  // A mesh that encloses free space (side "inside") has it in front of its faces, and the solid beyond: there the ray
  // comes into the free space first, and leaves it at the end. Two crossings at one place, at a sharp edge, do not count:
  // rounding can exchange them.
  [[nodiscard]] bool inside() const {
    constexpr float kApart_m = 1.0e-5F;
    if (winding != 0) return winding > 0;
    return first.leaves && !last.leaves && last.distance_m - first.distance_m > kApart_m;
  }
};

// How often the triangle's projection along the ray goes round it: 1, -1, or 0. Both faces at an edge get the same
// value of that edge with opposite signs, so that a ray through an edge or a vertex crosses one of its faces.
int turns(const std::array<Vec3, 3>& corner, const Ray& ray) {
  const auto u = static_cast<Eigen::Index>(ray.u);
  const auto v = static_cast<Eigen::Index>(ray.v);
  int count = 0;
  for (std::uint32_t edge = 0; edge < 3; ++edge) {
    const Vec3& p = corner[edge];
    const Vec3& q = corner[next(edge)];
    if ((p[v] > 0.0F) == (q[v] > 0.0F)) continue;
    const float side = p[u] * q[v] - p[v] * q[u];
    if (q[v] > 0.0F) {
      if (side > 0.0F) ++count;
    } else if (side < 0.0F) {
      --count;
    }
  }
  return count;
}

void cross_triangle(const MeshView& mesh, std::uint32_t triangle, const Ray& ray, Crossings& crossings) {
  if (two_sided(mesh, triangle)) return;
  const std::array<Vec3, 3> corner = {vertex(mesh, triangle, 0) - ray.from,
                                      vertex(mesh, triangle, 1) - ray.from,
                                      vertex(mesh, triangle, 2) - ray.from};
  const int turn = turns(corner, ray);
  if (turn == 0) return;
  const Vec3 normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
  const bool leaves = (turn > 0) == ray.up;
  const float ahead = leaves ? normal.dot(corner[0]) : -normal.dot(corner[0]);
  if (ahead <= 0.0F) return;
  const float slope = std::abs(normal[static_cast<Eigen::Index>(ray.axis)]);
  crossings.add({ahead / std::max(slope, std::numeric_limits<float>::min()), leaves});
}

bool overlaps(const Ray& ray, const GridPoint& lo, const GridPoint& hi) {
  for (std::uint16_t axis = 0; axis < 3; ++axis) {
    if (lo[axis] > ray.hi[axis] || hi[axis] < ray.lo[axis]) return false;
  }
  return true;
}

// False: kMaxRayNodes was reached, or the work is spent.
bool walk(const MeshView& mesh, const Ray& ray, Crossings& crossings, Work& work) {
  std::array<std::uint32_t, kMaxBvhDepth + 1> stack;
  std::size_t depth = 0;
  std::uint32_t at = 0;
  for (int visits = 0; visits < kMaxRayNodes && work.spend(kNodeWork); ++visits) {
    const scene::BvhNode& node = mesh.nodes[at];
    std::array<std::uint32_t, 2> inner;
    std::size_t count = 0;
    for (std::uint16_t c = 0; c < 2; ++c) {
      const std::uint32_t child = (*node.child())[c];
      if (c == 1 && child == (*node.child())[0]) continue;  // a node with one child repeats it
      if (!(c == 0 ? overlaps(ray, *node.lo_a(), *node.hi_a()) : overlaps(ray, *node.lo_b(), *node.hi_b())))
        continue;
      if (!is_leaf(child)) {
        inner[count++] = child;
        continue;
      }
      const std::uint32_t first = first_triangle(child);
      if (!work.spend(kTriangleWork * triangle_count(child))) return false;
      for (std::uint32_t i = first; i < first + triangle_count(child); ++i)
        cross_triangle(mesh, i, ray, crossings);
    }
    if (count == 0) {
      if (depth == 0) return true;
      at = stack[--depth];
    } else {
      at = inner[0];
      if (count == 2) {
        if (depth == stack.size()) return false;
        stack[depth++] = inner[1];
      }
    }
  }
  return false;
}

}  // namespace

// The sum over the faces that a ray crosses tells, as for a closed surface that may cross itself. A point counts as inside where two rays
// say so, or the only one that tells: a solid that is not felt by mistake is worse than one that is. More rays are for one that is cut
// short, or that meets nothing: it can pass beside a mesh that encloses free space. Beyond such a mesh all rays have to say so, because
// faces turned inside out give some rays the same order of crossings.
Containment mesh_contains(const ShapeData& shape, const Vec3& point, Work& work) {
  bool known = false;
  bool inside = false;
  int winds_round = 0;  // rays
  for (const bool farther : {false, true}) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      Ray ray;
      if (!prepare(shape.mesh, point, axis, farther, ray)) return Containment::kOutside;
      Crossings crossings;
      if (!walk(shape.mesh, ray, crossings, work)) continue;
      known = true;
      if (crossings.count == 0) continue;
      if (!crossings.inside()) return Containment::kOutside;
      inside = true;
      if (crossings.winding > 0 && ++winds_round == 2) return Containment::kInside;
    }
  }
  if (inside) return Containment::kInside;
  return known ? Containment::kOutside : Containment::kUnknown;
}

}  // namespace thimble::control
