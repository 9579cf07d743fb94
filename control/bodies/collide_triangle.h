// A convex solid and one triangle of a mesh after the other (control/bodies/collide_mesh.cpp).
//
// A triangle is met along the direction of least overlap on its free side. Most triangles are decided by a few products
// (triangle_forms.cpp): one that is not in the box about the solid, or whose plane the solid does not reach, is apart; where
// the solid's farthest point along the face's normal is above the triangle, or the triangle's highest corner is below a flat
// face of the solid, no neighbouring direction has less overlap; nor where the corner that is deepest in a curved solid is the
// highest one along the solid's normal there, or an edge of a box lies across an edge of the triangle; for a ball the nearest
// point of the triangle is enough. What remains, mostly edges, waits until all others are met, and is searched
// (least_overlap): of more than kMaxSearches the deepest ones, because what is deepest holds the solid.
//
// A contact counts only where no neighbour of the triangle rises in its direction: an edge or corner between level or
// hollow faces is no obstacle, and the face beyond it has a contact of its own.
#pragma once

#include <array>
#include <cstdint>

#include "control/bodies/convex.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/mesh_view.h"

namespace thimble::control {

class TriangleCollision {
 public:
  // free_m: a place on the free side of sheets. a, mesh and out are kept until the end.
  void begin(const Convex& a, const MeshView& mesh, const Vec3& free_m, float margin_m, Manifold& out);
  void collide(std::uint32_t triangle);
  // After the last triangle, in steps. False: it goes on.
  [[nodiscard]] bool finish();
  [[nodiscard]] bool at_bound() const;
  [[nodiscard]] bool passed_over() const { return !met_all_; }
  [[nodiscard]] float ball_m() const { return ball_m_; }

  // Whether every triangle was met: no bound was reached, and none in one plane was passed over.
  [[nodiscard]] bool met_all() const { return met_all_ && !lost_; }
  // Whether a bound left out triangles that may hold the solid.
  [[nodiscard]] bool lost() const { return lost_; }
  // The sum of the normals of the triangles that the solid reaches.
  [[nodiscard]] const Vec3& normals() const { return normals_; }

 private:
  struct Face {
    std::uint32_t triangle = 0;
    float side = 1.0F;
    std::array<Vec3, 3> p;   // in the frame of the mesh
    std::array<Vec3, 3> of;  // in the frame of the solid
    Vec3 lo;                 // of these
    Vec3 hi;
    Vec3 normal;  // unit, on the side of the solid
  };

  // A direction of little overlap: an axis of the solid, or the face's normal.
  struct Guess {
    float depth_m = 0.0F;
    int axis = -1;      // below 0: the face's normal
    float sign = 1.0F;  // of the axis
    int level = -1;     // the axis that is the face's normal as well
  };

  // A triangle whose direction of least overlap is searched after the others.
  struct Deferred {
    std::uint32_t triangle;
    float depth_m;  // along the best direction so far
    Vec3 normal;
  };
  static constexpr std::size_t kMaxDeferred = 48;
  static constexpr int kMaxSearches = 12;

  // A direction is better when it saves this much.
  static constexpr float kSooner_m = 2.0e-7F;
  static constexpr float kSameLine = 1.0F - 1.0e-6F;  // cosine

  enum class Verdict : std::uint8_t { kOpen, kApart, kLeast };

  // Of the highest corner along the direction.
  [[nodiscard]] static float height_of(const std::array<Vec3, 3>& p, const Vec3& direction);
  [[nodiscard]] bool place(std::uint32_t triangle, Face& face) const;
  void collide_round(const Face& face, float depth_m, const Vec3& lowest_m);
  [[nodiscard]] Guess along_axes(const Face& face, float depth_m) const;
  [[nodiscard]] bool is_least(const Face& face, const Guess& guess, const Vec3& lowest_m,
                              Overlap& overlap) const;
  [[nodiscard]] Verdict along_edges(const Face& face, Overlap& overlap) const;
  [[nodiscard]] Verdict at_corner(const Face& face, Overlap& overlap) const;
  void collide_flat(const Face& face, const Guess& guess, const Vec3& lowest_m);
  void offer(const Face& face, const Vec3& normal, Overlap& best) const;
  void offer_neighbours(const Face& face, Overlap& best) const;
  [[nodiscard]] bool is_over(const Face& face, const Vec3& p) const;
  [[nodiscard]] bool is_under_face(const Vec3& p, int axis, float sign) const;
  void push_out(const Vec3& of_core_m, const Vec3& apart_m, Overlap& overlap) const;
  void defer(const Face& face, Overlap overlap);
  [[nodiscard]] bool push_out_line(const Face& face, Overlap& overlap) const;
  [[nodiscard]] bool search();
  // False: the mesh goes on in that direction.
  bool add(const Face& face, Overlap& overlap, bool corner);
  [[nodiscard]] bool is_alone(const Face& face, const Vec3& normal, float depth_m) const;
  [[nodiscard]] bool is_known(const Face& face) const;
  [[nodiscard]] bool is_level(const Face& face) const;
  [[nodiscard]] bool rises(std::uint32_t triangle, const Vec3& normal) const;
  [[nodiscard]] bool rises_round_corner(std::uint32_t triangle, std::uint32_t corner,
                                        const Vec3& normal) const;

  const Convex* a_ = nullptr;
  const MeshView* mesh_ = nullptr;
  float margin_m_ = 0.0F;
  Manifold* out_ = nullptr;
  Vec3 free_m_;
  Vec3 centre_m_;        // of the box about the solid, in its frame
  Vec3 inner_m_;         // a point of the solid, in the frame of the mesh
  float ball_m_ = 0.0F;  // of a hull: radius of the ball round the centre of its box about it
  int level_ = 0;
  int passed_over_ = 0;
  int tried_ = 0;
  int triangles_ = 0;
  int searches_ = 0;
  std::array<Deferred, kMaxDeferred> deferred_;  // the first deferred_count_ ones are written
  std::size_t deferred_count_ = 0;
  bool met_all_ = true;
  bool lost_ = false;
  Vec3 normals_ = Vec3::Zero();
  bool searches_one_ = false;  // search_ is at searched_
  Face searched_;
  Overlap searched_overlap_;
  OverlapSearch search_;
};

}  // namespace thimble::control
