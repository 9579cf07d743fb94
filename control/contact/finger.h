// All that the renderer remembers of one fingertip between two ticks.
#pragma once

#include "control/contact/energy_account.h"
#include "control/contact/friction.h"
#include "control/contact/god_object.h"
#include "control/surfaces/click.h"
#include "kinematics/vector.h"

namespace thimble::control {

// Where on a moving object the god object stands, in that object's frame. Carried along tick by tick, a point in the world would
// drift over the surface by its rounding; as long as it is where it was carried to, this is where it is.
struct Anchor {
  std::uint8_t object = 0;
  Vec3 local_m = Vec3::Zero();
  Vec3 world_m = Vec3::Zero();
  bool holds = false;
};

// Starts free, at the tip, in the first tick after Renderer::bind() or reset().
struct Finger {
  bool started = false;
  GodObject god;   // with friction: the stiction point
  GodObject rest;  // where it would be without
  Friction friction;
  ContactClick click;
  EnergyAccount account;
  Anchor anchor;
};

}  // namespace thimble::control
