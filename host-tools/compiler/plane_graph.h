// The constrained triangulation of points and segments in a plane, in exact arithmetic. Used by resolve_crossings for the
// faces of one plane.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "host-tools/compiler/exact_points.h"

namespace thimble::host {

struct PlaneSegment {
  std::uint32_t a = 0;
  std::uint32_t b = 0;
  GridPlane line;  // another plane through the segment
};

class PlaneGraph {
 public:
  // `axis`: the plane is seen against it, and is not parallel to it.
  PlaneGraph(ExactPoints& points, const GridPlane& plane, int axis);

  void add_point(std::uint32_t point) { corners_.push_back(point); }
  void add_segment(const PlaneSegment& segment) { segments_.push_back(segment); }

  // False: the bounds of a loop were met.
  [[nodiscard]] bool triangulate();

  // After triangulate(): counter-clockwise seen against the axis, over the whole plane around the points.
  [[nodiscard]] const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangles_; }
  // For each of them, whether the loop of segments first..first + count - 1 encloses it.
  [[nodiscard]] std::vector<char> enclosed_by(std::size_t first, std::size_t count) const;

 private:
  using Edge = std::uint64_t;  // from the upper half to the lower half
  static Edge edge(std::uint32_t from, std::uint32_t to) { return (Edge{from} << 32U) | to; }

  void find_crossings();
  void split_segments();
  void place_frame();
  [[nodiscard]] bool insert(std::uint32_t p);
  void legalise(std::vector<Edge>& suspects);
  [[nodiscard]] bool constrain(std::uint32_t a, std::uint32_t b);
  [[nodiscard]] bool edges_across(std::uint32_t a, std::uint32_t b, std::vector<Edge>& across) const;
  [[nodiscard]] bool can_flip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const;
  void flip(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d);
  [[nodiscard]] bool in_circle(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) const;
  [[nodiscard]] int turn(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return points_.turn(axis_, a, b, c);
  }
  void link(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void unlink(std::uint32_t a, std::uint32_t b, std::uint32_t c);

  ExactPoints& points_;
  GridPlane plane_;
  int axis_;
  std::vector<std::uint32_t> corners_;
  std::vector<PlaneSegment> segments_;
  std::vector<std::vector<std::uint32_t>> chains_;  // of each segment: its points in order
  std::array<std::uint32_t, 3> frame_{};            // a triangle around everything
  std::unordered_map<Edge, std::uint32_t> apex_;    // the third corner of the triangle left of an edge
  std::unordered_map<std::uint32_t, std::uint32_t> spoke_;  // of each corner: the end of some edge from it
  std::array<std::uint32_t, 3> last_{};                     // a triangle near the last insertion
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

}  // namespace thimble::host
