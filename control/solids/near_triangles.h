// The triangles of a mesh round a place, kept from tick to tick. A ball that stays near that place needs no walk of the
// tree: separate_mesh() (control/solids/mesh.h) reads them here. They are copies of what is in the image, in the order of
// the tree, and never change an answer: a tick with an empty cache gives the same bytes.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <variant>

#include "control/solids/kept_face.h"
#include "control/solids/mesh_topology.h"
#include "control/solids/solid.h"
#include "kinematics/vector.h"

namespace thimble::control {

// What is farther from the disc than this beyond a distance is farther than the distance from the triangle, with rounding.
inline constexpr float kDiscRounding_m = 4.0e-6F;

// A triangle in a disc about it.
struct NearTriangle {
  Vec3 normal;
  Vec3 middle_m;
  float radius_m;
  std::uint32_t triangle;
  bool two_sided;

  // False when the triangle is farther than this from the place, or when the place is behind it by more than behind_m.
  [[nodiscard]] bool within(const Vec3& place_m, float distance_m, float behind_m) const {
    const Vec3 from = place_m - middle_m;
    const float height_m = normal.dot(from);
    if (height_m < -behind_m && !two_sided) return false;
    // (distance to the disc)^2 = height^2 + (across - radius)^2
    const float height2 = height_m * height_m;
    const float reach2 = distance_m * distance_m - height2;
    const float excess2 = from.squaredNorm() - height2 - radius_m * radius_m - reach2;
    return reach2 >= 0.0F && (excess2 <= 0.0F || excess2 * excess2 <= 4.0F * radius_m * radius_m * reach2);
  }
};

[[nodiscard]] NearTriangle in_disc(const MeshView& mesh, std::uint32_t triangle);

// Whether a triangle lies behind a plane.
[[nodiscard]] inline bool lies_behind(const MeshView& mesh, std::uint32_t triangle, const Vec3& normal,
                                      float offset_m) {
  for (std::uint32_t corner = 0; corner < 3; ++corner)
    if (normal.dot(topology::vertex(mesh, triangle, corner)) > offset_m + kSurfaceTolerance_m) return false;
  return true;
}

// The triangles within a distance of one place of one mesh.
class NearTriangles {
 public:
  static constexpr std::size_t kMax = 28;

  // Whether all triangles that a ball at the centre, or within reach_m of it, can touch are listed.
  [[nodiscard]] bool hold(const ShapeData& shape, const Vec3& centre_m, float radius_m, float reach_m) const {
    const float room_m = reach_m_ - reach_m;
    return shape_ == &shape && radius_m == radius_m_ && room_m >= 0.0F &&
           (centre_m - centre_m_).squaredNorm() <= room_m * room_m;
  }
  void clear() {
    shape_ = nullptr;
    count_ = 0;
  }
  // False, and empty, when there is no room, or the work is spent.
  bool fill(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m, float reach_m);

  [[nodiscard]] std::span<const NearTriangle> list() const { return {list_.data(), count_}; }

  // The places in the list of all that do not lie behind the face of a listed triangle, on the side that is given.
  [[nodiscard]] std::span<const std::uint8_t> before(const MeshView& mesh, std::uint32_t triangle,
                                                     std::int8_t side, const Vec3& normal);

 private:
  const ShapeData* shape_ = nullptr;  // null: empty
  Vec3 centre_m_ = Vec3::Zero();
  float radius_m_ = 0.0F;
  float reach_m_ = 0.0F;
  std::size_t count_ = 0;
  std::array<NearTriangle, kMax> list_;
  // The last answer of before().
  std::uint32_t face_ = 0;
  std::int8_t side_ = 0;
  std::uint8_t before_count_ = 0;
  std::array<std::uint8_t, kMax> before_;
};

// A box in steps of a mesh's grid; the ends belong to it.
struct GridBox {
  std::array<std::uint32_t, 3> lo, hi;

  [[nodiscard]] bool holds(const GridBox& other) const {
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (other.lo[axis] < lo[axis] || other.hi[axis] > hi[axis]) return false;
    return true;
  }
};

// The leaves of one mesh's tree that meet a box, for a point: a flight within the box needs no walk of the tree. They are found without a
// look at their triangles.
class NearLeaves {
 public:
  static constexpr std::size_t kMax = 24;
  struct Leaf {
    std::array<std::uint16_t, 3> lo, hi;
    std::uint32_t leaf;
  };

