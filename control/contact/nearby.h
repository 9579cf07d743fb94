// Which objects the god object can meet in a tick.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/inside.h"
#include "control/contact/world.h"
#include "kinematics/vector.h"

namespace thimble::control {

class Resting;  // control/contact/planes.h

// A box around the tip that holds every move of the god object in one tick. Free moves bring it nearer to the
// tip; moves towards a stiction point or a shaded plane stay within three times that distance. No solid beyond it is
// near enough to touch the tip's sphere, or the ball that the god object becomes where there are several.
struct Reach {
  static constexpr float kMoves = 3.0F;

  Vec3 lo_m;
  Vec3 hi_m;
  Vec3 tip_m;
  Vec3 gap_m;
  float margin_m;  // World::margin_m

  Reach(const Vec3& god, const Vec3& rest, const Vec3& tip, float margin) noexcept
      : tip_m(tip), gap_m((god - tip).cwiseAbs().cwiseMax((rest - tip).cwiseAbs())), margin_m(margin) {
    const float reach =
        kMoves * (gap_m.x() + gap_m.y() + gap_m.z()) + margin_m;  // no shorter than the distance
    lo_m = tip.array() - reach;
    hi_m = tip.array() + reach;
  }
  [[nodiscard]] bool meets(const PlacedObject& o) const noexcept {
    return o.lo_m.x() <= hi_m.x() && o.lo_m.y() <= hi_m.y() && o.lo_m.z() <= hi_m.z() &&
           o.hi_m.x() >= lo_m.x() && o.hi_m.y() >= lo_m.y() && o.hi_m.z() >= lo_m.z() &&
           (!o.half_space || o.normal.dot(tip_m) - o.offset_m <= radius_m());
  }
  // The radius of a ball about the tip that holds every move.
  [[nodiscard]] float radius_m() const noexcept { return kMoves * gap_m.norm() + margin_m; }
};

// The objects within reach, except for some. Where the boxes of several are, the distance of convex ones counts.
class Nearby {
 public:
  // Of the finger. triangles: for the mesh among the objects if it is one only; null: none.
  Nearby(const World& world, const Reach& reach, SolidSet without, TriangleCache* triangles,
         Resting& resting) noexcept;
  // Those of them that a move can meet which stays within a distance of a place.
  [[nodiscard]] Nearby within(const World& world, const Vec3& place_m, float distance_m) const noexcept;
  // For a ball.
  explicit Nearby(std::uint8_t object) noexcept : list_{object}, count_(1) {}
  [[nodiscard]] std::span<const std::uint8_t> objects() const { return {list_.data(), count_}; }
  [[nodiscard]] bool several() const { return count_ > 1; }
  // The lists of triangles for the one mesh: of a tip with a radius, or else of a point.
  [[nodiscard]] TriangleCache* triangles() const { return one_mesh_ && !point_ ? triangles_ : nullptr; }
  [[nodiscard]] TriangleCache* point_triangles() const { return one_mesh_ && point_ ? triangles_ : nullptr; }
  [[nodiscard]] Resting& resting() const { return *resting_; }

 private:
  void keep(const World& world, const Vec3& place_m, float distance_m) noexcept;

  std::array<std::uint8_t, kMaxObjects> list_;
  std::size_t count_ = 0;
  TriangleCache* triangles_ = nullptr;
  Resting* resting_ = nullptr;
  bool one_mesh_ = false;
  bool point_ = true;
};

}  // namespace thimble::control
