#include "host-tools/compiler/mesh_tree.h"

#include <bit>
#include <cmath>
#include <limits>
#include <numeric>

namespace thimble::host {
namespace {

// Leaves of up to four triangles: about 0.35 nodes a triangle, which keeps mesh and tree within 64 bytes a
// triangle.
constexpr std::size_t kLeafTriangles = 4;
static_assert(kLeafTriangles <= control::kMaxLeafTriangles);

// The grid leaves a margin of more than two steps on each side. It begins at an odd fraction of a step so
// that the round numbers of a modelled mesh do not lie on grid lines, where the last bit of a coordinate
// would decide.
constexpr double kGridSteps = 65530.0;
constexpr double kGridMargin = 2.381966;

std::int64_t half_area(const GridBox& box) {
  const std::int64_t x = box.hi[0] - box.lo[0];
  const std::int64_t y = box.hi[1] - box.lo[1];
  const std::int64_t z = box.hi[2] - box.lo[2];
  return x * y + y * z + z * x;
}

// Levels of nodes that halving needs above its leaves.
unsigned levels_by_halving(std::size_t count) {
  const std::size_t leaves = (count + kLeafTriangles - 1) / kLeafTriangles;
  return static_cast<unsigned>(std::bit_width(leaves - 1));
}

class Builder {
 public:
  Builder(const std::vector<GridBox>& boxes, MeshTree& tree)
      : boxes_(boxes),
        tree_(tree),
        in_left_(boxes.size()),
        scratch_(boxes.size()),
        right_area_(boxes.size()) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lists_[axis].resize(boxes.size());
      std::iota(lists_[axis].begin(), lists_[axis].end(), 0U);
      std::sort(lists_[axis].begin(), lists_[axis].end(), [&](std::uint32_t a, std::uint32_t b) {
        const int centre_a = boxes[a].lo[axis] + boxes[a].hi[axis];
        const int centre_b = boxes[b].lo[axis] + boxes[b].hi[axis];
        return centre_a != centre_b ? centre_a < centre_b : a < b;
      });
    }
  }

  void build() {
    tree_.nodes.reserve(boxes_.size() / 2 + 1);
    tree_.order.reserve(boxes_.size());
    const std::uint32_t root = child(0, boxes_.size(), 1);
    if (control::is_leaf(root)) {
      const GridBox box = bounds(0, boxes_.size());
      tree_.nodes.push_back(make_node(box, box, root, root));
      tree_.depth = 1;
    }
  }

 private:
  struct Split {
    std::size_t axis = 0;
    std::size_t left = 0;  // triangles in the left child
  };

  static scene::BvhNode make_node(const GridBox& a, const GridBox& b, std::uint32_t child_a,
                                  std::uint32_t child_b) {
    using Corner = flatbuffers::span<const std::uint16_t, 3>;
    const std::array<std::uint32_t, 2> children{child_a, child_b};
    return scene::BvhNode(Corner(a.lo), Corner(a.hi), Corner(b.lo), Corner(b.hi),
                          flatbuffers::span<const std::uint32_t, 2>(children));
  }

  GridBox bounds(std::size_t begin, std::size_t end) const {
    GridBox box;
    for (std::size_t i = begin; i < end; ++i) {
      box.enclose(boxes_[lists_[0][i]]);
    }
    return box;
  }