  [[nodiscard]] bool hold(const ShapeData& shape, const GridBox& box) const {
    return shape_ == &shape && box_.holds(box);
  }
  void clear() {
    shape_ = nullptr;
    count_ = 0;
  }
  // False, and empty, when there is no room, or the work is spent.
  bool fill(const ShapeData& shape, Work& work, const GridBox& box);
  [[nodiscard]] std::span<const Leaf> list() const { return {list_.data(), count_}; }
  // How far a place is at least from the mesh, in steps of its grid; 0: not known.
  [[nodiscard]] float away(const ShapeData& shape, const Vec3& place) const;

 private:
  const ShapeData* shape_ = nullptr;  // null: empty
  GridBox box_{};
  std::size_t count_ = 0;
  std::array<Leaf, kMax> list_;
};

// The plane of a triangle.
struct TrianglePlane {
  const ShapeData* shape = nullptr;  // null: none
  std::uint32_t triangle = 0;
  Vec3 corner;  // the first one, m
  Vec3 normal;  // twice the area times the unit normal
  bool two_sided = false;
};

// A flight past a mesh that was asked for, and what it met. Where a god object rests, each tick asks the same.
struct KnownFlight {
  const ShapeData* shape = nullptr;  // null: none
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
  std::array<Feature, 3> leaving;
  std::size_t leaving_count = 0;
  Hit hit;
};

[[nodiscard]] TrianglePlane plane_of(const ShapeData& shape, std::uint32_t triangle);

struct TrianglesOfPoint {
  static constexpr std::uint32_t kFirst_steps = 256;

  std::array<NearLeaves, 2> lists;
  std::size_t last = 0;                     // used
  std::uint32_t more_steps = kFirst_steps;  // by which the box of the next list is larger than it has to be
  std::array<TrianglePlane, 16> planes;     // that were looked at
  // The stiction point, the place without friction and the shaded place can be on one each.
  std::array<KeptFace, 4> faces;
  KnownFlight flight;
};

struct TrianglesOfBall {
  static constexpr float kFirst_m = 5.0e-4F;
  static constexpr float kMost_m = 1.0e-2F;

  std::array<NearTriangles, 2> lists;
  std::size_t last = 0;     // used
  float next_m = kFirst_m;  // the reach of the next list
  float most_m = kMost_m;   // no list beyond this: the last one was too long
};

// Of one fingertip: two lists, as the place without friction and the stiction point are apart. A tip is a point or has a radius, so what
// each needs shares its memory.
class TriangleCache {
 public:
  TriangleCache() noexcept;
  void clear() noexcept;
  // For a tip with a radius. Null when they are too many, or the work is spent.
  [[nodiscard]] NearTriangles* near(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m,
                                    float reach_m);
  // Whether a ball at the centre, or within reach_m of it, is known to touch nothing.
  [[nodiscard]] bool is_clear(const ShapeData& shape, Work& work, const Vec3& centre_m, float radius_m,
                              float reach_m);
  // For a point. Null when they are too many, or the work is spent.
  [[nodiscard]] const NearLeaves* leaves(const ShapeData& shape, Work& work, const GridBox& box);
  [[nodiscard]] const TrianglePlane& plane(const ShapeData& shape, std::uint32_t triangle) {
    std::array<TrianglePlane, 16>& planes = of<TrianglesOfPoint>().planes;
    TrianglePlane& plane = planes[triangle % planes.size()];
    if (plane.triangle != triangle || plane.shape != &shape) plane = plane_of(shape, triangle);
    return plane;
  }
  [[nodiscard]] KnownFlight& flight() { return of<TrianglesOfPoint>().flight; }
  // How far a place is at least from the mesh, as far as the lists of a point tell; 0: not known.
  [[nodiscard]] float away_m(const ShapeData& shape, const Vec3& place_m);
  // A face of the mesh. It stays valid until the next one is asked for.
  [[nodiscard]] KeptFace& face(const ShapeData& shape, std::uint32_t triangle) {
    std::array<KeptFace, 4>& faces = of<TrianglesOfPoint>().faces;
    KeptFace& kept = faces[triangle % faces.size()];
    if (kept.triangle != triangle || kept.shape != &shape) keep_face(shape, triangle, kept);
    return kept;
  }

 private:
  template <typename Of>
  [[nodiscard]] Of& of() {
    Of* const now = std::get_if<Of>(&of_);
    return now != nullptr ? *now : of_.emplace<Of>();
  }

  std::variant<TrianglesOfPoint, TrianglesOfBall> of_;
};

}  // namespace thimble::control
