// The state of one fingertip that the renderer keeps from tick to tick.
#pragma once

#include <limits>

#include "control/contact/clearance.h"
#include "control/contact/energy_account.h"
#include "control/contact/friction.h"
#include "control/contact/god_object.h"
#include "control/contact/inside.h"
#include "control/contact/planes.h"
#include "control/contact/potential.h"
#include "control/contact/shading.h"
#include "control/surfaces/click.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The place of the god object on a moving object, in that object's frame. A world point that is carried along
// tick by tick would drift over the surface by rounding. As long as the god object is at world_m, its place
// on the object is local_m.
struct Anchor {
  std::uint8_t object = 0;
  Vec3 local_m = Vec3::Zero();
  Vec3 world_m = Vec3::Zero();
  bool holds = false;
};

// In the first tick after Renderer::bind() or reset() the god object starts without contact: at the tip, or where it was in another scene.
struct Finger {
  bool started = false;
  bool starts_at_god = false;  // else at the tip
  GodObject god;               // with friction: the stiction point
  GodObject rest;              // where it would be without friction
  Resting resting;
  Friction friction;
  ContactClick click;
  ContactPotential potential;
  EnergyAccount account;
  ShadedForce shaded;
  Anchor anchor;
  Clearance clearance;
  Clearance open;                     // of all objects, while the god object is free (contact/free_flight.h)
  SolidSet inside = 0;                // not felt: the tip began inside them, and has not left them
  std::uint8_t look_inside_from = 0;  // the object of the world that is looked at first
  std::uint8_t stuck =
      0;  // ticks in turn whose work was spent, and in which the stiction point has not moved
  // The god object goes no farther towards the tip in a tick: less than the whole way where the work did not suffice for that.
  float leash_m = std::numeric_limits<float>::infinity();
  bool look_inside_first = false;  // the work of the last tick has not sufficed to look at all of them
};

}  // namespace thimble::control
