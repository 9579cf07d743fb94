// Force shading: on a mesh with corner normals the force turns as on the smooth surface that the mesh stands for.
//
// The god object moves in two passes (Ruspini et al. 1997): the plane with the interpolated normal, then the true surface.
// Where that has no unique answer (at a crease, or where the tip is as deep as the surface is round), the place and the
// normal jump from tick to tick. So the force follows them no faster than the tip moves.
#pragma once

#include <cstdint>

#include "control/contact/god_object.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Moves a frictionless god object that rests on one shaded mesh to its place on the smooth surface, and makes that plane its
// constraint. Returns false, and leaves `rest` and `held`, where there is no such plane: on its way it may have come to
// another solid, and the two must belong to the same one.
bool shade(const World& world, const Nearby& nearby, GodObject& rest, const Vec3& tip, Constraints& held,
           Effort& effort) noexcept;

// The force of a contact's springs in a scene with shaded meshes. On a shaded mesh, and after it until the force is what the
// springs ask for, its change per tick is at most kFastest times the stiffness times the tip's motion.
// Places and forces are in the world frame. `frame` is an object whose body the contact moves with: motion is relative to it.
class ShadedForce {
 public:
  // Once a tick in contact. spring_N: what the springs ask for. stiffest_N_m, mean_N_m: of what holds the god
  // object. shaded: a shaded mesh is one of those that hold it. Returns the force.
  Vec3 follow(const PlacedObject& frame, const Vec3& tip_m, const Vec3& spring_N, float stiffest_N_m,
              float mean_N_m, bool shaded) noexcept;

  // After follow(), where the stiction point slips. Returns the change of the force. by_N: what the springs ask for.
  // breaks_N: how much of it may come at once, as friction breaks. A slip adds no force.
  Vec3 slip(const PlacedObject& frame, const Vec3& by_N, float breaks_N) noexcept;

  // After follow(): what the effects of surfaces add to the springs' force changes by at most kEffects times the stiffness times the
  // motion. The shaded place can jump, and the texture with it. Returns the change of by_N.
  Vec3 effect(const PlacedObject& frame, const Vec3& by_N) noexcept;
  [[nodiscard]] bool has_effect() const noexcept { return open_ && has_effect_; }

  // For the energy in the springs: their mean stiffness, which changes no faster than the force.
  [[nodiscard]] float mean_N_m() const noexcept { return mean_N_m_; }
  // Whether this tick's force is bound to the last one's.
  [[nodiscard]] bool bound() const noexcept { return open_ && bound_; }
  // Shading took part in this contact: on a shaded mesh now or before.
  [[nodiscard]] bool took_part() const noexcept { return open_ && took_part_; }
  // Whether the next tick's force is bound to this one's.
  [[nodiscard]] bool binds() const noexcept { return open_ && (shaded_ || behind_); }

  void end() noexcept { open_ = false; }

 private:
  static constexpr float kFastest = 1.4F;
  static constexpr float kEffects =
      4.0F;  // a texture's own slopes need less, unless they are steeper than 45 degrees

  Vec3 change_to(const Vec3& force_N, float most_N) noexcept;

  bool open_ = false;
  bool shaded_ = false;
  bool took_part_ = false;
  bool bound_ = false;  // in this tick
  bool behind_ = false;
  bool has_effect_ = false;
  std::uint8_t body_ = 0;
  float stiffest_N_m_ = 0.0F;
  float mean_N_m_ = 0.0F;
  float most_N_ = 0.0F;
  // In the frame of body_, or in the world's for kNoBody.
  Vec3 tip_m_ = Vec3::Zero();
  Vec3 before_N_ = Vec3::Zero();  // of the last tick
  Vec3 force_N_ = Vec3::Zero();
  Vec3 effect_N_ = Vec3::Zero();
};

}  // namespace thimble::control
