// The contact patches of one tick: where bodies touch each other and fixed objects. A patch is one pair of
// objects with the points whose normals agree; a pair that touches in a groove has several.
//
// Each patch keeps at most kMaxPatchPoints points, chosen for depth and area, so that a face rests on its
// corners. When more than kMaxBodyContacts points touch, the patches with the most points lose their least deep
// ones; each patch keeps at least one, so a pair that touches is never left out. When more than kMaxBodyPatches
// patches touch, the least deep one is dropped. What is lost at these two bounds is counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/collide.h"
#include "control/effort.h"
#include "control/scene/limits.h"
#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr std::size_t kMaxPatchPoints = 4;
inline constexpr std::size_t kMaxBodyPatches = 64;

// A unit of impulse along a contact's normal: its arms about the bodies' centres, and what it does to them.
struct NormalRow {
  Vec3 normal;  // pushes body a
  Vec3 arm_a;
  Vec3 arm_b;
  Vec3 linear_a;
  Vec3 angular_a;
  Vec3 linear_b;
  Vec3 angular_b;
  float mass = 0.0F;  // effective mass; 0: neither body can move along the normal
};

struct PatchPoint {
  Vec3 point_m;
  float depth_m = 0.0F;
  float impulse_N_s = 0.0F;
  float target_m_s = 0.0F;  // speed of separation that the contact asks for
  bool bounces = false;
  NormalRow row;
};

struct PatchPair {
  std::uint8_t object_a = 0;
  std::uint8_t object_b = 0;
  std::uint8_t a = 0;  // indices of the bodies; kNoBody: a fixed object
  std::uint8_t b = 0;
  float static_friction = 0.0F;
  float dynamic_friction = 0.0F;
};

// Friction has three directions: two along the surface and the turn about the normal, which is counted at
// radius_m: its speed is radius_m times the relative spin, its impulse the moment over radius_m.
struct Patch : PatchPair {
  std::uint8_t count = 0;
  std::array<std::uint8_t, kMaxPatchPoints> points{};
  bool sliding = false;
  float deepest_m = 0.0F;
  float held_N_s = 0.0F;  // normal impulse that no point has, where neither body can move along the normal
  Vec3 normal;
  std::array<Vec3, 2> across;
  Vec3 centre_m;  // of pressure
  float radius_m = 0.0F;
  Mat3 mass;                 // effective mass of the three directions; zero where neither body can move
  float drag_per_kg = 0.0F;  // of a patch that slides: its slip is -drag * impulse
  Vec3 impulse_N_s;          // of the three directions
  Vec3 slip_m;               // how far it has moved in the three directions while it sticks
};

class ContactPatches {
 public:
  void clear() noexcept;

  // Adds the contact points of a pair.
  void add(const PatchPair& pair, const Manifold& manifold, Effort& effort) noexcept;

  [[nodiscard]] std::span<Patch> patches() noexcept { return {patches_.data(), patch_count_}; }
  [[nodiscard]] PatchPoint& point(const Patch& patch, std::size_t i) noexcept {
    return points_[patch.points[i]];
  }
  [[nodiscard]] std::size_t points() const noexcept { return used_; }

 private:
  using Chosen = std::array<const ContactPoint*, kMaxPatchPoints>;

  std::size_t make_room(Chosen& chosen, std::size_t count, float deepest_m, Effort& effort) noexcept;
  void drop_point(Patch& patch) noexcept;
  Patch* place_for(float deepest_m, Effort& effort) noexcept;

  std::array<Patch, kMaxBodyPatches> patches_;
  std::array<PatchPoint, kMaxBodyContacts> points_;
  std::array<std::uint8_t, kMaxBodyContacts> free_{};  // indices of the points that no patch has
  bool in_order_ = false;                              // these, before the first point of a step
  std::size_t patch_count_ = 0;
  std::size_t used_ = 0;
};

}  // namespace thimble::control
