// The god object (proxy): a point that follows the tip and never enters a solid (Zilles and Salisbury 1995).
//
// Each tick it moves to the point nearest to the tip that it can reach. It flies until it hits a surface,
// then slides over the surface. Where it touches two or three surfaces, all their planes are solved together.
// Every piece of its path is swept against all objects nearby, so it is always at a place that was proven
// free. When a bound is hit it stays at such a place, and the bound is counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr std::size_t kMaxContacts = 3;  // one for each powered degree of freedom

struct Contact {
  std::uint8_t object = 0;
  Feature feature;
};

struct GodObject {
  Vec3 position_m = Vec3::Zero();
  std::array<Contact, kMaxContacts> contacts;
  std::size_t count = 0;  // 0: in free space
  // The last contact that stopped pushing while the god object may still lie on its surface. It keeps the
  // side of that surface, which the position alone does not tell.
  Contact beside;
  bool has_beside = false;
  // Where several solids are near (contact/ball.h): the centre of the ball over position_m, and the planes of the contacts.
  bool is_ball = false;
  Vec3 centre_m = Vec3::Zero();
  std::array<Vec3, kMaxContacts> normals;
};

// A contact constraint: one plane that holds the god object back, F += K lambda n. The material is that of
// the object, until the effects of its surface change it (control/surfaces).
struct Constraint {
  std::uint8_t object = 0;
  Vec3 normal = Vec3::UnitZ();
  float lambda_m = 0.0F;
  Material material;
};

struct Constraints {
  std::array<Constraint, kMaxContacts> list;
  std::size_t count = 0;
};

// A box around the tip that holds every move of the god object in one tick. Free moves bring it nearer to the
// tip; moves towards a stiction point or a shaded plane stay within three times that distance. No solid beyond it is
// near enough to touch the ball that the god object becomes where there are several.
struct Reach {
  static constexpr float kMoves = 3.0F;

  Vec3 lo_m;
  Vec3 hi_m;
  Vec3 tip_m;
  Vec3 gap_m;

  Reach(const GodObject& god, const GodObject& rest, const Vec3& tip) noexcept
      : tip_m(tip), gap_m((god.position_m - tip).cwiseAbs().cwiseMax((rest.position_m - tip).cwiseAbs())) {
    const float reach =
        kMoves * (gap_m.x() + gap_m.y() + gap_m.z()) + 2.0F * kPointRadius_m;  // no shorter than the distance
    lo_m = tip.array() - reach;
    hi_m = tip.array() + reach;
  }
  [[nodiscard]] bool meets(const PlacedObject& o) const noexcept {
    return o.lo_m.x() <= hi_m.x() && o.lo_m.y() <= hi_m.y() && o.lo_m.z() <= hi_m.z() &&
           o.hi_m.x() >= lo_m.x() && o.hi_m.y() >= lo_m.y() && o.hi_m.z() >= lo_m.z();
  }
  // The radius of a ball about the tip that holds every move.
  [[nodiscard]] float radius_m() const noexcept { return kMoves * gap_m.norm() + 2.0F * kPointRadius_m; }
};

// The objects within reach, except for one. Where the boxes of several are, the distance of convex ones counts.
inline constexpr int kNoObject = -1;

class Nearby {
 public:
  Nearby(const World& world, const Reach& reach, int without = kNoObject) noexcept;
  [[nodiscard]] std::span<const std::uint8_t> objects() const { return {list_.data(), count_}; }
  [[nodiscard]] bool several() const { return count_ > 1; }

 private:
  std::array<std::uint8_t, kMaxObjects> list_;
  std::size_t count_ = 0;
};

// Where several solids are near, both move it as a ball (contact/ball.h).
//
// Moves a god object in free space to `target`, or to the place where its flight hits a surface.
void fly(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target,
         RenderCounters& counters) noexcept;

// Moves the god object to the point nearest to `target` that it can reach. hold: it stays on its surface, for
// targets near the surface itself (friction, shading).
void move(const World& world, const Nearby& nearby, GodObject& god, const Vec3& target, bool hold,
          RenderCounters& counters) noexcept;

// Writes the unit normals of the planes that the god object lies on, towards the free side, world frame;
// returns how many.
std::size_t contact_normals(const World& world, const GodObject& god,
                            std::span<Vec3, kMaxContacts> normals) noexcept;

// The contact constraints: splits god - tip over the planes that hold the god object, sum of lambda n = god -
// tip, lambda >= 0.
[[nodiscard]] Constraints constraints(const World& world, const GodObject& god, const Vec3& tip) noexcept;

}  // namespace thimble::control
