// Independent answers to the questions the renderer answers, in double precision and without its shortcuts.
// Nothing here is shared with control/: own tree, own exact tests, own god object.
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

  // The nearest point of the mesh not farther than `within_m`.
  [[nodiscard]] Nearest nearest(const Vector3d& p,
                                double within_m = std::numeric_limits<double>::infinity()) const;

  // Distance to the surface, negative in the solid, for a closed mesh; `within_m` when nothing is that near.
  // Where several faces are equally near (an edge, a vertex) the one whose plane is farthest from p tells the
  // side.
  [[nodiscard]] double signed_distance(const Vector3d& p,
                                       double within_m = std::numeric_limits<double>::infinity()) const;

  // Every triangle that the segment meets, in order.
  [[nodiscard]] std::vector<Crossing> crossings(const Vector3d& from, const Vector3d& to) const;
  [[nodiscard]] bool crosses(const Vector3d& from, const Vector3d& to) const;

  // Every triangle within `radius_m` of p.
  void near(const Vector3d& p, double radius_m, std::vector<std::uint32_t>& triangles) const;

  // Whether a way over the faces leads from a to b, points on the surface, that is never farther from `centre` than `radius_m`.
  // Exact: the part of a face in the ball is convex, so it joins all of the face's edges that reach into the ball.
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
    std::uint32_t first = 0;  // of order_ for a leaf, else the left child
    std::uint32_t count = 0;  // 0: not a leaf
    std::uint32_t right = 0;
  };
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count, int depth);
  template <typename Visit>
  void along(const Vector3d& from, const Vector3d& to, const Visit& visit) const;

  std::vector<std::array<Vector3d, 3>> corners_;
  std::vector<std::array<std::uint32_t, 3>>
      across_;  // the triangle beyond each edge; itself where there is none
  std::vector<Vector3d> normals_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

// The god object by its definition: from where it is, the shortest steps downhill in |tip - g| that never
// cross a face. It is a ball of `clearance_m` kept off the faces by unsigned distances alone, so it knows no
// side, edge or corner as such.
class ReferenceGodObject {
 public:
  explicit ReferenceGodObject(const MeshOracle& mesh, double step_m = 2e-5, double clearance_m = 1e-8);

  void place(const Vector3d& free_point) { g_ = free_point; }
  // Follows the tip; false: still moving after `max_steps`.
  bool follow(const Vector3d& tip, int max_steps = 20000);
  [[nodiscard]] const Vector3d& position() const { return g_; }

 private:
  const MeshOracle& mesh_;
  double step_m_;
  double clearance_m_;
  Vector3d g_ = Vector3d::Zero();
  std::vector<std::uint32_t> near_;
};

// Whether a way leads from a to b that crosses no face and is never farther from `centre` than `radius_m`:
// the ways open to a god object in one tick are those in the ball about the tip through it. Looks for one
// along `samples` random points in the ball, half of them close to the surface; "no" means that none was
// found.
[[nodiscard]] bool way_around(const MeshOracle& mesh, const Vector3d& a, const Vector3d& b,
                              const Vector3d& centre, double radius_m, int samples, std::uint64_t seed);

// The nearest vector to `wanted` with v . n >= 0 for every n, by trying every set of up to three of them as
// walls.
[[nodiscard]] Vector3d project_on_cone(const Vector3d& wanted, const std::vector<Vector3d>& normals);

}  // namespace thimble::test
