// A convex solid and the triangles of a mesh, in steps: each of them meets one node of the tree or one triangle.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "control/bodies/collide_triangle.h"
#include "control/bodies/convex.h"
#include "control/solids/mesh_view.h"

namespace thimble::control {

class MeshWalk {
 public:
  // a, mesh and out are kept until the end.
  void begin(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m, Manifold& out);
  // False: it goes on.
  [[nodiscard]] bool step();
  [[nodiscard]] const TriangleCollision& triangles() const { return triangles_; }
  // Whether nodes were left out at a bound.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  struct Waiting {
    float reach_m;  // how far the solid's box reaches into the node's
    std::uint32_t child;
  };
  static constexpr std::size_t kMaxWaiting = 96;

  [[nodiscard]] bool meet();
  [[nodiscard]] bool visit();
  [[nodiscard]] bool go_to_next();
  void wait(const flatbuffers::Array<std::uint16_t, 3>& lo, const flatbuffers::Array<std::uint16_t, 3>& hi,
            std::uint32_t child);
  // How far the solid, or the box about it, is from a box with the axes of the mesh; below 0 where they overlap.
  [[nodiscard]] float gap_m(const Vec3& middle_m, const Vec3& half_m) const;

  const Convex* a_ = nullptr;
  const MeshView* mesh_ = nullptr;
  float margin_m_ = 0.0F;
  Mat3 axes_;
  Vec3 box_m_;  // half of a box with the axes of the mesh about the solid
  TriangleCollision triangles_;
  float ball_m_ = 0.0F;  // of a ball or hull: radius of the ball round the centre about it
  std::array<Waiting, kMaxWaiting> waiting_;
  std::size_t waiting_count_ = 0;
  std::uint32_t node_ = 0;
  std::uint32_t triangle_ = 0;  // of a leaf, up to end_
  std::uint32_t end_ = 0;
  int visits_ = 0;
  bool walked_ = false;
  bool lost_ = false;
};

class MeshCollision {
 public:
  // a, mesh and margin_m are the same ones up to the end.
  void begin(const Convex& a, const MeshView& mesh, float margin_m);
  // False: it goes on. All points are in the frame of the mesh.
  [[nodiscard]] bool step(const Convex& a, const MeshView& mesh, float margin_m, Work& work, Manifold& out);

 private:
  enum class Stage : std::uint8_t { kSolid, kNextDirection, kCorners, kNextEdge, kSplits };

  void choose_directions(const Convex& a, bool lost);
  [[nodiscard]] bool begin_next(const Convex& a, const MeshView& mesh, float margin_m, Manifold& out);
  [[nodiscard]] bool begin_point(const Convex& a, const MeshView& mesh, float margin_m, const Vec3& p);
  [[nodiscard]] bool end_point(ContactPoint& out) const;
  void end_corner(Manifold& out);
  void end_split();

  MeshWalk walk_;
  Stage stage_ = Stage::kSolid;
  Manifold found_;  // of this solid alone: what it touches tells which triangles can be passed over
  std::array<ContactPoint, 3> deepest_;  // of each direction
  std::size_t count_ = 0;
  std::size_t at_ = 0;
  // The corners of the face of the solid that is farthest against the direction, and where its edges leave the mesh.
  Outline face_;
  std::array<bool, kMaxManifold> held_{};
  std::size_t corners_ = 0;
  std::size_t corner_ = 0;  // or the edge from it
  Convex point_;
  Manifold there_;
  Vec3 on_m_;
  Vec3 off_m_;
  ContactPoint last_;
  int splits_ = 0;
  bool any_ = false;
};

}  // namespace thimble::control
