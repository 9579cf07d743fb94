// Contacts between bodies, and between bodies and fixed objects: soft contacts with one step per tick (Catto 2024,
// "Solver2D") and friction per contact patch.
//
// Stages of one tick: collect_contacts; prepare, recall and prepare_friction for each patch; warm_start; iterate with
// soft contacts, after which the bodies' motion in this tick is known; add_slip; iterate with rigid contacts (relax);
// decide_sliding; store_impulses. The velocities of the soft iterations move the bodies in this tick only, so the
// removal of penetration and slip adds no kinetic energy.
//
// A normal impulse is never negative. A contact that is still open may close by its gap in this tick and no
// more, so no body enters another by its speed. A contact that closes faster than kBounce_m_s bounces with
// the larger restitution of the two bodies.
//
// Friction acts once per patch, at its centre of pressure: a force along the surface and a moment about the
// normal, whose limit surface is a ball when the moment is divided by the mean distance of the points from the
// centre (Goyal 1991; Howe and Cutkosky 1996). Within the limit it stops the motion; at the limit it is opposite
// to it. While a patch sticks, its slip by the remaining error of the iterations is returned. The limit is the static
// coefficient times the normal impulse until the patch is at its limit and has slipped by kSlipped_m, then the dynamic
// one until the motion stops. So a patch that has reached its limit without moving, because others carry the rest,
// does not slide. Each coefficient is the geometric mean of the two materials'.
//
// Bounds: kMaxBodyContacts points in kMaxBodyPatches patches (control/bodies/contact_patches.h), kSolverIterations and
// kRelaxIterations iterations, fewer where the impulses have converged, and kMaxBounceRounds times the latter; kMaxObjects * kMaxBodies
// pairs. All of it charges the tick's work, and can end between any two patches when that is spent: at most 40 000 units for
// kMaxBodyPatches patches that slide and bounce. The next call goes on there, with the velocities as they are.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/contact_patches.h"
#include "control/bodies/contact_search.h"
#include "control/bodies/grip_contacts.h"
#include "control/bodies/solver_body.h"
#include "control/contact/world.h"
#include "control/effort.h"
#include "control/scene/limits.h"
#include "kinematics/vector.h"

namespace thimble::control {

// A patch or a grip slides when it has moved by this and is at its limit. At 1 % above the limit that takes 6 ms; a resting
// stack moves less in the ticks in which its impulses converge.
inline constexpr float kSlipped_m = 2.0e-6F;
inline constexpr float kAtLimit = 1.0F - 1.0e-3F;
inline constexpr float kSameDirection = 0.9F;  // cosine: of the normal of a patch or a grip in the next step

class ContactSolver {
 public:
  [[gnu::cold]] ContactSolver() noexcept;

  // A contact as a spring and damper that are solved with the velocities. As it is initialised: rigid.
  struct Softness {
    float bias_per_s = 0.0F;  // velocity for a metre of penetration
    float mass_scale = 1.0F;
    float impulse_scale = 0.0F;
    float least_m_s = 0.0F;  // less is rounding: is_rounding()
  };

  // Forgets the contacts of the last tick.
  void reset() noexcept;

  // One step of the bodies: begin(), then find() until it returns true, then solve() until it returns true. They return false when the work
  // is spent. Between the calls nothing of the world moves.
  void begin(const World& world, std::span<const SolverBody> bodies, std::span<const Grip> grips,
             float period_s) noexcept;
  // Collects the contacts.
  [[nodiscard]] bool find(const World& world, std::span<const SolverBody> bodies, float period_s,
                          Effort& effort) noexcept {
    return search_.go_on(world, bodies, period_s, found_, effort);
  }
  // Changes the velocities of `bodies` and writes their position corrections.
  [[nodiscard]] bool solve(std::span<SolverBody> bodies, float period_s, Work& work) noexcept;

 private:
  // A patch for the warm start of the next tick. Places are relative to the centre of body a.
  struct StoredPatch {
    std::uint8_t object_a = 0;
    std::uint8_t object_b = 0;
    std::uint8_t a = 0;
    std::uint8_t first = 0;  // of stored_points_
    std::uint8_t count = 0;
    bool sliding = false;
    Vec3 normal;
    Vec3 along_N_s;  // friction
    float moment_N_m_s = 0.0F;
    Vec3 slip_m;
    float twist_rad = 0.0F;
  };
  struct StoredPoint {
    Vec3 place_m;
    float normal_N_s = 0.0F;
  };

  void prepare(std::span<const SolverBody> bodies, Patch& patch, float period_s) noexcept;
  void prepare_friction(std::span<const SolverBody> bodies, Patch& patch) noexcept;
  void recall(std::span<const SolverBody> bodies, Patch& patch) noexcept;
  void warm_start(std::span<SolverBody> bodies, Patch& patch) noexcept;
  // Where nothing but the rounding of coordinates presses on the springs, the first iteration changes nothing and is the last one. Else what
  // it leaves out comes with the others.
  [[nodiscard]] bool is_rounding(float change_m_s, const Softness& softness) const noexcept {
    return iteration_ == 0 && change_m_s < softness.least_m_s;
  }
  float solve_friction(std::span<SolverBody> bodies, Patch& patch, const Softness& softness) noexcept;
  float solve_normals(std::span<SolverBody> bodies, Patch& patch, const Softness& softness) noexcept;
  [[nodiscard]] bool iterate(std::span<SolverBody> bodies, const Softness& softness, int most,
                             Work& work) noexcept;
  [[nodiscard]] bool prepare_all(std::span<SolverBody> bodies, float period_s, Work& work) noexcept;
  [[nodiscard]] bool warm_start_all(std::span<SolverBody> bodies, Work& work) noexcept;
  void end_soft(std::span<SolverBody> bodies, float period_s, Work& work) noexcept;
  void end_relax(std::span<SolverBody> bodies, float period_s, Work& work) noexcept;
  [[gnu::cold]] bool bounce_less(std::span<SolverBody> bodies, Work& work) noexcept;
  [[gnu::cold]] float work_twice_J(std::span<SolverBody> bodies) noexcept;
  float friction_limit_N_s(const Patch& patch) noexcept;
  void add_slip(std::span<const SolverBody> bodies, float period_s) noexcept;
  void decide_sliding() noexcept;
  void keep_of_sleepers(std::span<const SolverBody> bodies) noexcept;
  void store_impulses(std::span<const SolverBody> bodies) noexcept;

  enum class Stage : std::uint8_t { kPrepare, kWarmStart, kSoft, kRelax };

  ContactSearch search_;
  ContactPatches found_;
  GripContacts grips_;
  std::array<StoredPatch, kMaxBodyPatches> stored_;
  std::size_t stored_count_ = 0;
  std::size_t recalled_ = 0;  // the last one
  std::array<StoredPoint, kMaxBodyContacts> stored_points_;
  std::size_t stored_point_count_ = 0;
  bool bounces_ = false;  // a point of this step
  int bounce_rounds_ = 0;
  Stage stage_ = Stage::kPrepare;
  std::size_t at_ = 0;  // the next patch of the stage
  int iteration_ = 0;
  float change_m_s_ = 0.0F;  // the largest of the iteration
};

}  // namespace thimble::control
