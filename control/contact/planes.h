// The planes that a god object lies on.
#pragma once

#include <array>
#include <cstddef>

#include "control/contact/god_object.h"
#include "control/contact/half_spaces.h"
#include "control/contact/world.h"
#include "control/solids/solid.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The planes at the god object, each with its contact. A plane's offset is how far the god object is behind the surface,
// from rounding.
constexpr std::size_t kMaxPlanes = 2 * kMaxContacts;

struct Planes {
  std::array<HalfSpace, kMaxPlanes> plane;
  std::array<std::size_t, kMaxPlanes> contact;
  std::size_t count = 0;
};

// A short slide that stays on the surface, in the frame of the object, and the planes at its start.
struct ShortSlide {
  const ShapeData* shape = nullptr;  // null: none
  Feature feature;
  Vec3 from_m = Vec3::Zero();
  Vec3 target_m = Vec3::Zero();
  Feature feature_there;
  Vec3 to_m = Vec3::Zero();
  SlideEnd end = SlideEnd::kHeld;
  int normal_count = 0;  // 0: not asked for yet
  std::array<Vec3, 3> normals;
};

// Of one fingertip: where its god object rests, each tick asks the same several times. The same question gets the same bits.
class Resting {
 public:
  // Out of line, as boards have little code memory. A copy remembers nothing.
  Resting() noexcept;
  Resting(const Resting& /*other*/) noexcept : Resting() {}
  Resting& operator=(const Resting& /*other*/) noexcept {
    forget();
    return *this;
  }
  ~Resting() = default;
  void forget() noexcept;
  // A short slide that stays on the surface. What it returns is good until the next call.
  ShortSlide& slide(const PlacedObject& object, const Feature& feature, const Vec3& from_m,
                    const Vec3& target_m, Work& work) noexcept;
  // The planes at the god object.
  const Planes& planes_at(const World& world, const GodObject& god) noexcept;
  // The displacement nearest to r that these planes allow; none where there is no answer.
  const NearestInside& project(const Vec3& r) noexcept;

 private:
  [[nodiscard]] bool is_at(const World& world, const GodObject& god) const noexcept;
  void find_planes(const World& world, const GodObject& god) noexcept;

  std::array<ShortSlide, 3> slides_;
  std::size_t next_ = 0;  // is replaced next
  Planes planes_;
  // Of which place they are, unless that is on an object that moves.
  bool placed_ = false;
  Vec3 position_m_ = Vec3::Zero();
  std::array<Contact, kMaxContacts> contacts_;
  std::size_t count_ = 0;
  // Of these planes.
  bool projected_ = false;
  Vec3 r_m_ = Vec3::Zero();
  NearestInside projection_;
};

}  // namespace thimble::control
