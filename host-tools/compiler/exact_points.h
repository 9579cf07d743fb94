// Points of a mesh's arrangement in exact arithmetic: vertices on a grid, and places where edges and planes meet. Used by
// resolve_crossings. Equal points have equal indices, whatever they were computed from.
#pragma once

#include <Eigen/Core>
#include <array>
#include <boost/multiprecision/cpp_int.hpp>
#include <cstdint>
#include <unordered_map>
#include <vector>

namespace thimble::host {

// In steps of the grid. Coordinates of vertices are below kGridHalf, so that every product below fits.
using GridPoint = Eigen::Matrix<std::int64_t, 3, 1>;
inline constexpr std::int64_t kGridHalf = std::int64_t{1} << 29;

struct GridPlane {
  GridPoint normal;  // components below 2^61
  GridPoint through;

  // On which side of the plane p lies: 1 on that of the normal, 0 on the plane.
  [[nodiscard]] int side(const GridPoint& p) const;
};
[[nodiscard]] GridPlane plane_of(const GridPoint& a, const GridPoint& b, const GridPoint& c);

class ExactPoints {
 public:
  std::uint32_t add(const GridPoint& p);
  // Where the edge p-q meets the plane. The ends lie on different sides.
  std::uint32_t add(const GridPoint& p, const GridPoint& q, const GridPlane& plane);
  // Where three planes meet. They meet in one point.
  std::uint32_t add(const GridPlane& a, const GridPlane& b, const GridPlane& c);

  // Seen against `axis`: 1 when a, b, c run counter-clockwise, 0 when they are on a line.
  [[nodiscard]] int turn(int axis, std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  // The sign of a's coordinate minus b's.
  [[nodiscard]] int compare(int axis, std::uint32_t a, std::uint32_t b) const;

  // In steps of the grid, rounded.
  [[nodiscard]] const Eigen::Vector3d& near(std::uint32_t p) const { return near_[p]; }
  [[nodiscard]] std::size_t size() const { return near_.size(); }

 private:
  using Integer = boost::multiprecision::cpp_int;
  using Homogeneous = std::array<Integer, 4>;  // x, y, z and their denominator, which is positive; reduced

  std::uint32_t add(Homogeneous p);

  std::vector<Homogeneous> exact_;
  std::vector<Eigen::Vector3d> near_;
  std::unordered_multimap<std::uint64_t, std::uint32_t> index_;  // only looked up, never walked
};

}  // namespace thimble::host
