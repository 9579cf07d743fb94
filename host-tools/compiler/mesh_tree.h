// The bounding volume hierarchy over a mesh's triangles, in the layout of the scene image (control/scene/scene.fbs), and
// the traversal that the compiler itself needs. Called by compile_mesh.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/mesh_leaf.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

using TriangleIndices = std::array<std::uint32_t, 3>;

// A box in steps of the tree's grid.
struct GridBox {
  std::array<std::uint16_t, 3> lo{0xFFFF, 0xFFFF, 0xFFFF};
  std::array<std::uint16_t, 3> hi{0, 0, 0};

  void enclose(const GridBox& other) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = std::min(lo[axis], other.lo[axis]);
      hi[axis] = std::max(hi[axis], other.hi[axis]);
    }
  }
};

struct MeshTree {
  Eigen::Vector3f grid_origin_m;
  float grid_step_m = 0;
  std::vector<scene::BvhNode> nodes;
  std::vector<std::uint32_t> order;  // leaf order: the tree's triangle i is the caller's triangle order[i]
  unsigned depth = 0;

  // The grid box of lo..hi, rounded outwards and grown by one step, so that a walk in single precision misses
  // nothing.
  [[nodiscard]] GridBox grid_box(const Eigen::Vector3d& lo, const Eigen::Vector3d& hi) const;
};

// Deterministic: the split is chosen by integer surface areas, ties by balance and axis. At least one
// triangle.
[[nodiscard]] MeshTree build_tree(const std::vector<Eigen::Vector3f>& vertices_m,
                                  const std::vector<TriangleIndices>& triangles);

// Calls visit(triangle) for each triangle of each leaf whose box meets(lo, hi), until visit returns false.
template <typename Meets, typename Visit>
void visit_where(const std::vector<scene::BvhNode>& nodes, Meets&& meets, Visit&& visit) {
  std::array<std::uint32_t, control::kMaxBvhDepth + 2> stack;  // each level leaves at most one child behind
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::uint32_t reference = stack[--size];
    if (control::is_leaf(reference)) {
      const std::uint32_t first = control::first_triangle(reference);
      for (std::uint32_t i = 0; i < control::triangle_count(reference); ++i) {
        if (!visit(first + i)) {
          return;
        }
      }
      continue;
    }
    const scene::BvhNode& node = nodes[reference];
    const std::uint32_t a = node.child()->Get(0);
    const std::uint32_t b = node.child()->Get(1);
    if (b != a && meets(*node.lo_b(), *node.hi_b())) {
      stack[size++] = b;
    }
    if (meets(*node.lo_a(), *node.hi_a())) {
      stack[size++] = a;
    }
  }
}

// The same for the leaves whose boxes meet `box`.
template <typename Visit>
void visit_box(const std::vector<scene::BvhNode>& nodes, const GridBox& box, Visit&& visit) {
  const auto meets = [&box](const auto& lo, const auto& hi) {
    bool overlap = true;
    for (std::uint16_t axis = 0; axis < 3; ++axis) {
      overlap = overlap && lo.Get(axis) <= box.hi[axis] && hi.Get(axis) >= box.lo[axis];
    }
    return overlap;
  };
  visit_where(nodes, meets, std::forward<Visit>(visit));
}

}  // namespace thimble::host
