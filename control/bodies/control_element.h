// A control element with one degree of freedom (paper, section 3.9: sliders, buttons, knobs, switches): the
// dynamics of its coordinate q, in m along its axis (Slide) or in rad about it (Turn), 0 where the scene
// starts. Bodies calls advance_control_element() once a tick for each body that slides or turns, and places the body
// by q.
//
//   inertia q'' = effort + control_element_effort(q) - damping q' - friction sign(q'),   low <= q <= high
//
// A positive effort drives q upwards. Units of an effort: N for a slide, N m for a turn; of a
// stiffness N/m or N m/rad; of damping N s/m or N m s/rad; of inertia kg or kg m^2.
#pragma once

#include <span>

#include "control/scene/limits.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

struct ControlElementParams {
  float stiffness = 0.0F;  // spring to `rest`
  float rest = 0.0F;
  float damping = 0.0F;
  float friction = 0.0F;      // Coulomb: sticks up to this effort, resists motion with it
  float low = -kMaxTurn_rad;  // stops
  float high = kMaxTurn_rad;
  float restitution = 0.0F;  // of the stops
  // -detent_effort sin(2 pi (q - detent_phase) / detent_pitch): stable at detent_phase + n detent_pitch.
  // Pitch 0: none.
  float detent_pitch = 0.0F;
  float detent_phase = 0.0F;
  float detent_effort = 0.0F;
  // The resistance to pressing towards +q, which is -effort: linear between the points, constant beyond the
  // first and last.
  std::span<const scene::CurvePoint> curve{};
  // The switch turns on when q passes on_at, and off when q passes off_at in the other direction. on_at <
  // off_at: it turns on downwards.
  bool has_switch = false;
  float on_at = 0.0F;
  float off_at = 0.0F;
};

struct ControlElementState {
  float q = 0.0F;
  float carry = 0.0F;  // the accumulated rounding error of q
  float speed = 0.0F;
  bool on = false;
};

// From a checked image: the control element of the body and its restitution. A body without one is free
// between the widest stops, with its own spring and damper. The curve stays in the image.
[[nodiscard]] ControlElementParams control_element_params(const scene::Body& body) noexcept;

// For Slide the mass of the body, for Turn its moment of inertia about the axis through pivot_m.
[[nodiscard]] float control_element_inertia(const scene::Object& object) noexcept;

// The effort on q of spring, detents and curve, which have a potential. At most kMaxCurvePoints steps.
[[nodiscard]] float control_element_effort(const ControlElementParams& params, float q) noexcept;

// At q = 0 with this speed; the switch is set for q = 0.
[[nodiscard]] ControlElementState start_control_element(const ControlElementParams& params,
                                                        float speed = 0.0F) noexcept;

// Whether friction holds it where it is in such a period.
[[nodiscard]] bool is_held_by_friction(const ControlElementParams& params, const ControlElementState& state,
                                       float effort, float inertia, float period_s) noexcept;

// One period under the external `effort` (tips, gravity) at the beginning of the period. inertia > 0.
void advance_control_element(const ControlElementParams& params, ControlElementState& state, float effort,
                             float inertia, float period_s) noexcept;

}  // namespace thimble::control
