// The search for the contacts of bodies: with fixed objects and with each other, pair by pair. It can end anywhere, when the
// tick's work is spent, and goes on there in the next tick: the bodies must not move before it is done.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/contact_patches.h"
#include "control/bodies/pair_collision.h"
#include "control/bodies/solver_body.h"
#include "control/contact/world.h"
#include "control/effort.h"
#include "control/scene/limits.h"

namespace thimble::control {

// Contact points are collected at this gap and below; the gap grows by the distance that the bodies approach in one tick.
inline constexpr float kContactMargin_m = 1.0e-4F;

inline bool boxes_overlap(const PlacedObject& a, const PlacedObject& b, float margin_m) {
  for (Eigen::Index i = 0; i < 3; ++i)
    if (a.lo_m[i] - margin_m > b.hi_m[i] || b.lo_m[i] - margin_m > a.hi_m[i]) return false;
  return true;
}

class ContactSearch {
 public:
  void begin(const World& world, std::span<const SolverBody> bodies, float period_s) noexcept;
  // True: `found` has the contacts of all pairs. The arguments but the effort are the same ones up to then.
  [[nodiscard]] bool go_on(const World& world, std::span<const SolverBody> bodies, float period_s,
                           ContactPatches& found, Effort& effort) noexcept;

 private:
  [[nodiscard]] bool begin_next(const World& world, std::span<const SolverBody> bodies, float period_s,
                                Work& work) noexcept;
  void find_near(const World& world, std::span<const SolverBody> bodies) noexcept;
  [[nodiscard]] bool begin_pair(const World& world, std::span<const SolverBody> bodies,
                                float period_s) noexcept;
  void end_pair(const World& world, std::span<const SolverBody> bodies, float period_s, ContactPatches& found,
                Effort& effort) noexcept;

  std::array<float, kMaxBodies> moves_m_{};  // in a period, at most
  std::uint64_t fixed_ = 0;                  // objects
  static_assert(kMaxObjects <= 64 && kMaxBodies <= 16);
  std::size_t a_ = 0;
  bool looked_ = false;  // at what is near a: of that, what is left
  std::uint64_t near_fixed_ = 0;
  std::uint16_t near_bodies_ = 0;  // beyond a
  enum class At : std::uint8_t { kNext, kIn, kEnd };
  At at_ = At::kNext;  // a pair
  std::uint8_t b_ = kNoBody;
  std::uint8_t object_b_ = 0;
  float margin_m_ = 0.0F;
  PairCollision collision_;
  Manifold manifold_;
};

}  // namespace thimble::control
