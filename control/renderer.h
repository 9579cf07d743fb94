// The renderer: fingertips in, forces out. The class the firmware calls every tick, and the one to link for a
// host program (target thimble_control; tests/bench shows its use).
//
//   Renderer renderer;
//   SceneView scene;
//   if (SceneView::check(image_bytes, scene) != ImageStatus::kOk) { ... }   // once, in the background: O(image)
//   renderer.bind(scene);                                                   // at a tick boundary: O(objects)
//   renderer.tick(tips, period_s, touches);                                 // every tick: no heap, lock, throw, I/O
//
// Units: m, m/s, N, s. World frame: +x to the user's right, +y away from the user, +z up. Force is what the
// device exerts on the hand. Source: Salisbury et al. 1995, sections 3 and 4; Zilles and Salisbury 1995 (god
// object).
#pragma once

#include <array>
#include <span>

#include "control/bodies/bodies.h"
#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/fields/fields.h"
#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "kinematics/vector.h"

namespace thimble::control {

class Renderer {
 public:
  // Takes a scene (an empty view: free space everywhere). Every contact is forgotten: each god object starts
  // at its tip.
  // kGoOn: the same scene in other materials; contacts, objects that move and tissue stay as they are.
  void bind(const SceneView& scene, Binding binding = Binding::kStart) noexcept;

  // Forgets every contact, as after a pause in which the tips were not rendered. Objects that move stay where they are.
  void reset() noexcept;

  // Renders one period. tips and touches have the same size, at most kMaxArms. Objects that move do so afterwards, with the forces
  // of this period.
  void tick(std::span<const Tip> tips, float period_s, std::span<Touch> touches) noexcept;

  // For the test that compares the two paths: until the next bind(), no tick takes the fast path for one plain surface.
  void use_general_path_only() noexcept;

  [[nodiscard]] const RenderCounters& counters() const noexcept { return counters_; }

  // The objects that move, in the order of the scene, where the next tick will meet them.
  [[nodiscard]] std::span<const BodyState> bodies() const noexcept { return bodies_.states(); }

  // The planes that the god object of an arm lies on: their unit normals, world frame; returns how many.
  std::size_t show_planes(std::size_t arm, std::span<Vec3, kMaxContacts> normals) const noexcept {
    return lies_on(world_, fingers_[arm].god, normals);
  }

  // Needles and fingers in tissue; returns how many.
  std::size_t show_tissue(TissueViews& views) const noexcept { return fields_.show(views); }

 private:
  void touch(Finger& finger, const Tip& tip, float period_s, Touch& touch) noexcept;

  World world_;
  Fields fields_;
  Bodies bodies_;
  std::array<Finger, kMaxArms> fingers_;
  RenderCounters counters_;
};

}  // namespace thimble::control
