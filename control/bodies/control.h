// A control of one degree of freedom (paper, section 3.9: sliders, buttons, knobs, switches): the dynamics of its
// coordinate q, in m along its axis (Slide) or in rad about it (Turn), 0 where the scene starts. Bodies calls
// advance_control() once a tick for each body that slides or turns, and places the body by q.
//
//   inertia q'' = effort + control_effort(q) - damping q' - friction sign(q'),   low <= q <= high
//
// The sign of an effort is that of the coordinate it drives. Units of an effort: N for a slide, N m for a turn; of a
// stiffness N/m or N m/rad; of damping N s/m or N m s/rad; of inertia kg or kg m^2.
#pragma once

#include <span>

#include "control/scene/limits.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

struct ControlParams {
  float stiffness = 0.0F;  // spring to `rest`
  float rest = 0.0F;
  float damping = 0.0F;
  float friction = 0.0F;      // Coulomb: holds up to this effort, resists motion with it
  float low = -kMaxTurn_rad;  // stops
  float high = kMaxTurn_rad;
  float restitution = 0.0F;  // of the stops
  // -detent_effort sin(2 pi (q - detent_phase) / detent_pitch): it rests at detent_phase + n detent_pitch. Pitch 0: none.
  float detent_pitch = 0.0F;
  float detent_phase = 0.0F;
  float detent_effort = 0.0F;
  // What pressing towards +q meets: -effort, linear between the points and constant beyond the first and last.
  std::span<const scene::CurvePoint> curve{};
  // The switch goes on where q passes on_at and off where it passes off_at back. A switch that goes on downwards has
  // on_at < off_at.
  bool has_switch = false;
  float on_at = 0.0F;
  float off_at = 0.0F;
};

struct ControlState {
  float q = 0.0F;
  float carry = 0.0F;  // what rounding has kept back from q so far
  float speed = 0.0F;
  bool on = false;
};

// From a checked image: the control of the body and its restitution; a body without a control is free between the
// widest stops, on the spring and damper that it has. The curve stays in the image.
[[nodiscard]] ControlParams control_params(const scene::Body& body) noexcept;

// Of a body that slides: its mass; of one that turns: its moment of inertia about the axis through pivot_m.
[[nodiscard]] float control_inertia(const scene::Object& object) noexcept;

// The effort on q of everything that has a potential: spring, detents and curve. At most kMaxCurvePoints steps.
[[nodiscard]] float control_effort(const ControlParams& params, float q) noexcept;

// At q = 0 with this speed, its switch as that place has it.
[[nodiscard]] ControlState start_control(const ControlParams& params, float speed = 0.0F) noexcept;

// One period under `effort` from outside (the tips, gravity), taken at the beginning of the period. inertia > 0.
void advance_control(const ControlParams& params, ControlState& state, float effort, float inertia,
                     float period_s) noexcept;

}  // namespace thimble::control