  // The split of least area-weighted count over all three axes; among equals the most balanced one.
  Split best_split(std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    Split best;
    std::int64_t best_cost = std::numeric_limits<std::int64_t>::max();
    std::size_t best_imbalance = count;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<std::uint32_t>& list = lists_[axis];
      GridBox box;
      for (std::size_t i = count - 1; i > 0; --i) {
        box.enclose(boxes_[list[begin + i]]);
        right_area_[i] = half_area(box);
      }
      box = GridBox();
      for (std::size_t left = 1; left < count; ++left) {
        box.enclose(boxes_[list[begin + left - 1]]);
        const std::int64_t cost = half_area(box) * static_cast<std::int64_t>(left) +
                                  right_area_[left] * static_cast<std::int64_t>(count - left);
        const std::size_t imbalance = left > count - left ? 2 * left - count : count - 2 * left;
        if (cost < best_cost || (cost == best_cost && imbalance < best_imbalance)) {
          best_cost = cost;
          best_imbalance = imbalance;
          best = {axis, left};
        }
      }
    }
    return best;
  }

  // Moves the split's left triangles to the front of all three lists, keeping their order.
  void partition(std::size_t begin, std::size_t end, const Split& split) {
    for (std::size_t i = begin; i < end; ++i) {
      in_left_[lists_[split.axis][i]] = i - begin < split.left ? 1 : 0;
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (axis == split.axis) {
        continue;
      }
      std::vector<std::uint32_t>& list = lists_[axis];
      std::size_t left = begin;
      std::size_t right = 0;
      for (std::size_t i = begin; i < end; ++i) {
        if (in_left_[list[i]] != 0) {
          list[left++] = list[i];
        } else {
          scratch_[right++] = list[i];
        }
      }
      std::copy_n(scratch_.begin(), right, list.begin() + static_cast<std::ptrdiff_t>(left));
    }
  }

  // Builds the subtree over begin..end whose node, if it has one, is at `depth`; returns the reference to it.
  std::uint32_t child(std::size_t begin, std::size_t end,
                      unsigned depth) {  // NOLINT(misc-no-recursion): kMaxBvhDepth
    const std::size_t count = end - begin;
    if (count <= kLeafTriangles) {
      const auto first = static_cast<std::uint32_t>(tree_.order.size());
      for (std::size_t i = begin; i < end; ++i) {
        tree_.order.push_back(lists_[0][i]);
      }
      return control::leaf_of(first, static_cast<std::uint32_t>(count));
    }
    Split split = best_split(begin, end);
    const std::size_t larger = std::max(split.left, count - split.left);
    if (levels_by_halving(larger) > control::kMaxBvhDepth - depth) {
      split.left = count / 2;
    }
    partition(begin, end, split);
    const std::size_t middle = begin + split.left;
    const GridBox box_a = bounds(begin, middle);
    const GridBox box_b = bounds(middle, end);

    const std::size_t node = tree_.nodes.size();
    tree_.nodes.emplace_back();
    tree_.depth = std::max(tree_.depth, depth);
    const std::uint32_t a = child(begin, middle, depth + 1);
    const std::uint32_t b = child(middle, end, depth + 1);
    tree_.nodes[node] = make_node(box_a, box_b, a, b);
    return static_cast<std::uint32_t>(node);
  }

  const std::vector<GridBox>& boxes_;
  MeshTree& tree_;
  std::array<std::vector<std::uint32_t>, 3>
      lists_;  // the triangles of each subtree in a row, sorted along each axis
  std::vector<std::uint8_t> in_left_;
  std::vector<std::uint32_t> scratch_;
  std::vector<std::int64_t> right_area_;
};

}  // namespace

GridBox MeshTree::grid_box(const Eigen::Vector3d& lo, const Eigen::Vector3d& hi) const {
  GridBox box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    const double origin = static_cast<double>(grid_origin_m[i]);
    const double step = static_cast<double>(grid_step_m);
    const double from = std::floor((lo[i] - origin) / step) - 1.0;
    const double to = std::ceil((hi[i] - origin) / step) + 1.0;
    box.lo[axis] = static_cast<std::uint16_t>(std::clamp(from, 0.0, 65535.0));
    box.hi[axis] = static_cast<std::uint16_t>(std::clamp(to, 0.0, 65535.0));
  }
  return box;
}

MeshTree build_tree(const std::vector<Eigen::Vector3f>& vertices_m,
                    const std::vector<TriangleIndices>& triangles) {
  Eigen::Vector3f lo = vertices_m[triangles[0][0]];
  Eigen::Vector3f hi = lo;
  for (const TriangleIndices& triangle : triangles) {
    for (const std::uint32_t v : triangle) {
      lo = lo.cwiseMin(vertices_m[v]);
      hi = hi.cwiseMax(vertices_m[v]);
    }
  }
  MeshTree tree;
  const double extent = (hi.cast<double>() - lo.cast<double>()).maxCoeff();
  // The step may not sink below the coordinates' own resolution, or the origin could not be rounded to a
  // float.
  const double resolution =
      1.0e-7 * static_cast<double>(std::max(lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff()));
  tree.grid_step_m = static_cast<float>(std::max(extent / kGridSteps, resolution));
  const double furthest =
      -static_cast<double>(control::kMaxCoordinate_m);  // what the controller takes for an origin
  const double margin = kGridMargin * static_cast<double>(tree.grid_step_m);
  tree.grid_origin_m = (lo.cast<double>().array() - margin).max(furthest).cast<float>();

  std::vector<GridBox> boxes(triangles.size());
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    const Eigen::Vector3d a = vertices_m[triangles[i][0]].cast<double>();
    const Eigen::Vector3d b = vertices_m[triangles[i][1]].cast<double>();
    const Eigen::Vector3d c = vertices_m[triangles[i][2]].cast<double>();
    boxes[i] = tree.grid_box(a.cwiseMin(b).cwiseMin(c), a.cwiseMax(b).cwiseMax(c));
  }
  Builder(boxes, tree).build();
  return tree;
}

}  // namespace thimble::host
