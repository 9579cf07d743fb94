// The renderer: positions of fingertips in, forces out. The firmware calls this class every tick; a host
// program can link it (target thimble_control, example in tests/bench).
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
#include "control/effort.h"
#include "control/fields/fields.h"
#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "control/solids/near_triangles.h"
#include "kinematics/vector.h"

namespace thimble::control {

class Renderer {
 public:
  // Binds a scene (an empty view: free space everywhere). All contacts end: each god object starts at its tip. kKeepPlaces: one in contact
  // starts just off the surface that it was on; the tip is inside of what is there (control/contact/inside.h). A moving object that starts
  // as one of the last scene did goes on from where that is, and a volume keeps its state if the last scene had one of its kind and pose.
  // kKeepState: the same scene with other materials; contacts, moving objects and volumes keep their state.
  [[gnu::cold]] void bind(const SceneView& scene, Binding binding = Binding::kStart) noexcept;

  // Ends all contacts, as after a pause in which the tips were not rendered. Moving objects keep their poses.
  [[gnu::cold]] void reset() noexcept;

  // Ends the contacts of one arm: its tip was put somewhere else.
  [[gnu::cold]] void reset(std::size_t arm) noexcept;

  // Renders one period. tips and touches have the same size, at most kMaxArms. Afterwards the moving objects
  // move under the forces of this period.
  void tick(std::span<const Tip> tips, float period_s, std::span<Touch> touches) noexcept;

  // The work that a tick may do, in the units of control/work.h, from the next tick on: half of it is kept for bodies if there are any.
  // Without a call there is no bound.
  void bound_work(std::uint32_t units) noexcept;

  // The force fields of this trial act from the next tick on, and no longer those of another one. 0: those of none.
  void set_trial(std::uint8_t trial) noexcept { fields_.set_trial(trial); }

  // The units that the last tick has done: where there are bodies, at most kMostBodyStepWork more than it may.
  [[nodiscard]] std::uint32_t tick_work() const noexcept { return work_ - left_ + effort_.work.over(); }
  // What the last tick has done, for those who estimate what it takes on a board (board/sim/tick_cost.h).
  struct Load {
    std::uint32_t finger_units, body_units;  // tick_work()
    std::uint32_t awake;                     // bodies
    std::size_t solids, volumes;             // of the scene
    bool shaded;                             // it has shaded meshes
  };
  [[nodiscard]] Load load() const noexcept;
  // Whether the bodies' clock stood in the last tick, because their step takes more work than a tick has (control/bodies/bodies.h).
  [[nodiscard]] bool bodies_wait() const noexcept { return bodies_.wait(); }

  // For the test that compares the two paths: until the next bind(), no tick takes the fast path for one
  // plain surface.
  void use_general_path_only() noexcept;

  // For the tests of what is kept from tick to tick and changes no bit: no triangles (TriangleCache), and no free space
  // (contact/free_flight.h).
  void keep_nothing() noexcept { keeps_ = false; }

  [[nodiscard]] RenderCounters counters() const noexcept;
  [[nodiscard]] bool is_put_off() const noexcept { return put_off_; }  // something, in the last tick

  // The moving objects in the order of the scene, with their poses for the next tick.
  [[nodiscard]] std::span<const BodyState> bodies() const noexcept { return bodies_.states(); }

  // For tests: the centre of the ball that the god object is where several solids are near (contact/ball.h), else the
  // god object itself.
  [[nodiscard]] const Vec3& ball_centre_m(std::size_t arm) const noexcept {
    const GodObject& god = fingers_[arm].god;
    return god.is_ball ? god.centre_m : god.position_m;
  }

  // Writes the unit normals of the planes that the god object of an arm lies on, world frame; returns how
  // many.
  std::size_t contact_normals(std::size_t arm, std::span<Vec3, kMaxContacts> normals) const noexcept {
    return control::contact_normals(world_, fingers_[arm].god, normals);
  }

  // The objects that the tip of an arm began inside of and has not left (control/contact/inside.h): bit i is object i of
  // the scene image. They are not felt.
  [[nodiscard]] std::uint64_t inside(std::size_t arm) const noexcept {
    return fingers_[arm].inside == 0 ? 0 : inside_in_image(fingers_[arm].inside);
  }

  // Writes the state of needles and fingers in tissue; returns how many there are.
  std::size_t tissue_views(TissueViews& views) const noexcept { return fields_.show(views); }

 private:
  [[gnu::cold]] void reset_fingers() noexcept;
  [[nodiscard]] std::uint64_t inside_in_image(SolidSet inside) const noexcept;
  [[gnu::cold]] void count_put_off() noexcept;
  void touch(Finger& finger, const Tip& tip, float period_s, TriangleCache* triangles, Effort& effort,
             Touch& touch) noexcept;

  World world_;
  Fields fields_;
  Bodies bodies_;
  std::array<Finger, kMaxArms> fingers_;
  std::array<TriangleCache, kMaxArms> triangles_;  // of the fingers
  Effort effort_;
  std::uint32_t work_ = Work::kNoBound;
  std::array<Work, kMaxArms> arm_work_{};      // of each, by the number of arms
  std::uint32_t left_ = Work::kNoBound;        // of the last tick
  std::uint32_t body_work_ = 0;                // in it
  std::uint32_t least_left_ = Work::kNoBound;  // of a tick, since bind()
  std::uint32_t most_over_ = 0;                // of bodies (Work::over())
  bool put_off_ = false;                       // in this tick
  bool keeps_ = true;
};

}  // namespace thimble::control
