// A convex solid, or a convex part of one, for the collisions of control/bodies/collide_convex.cpp: a ball or capsule, a box, a
// cylinder, a cone, a piece of a moving mesh, a triangle of a fixed one. All coordinates are in one frame that the
// caller chooses. Nothing here allocates or fails.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/collide.h"
#include "control/bodies/outline.h"
#include "control/contact/world.h"
#include "control/work.h"
#include "kinematics/vector.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

// A point of a convex solid that is farthest in a direction; `index` tells it from others where they can be counted.
struct FarPoint {
  Vec3 at_m;
  std::uint8_t index = 0;
};

// All points within radius_m of a core. The core is a point (kBall), a line (kCapsule), a box, cylinder or cone, or the
// hull of `corners` (kMesh).
struct Convex {
  CollisionForm form = CollisionForm::kBall;
  const ShapeData* shape = nullptr;
  NearestPlace (*nearest)(const ShapeData& shape, const Vec3& p) = nullptr;  // CollisionOps::nearest
  std::span<const scene::Vec3> corners;
  float radius_m = 0.0F;
  Mat3 rotation = Mat3::Identity();
  Vec3 position_m = Vec3::Zero();
  bool placed = true;            // false: rotation and position are none
  Vec3 centre_m = Vec3::Zero();  // of a box with the axes of `rotation` about it
  Vec3 half_m = Vec3::Zero();
  Work* work = nullptr;  // what farthest() and outline() take; null: counted by the caller

  [[nodiscard]] FarPoint farthest(const Vec3& direction) const noexcept;  // of the core
  // The face, edge or corner of the core that is farthest in the direction of the unit vector: what lies within `depth_m`
  // below its farthest point, where the solid is flat.
  void outline(const Vec3& direction, float depth_m, Outline& out) const noexcept;
};

// A solid that is not a mesh, placed by rotation and position.
[[nodiscard]] Convex convex_solid(const PlacedObject& object, const Mat3& rotation,
                                  const Vec3& position_m) noexcept;
[[nodiscard]] Convex convex_hull(std::span<const scene::Vec3> corners, const Mat3& rotation,
                                 const Vec3& position_m) noexcept;
// A triangle in the frame of its corners, without the box about it.
[[nodiscard]] Convex convex_triangle(std::span<const scene::Vec3> corners) noexcept;
// A point; what is within reach_m of it is near.
[[nodiscard]] Convex convex_point(const Vec3& position_m, float reach_m) noexcept;

// Nearest points of the cores of two convex solids (Gilbert, Johnson and Keerthi 1988). `shift_m` is added to a. The
// search begins at `towards_a`, a direction from b to a. It ends when the solids, not shifted, are known to be apart by
// more than margin_m.
struct NearestPair {
  Vec3 of_a_m;  // as shifted
  Vec3 of_b_m;
  Vec3 apart_m;  // from of_b_m to of_a_m
};
enum class Distance : std::uint8_t {
  kNearest,   // the pair is found
  kTouching,  // the cores are nearer than the rounding, or overlap
  kApart,     // by more than margin_m
};
[[nodiscard]] Distance nearest_points(const Convex& a, const Convex& b, const Vec3& shift_m,
                                      const Vec3& towards_a, float margin_m, NearestPair& out) noexcept;

// The same in steps.
class DistanceSearch {
 public:
  void begin(const Vec3& towards_a) noexcept;
  // One farthest point of each. False: it goes on; the arguments are the same ones in each step.
  [[nodiscard]] bool step(const Convex& a, const Convex& b, const Vec3& shift_m, float margin_m) noexcept;
  [[nodiscard]] Distance distance() const noexcept { return distance_; }
  [[nodiscard]] NearestPair pair() const noexcept;

 private:
  // Corners of the simplex in the difference a - b.
  struct Corner {
    Vec3 at;
    Vec3 of_a;
    Vec3 of_b;
  };

  std::array<Corner, 4> corners_;  // the first nearest_count_ ones span the simplex
  std::array<float, 4> weights_{};
  std::size_t count_ = 0;
  Vec3 apart_m_;
  float length2_ = 0.0F;
  int steps_ = 0;
  Distance distance_ = Distance::kTouching;
};

[[nodiscard]] Vec3 nearest_on_triangle(const std::array<Vec3, 3>& corners, const Vec3& p) noexcept;

// The direction along which two convex solids overlap least.
struct Overlap {
  Vec3 normal = Vec3::UnitZ();    // pushes a away from b
  float depth_m = 0.0F;           // below 0: apart
  Vec3 of_core_m = Vec3::Zero();  // the place of a's core that is nearest to b or deepest in it
  bool settled = false;           // no neighbouring direction has less
};

// How deep a reaches into b along a unit vector that points from b to a.
[[nodiscard]] float depth_along(const Convex& a, const Convex& b, const Vec3& normal) noexcept;

// Descends from a first estimate, whose depth_m and normal are set.
class OverlapSearch {
 public:
  void begin(const Overlap& first) noexcept;
  // False: it goes on; the arguments are the same ones in each step.
  [[nodiscard]] bool step(const Convex& a, const Convex& b, float margin_m) noexcept;
  // False when a and b are apart by more than margin_m, or no normal is found.
  [[nodiscard]] bool found() const noexcept { return found_; }
  [[nodiscard]] const Overlap& overlap() const noexcept { return overlap_; }

 private:
  void begin_descent(const Convex& a, const Convex& b) noexcept;

  Overlap overlap_;
  DistanceSearch distance_;
  Vec3 shift_m_;
  bool raised_ = false;
  int descents_ = 0;
  bool descends_ = false;
  bool found_ = false;
};

// The contact points of two convex solids whose least overlap is known.
void add_contacts(const Convex& a, const Convex& b, const Overlap& overlap, float margin_m,
                  Manifold& out) noexcept;

// Two convex solids, in steps.
class ConvexCollision {
 public:
  void begin() noexcept;
  // False: it goes on; the arguments are the same ones in each step.
  [[nodiscard]] bool step(const Convex& a, const Convex& b, float margin_m, Manifold& out) noexcept;

 private:
  [[nodiscard]] bool may_touch(const Convex& a, const Convex& b, const Vec3& axis, float margin_m) noexcept;
  [[nodiscard]] bool descend(const Convex& a, const Convex& b, float margin_m, Manifold& out) noexcept;

  int axis_ = 0;       // the next one that may lie between them
  int restarts_ = -1;  // of the search; below 0: it has not begun
  Overlap best_;
  OverlapSearch search_;
};

}  // namespace thimble::control
