// Independent implementations of the renderer's queries, in double precision and without its optimisations.
// No code is shared with control/: separate tree, separate exact tests, separate god object.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::test {

using Eigen::Vector3d;

struct Nearest {
  double distance_m = std::numeric_limits<double>::infinity();
  Vector3d point = Vector3d::Zero();
  std::uint32_t triangle = 0xFFFFFFFF;
};

struct Crossing {
  double t = 0;  // along the segment, 0 to 1
  std::uint32_t triangle = 0;
  bool inwards = false;  // against the triangle's normal
};

class MeshOracle {
 public:
  explicit MeshOracle(const host::TriangleSoup& soup);

  // The nearest point of the mesh within `within_m`.
  [[nodiscard]] Nearest nearest(const Vector3d& p,
                                double within_m = std::numeric_limits<double>::infinity()) const;

  // Distance to the surface, negative in the solid, for a closed mesh; `within_m` if there is none within
  // that distance. Where several faces are equally near (an edge, a vertex), the one whose plane is farthest
  // from p determines the side.
  [[nodiscard]] double signed_distance(const Vector3d& p,
                                       double within_m = std::numeric_limits<double>::infinity()) const;

  // Every triangle that the segment intersects, in order.
  [[nodiscard]] std::vector<Crossing> crossings(const Vector3d& from, const Vector3d& to) const;
  [[nodiscard]] bool crosses(const Vector3d& from, const Vector3d& to) const;

  // Every triangle within `radius_m` of p.
  void near(const Vector3d& p, double radius_m, std::vector<std::uint32_t>& triangles) const;

  // Whether a path over the faces from a to b, points on the surface, exists within the ball of `radius_m`
  // around `centre`. Exact: the part of a face in the ball is convex, so it connects all edges of the face
  // that reach into the ball.
  [[nodiscard]] bool way_over(const Vector3d& a, const Vector3d& b, const Vector3d& centre,
                              double radius_m) const;

  [[nodiscard]] Vector3d closest_on(std::uint32_t triangle, const Vector3d& p) const;
  [[nodiscard]] Vector3d normal(std::uint32_t triangle) const { return normals_[triangle]; }
  [[nodiscard]] Vector3d corner(std::uint32_t triangle, int corner) const;
  [[nodiscard]] std::size_t size() const { return corners_.size(); }
  [[nodiscard]] const Eigen::AlignedBox3d& bounds() const { return nodes_.front().box; }

 private:
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first = 0;  // index into order_ for a leaf, otherwise the left child
    std::uint32_t count = 0;  // 0: not a leaf
    std::uint32_t right = 0;
  };
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count, int depth);
  template <typename Visit>
  void along(const Vector3d& from, const Vector3d& to, const Visit& visit) const;

  std::vector<std::array<Vector3d, 3>> corners_;
  std::vector<std::array<std::uint32_t, 3>>
      across_;  // the neighbour at each edge; the triangle itself if there is none
  std::vector<Vector3d> normals_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// The god object by definition: from its position it descends in |tip - g| by short steps that never cross a
// face. It is a ball of `clearance_m` kept away from the faces by unsigned distances only, so sides, edges
// and corners need no special cases.
class ReferenceGodObject {
 public:
  explicit ReferenceGodObject(const MeshOracle& mesh, double step_m = 2e-5, double clearance_m = 1e-8);

  void place(const Vector3d& free_point) { g_ = free_point; }
  // Follows the tip; false: not converged after `max_steps`.
  bool follow(const Vector3d& tip, int max_steps = 20000);
  [[nodiscard]] const Vector3d& position() const { return g_; }

 private:
  const MeshOracle& mesh_;
  double step_m_;
  double clearance_m_;
  Vector3d g_ = Vector3d::Zero();
  std::vector<std::uint32_t> near_;
};

// Whether a path from a to b exists that crosses no face and stays within the ball of `radius_m` around
// `centre`. (In one tick a god object may use any path in the ball around the tip whose radius is their
// distance.) Searches along `samples` random points in the ball, half of them close to the surface; "no"
// means that none was found.
[[nodiscard]] bool way_around(const MeshOracle& mesh, const Vector3d& a, const Vector3d& b,
                              const Vector3d& centre, double radius_m, int samples, std::uint64_t seed);

// The nearest vector to `wanted` with v . n >= 0 for every n, by trying every set of up to three active
// constraints.
[[nodiscard]] Vector3d project_on_cone(const Vector3d& wanted, const std::vector<Vector3d>& normals);

}  // namespace thimble::test
