// Bodies: objects that fingertips push, throw and pick up (paper, section 3.9).
//
// Each tick, after the fingertips are rendered: the force on each fingertip acts on the body in contact with
// the opposite sign, at the god object. Then gravity, springs and damping change the velocities, the contacts
// between bodies change them (control/bodies/contact_solver.h), and the bodies move one after the other and
// carry the god objects along (control/bodies/carry.h).
//
// Speeds are at most kMaxBodySpeed_m_s, positions within kMaxCoordinate_m. The spin of a free body is at most what moves
// its surface with kMaxBodySpeed_m_s: at least kMaxBodySpin_rad_s, at most kMaxSmallBodySpin_rad_s. A body that
// would squeeze a god object against another object keeps its pose, because a god object has no room to give way; an
// impulse at the god object ends the approach of the two, so that nothing else of their momentum changes. SI units, world frame. Nothing here allocates or fails.
//
// A step of the bodies takes one tick where the tick's work suffices (control/work.h), and else as many as it needs
// (control/bodies/body_step.cpp): what tissue pushes is found, the contacts are searched for, then the velocities are solved, then the bodies move, and each of
// these goes on in the next tick where the work of this one ended. Until then the bodies' clock stands: they keep their poses and velocities, and forces
// on them have no effect. Only the forces of the tick in which the search ends act, for one period, so no impulse is made up; and what feels a
// body's velocity feels the one with which it moves in the ticks that go by (velocity_at()). A tick does at least one step of what is to do, so it takes at
// most kMostBodyStepWork more than it may, and all is done in the end with any work but none.
//
// Bodies that are near each other and lie still sleep together (control/bodies/sleep.cpp): they keep their poses, and cost nothing until a
// fingertip or tissue pushes one of them, an awake body comes near, or the scene gets other materials. They wake before the step of that
// tick, so a hand feels no difference.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/carry.h"
#include "control/bodies/contact_solver.h"
#include "control/bodies/control_element.h"
#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/effort.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "kinematics/vector.h"

namespace thimble::control {

// The state of a body for telemetry and the viewer. `object`: its index in the scene image.
struct BodyState {
  std::uint8_t object = 0;
  Vec3 position_m = Vec3::Zero();
  Eigen::Quaternionf rotation = Eigen::Quaternionf::Identity();
  Vec3 velocity_m_s = Vec3::Zero();  // of the object's origin
  Vec3 spin_rad_s = Vec3::Zero();
  bool controlled = false;  // slides or turns, by the coordinate q
  float q = 0.0F;           // of a body that slides (m) or turns (rad), 0 at the start
  bool on = false;          // the switch of a control
};

using BodySet = std::uint16_t;  // bit i: body i
static_assert(kMaxBodies <= 16);
[[nodiscard]] constexpr BodySet of_body(std::size_t i) noexcept { return static_cast<BodySet>(1U << i); }

// Where a body is at the start, and along or about what it moves.
struct BodyStart {
  Vec3 axis = Vec3::UnitZ();
  Vec3 pivot_m = Vec3::Zero();
  Vec3 start_m = Vec3::Zero();  // of the centre of mass
  Eigen::Quaternionf start_rotation = Eigen::Quaternionf::Identity();
};

static_assert(sizeof(BodyStart) == 13 * sizeof(float));  // no padding: two are compared byte by byte

// The constant values of a body, from the scene.
struct BodyModel : BodyStart {
  std::uint8_t object = 0;  // in the world
  scene::Motion motion{};
  bool even = true;  // the principal moments are equal
  float mass_kg = 1.0F;
  Vec3 centre_m = Vec3::Zero();       // of mass, in the object's frame
  Vec3 inertia_kg_m2 = Vec3::Ones();  // principal moments, about the centre of mass
  Eigen::Quaternionf principal_axes = Eigen::Quaternionf::Identity();  // in the object's frame
  ControlElementParams control;                                        // Slide, Turn
  float control_inertia = 1.0F;                                        // kg or kg m2
  float restitution = 0.0F;
  float max_spin_rad_s = kMaxBodySpin_rad_s;  // of a free body
  float reach_m = 0.0F;                       // of the surface from the centre of mass, or from the pivot
  float spring_N_m = 0.0F;
  float damping_N_s_m = 0.0F;
  float angular_damping_N_m_s = 0.0F;
};

// The most that one step of the search, of the solver or of the move takes beyond the work that is left: what all of them do at least.
inline constexpr std::uint32_t kMostBodyStepWork = 500;

class Bodies {
 public:
  [[gnu::cold]] Bodies() noexcept;

  // Sets the scene's bodies to their start; with Binding::kKeepPlaces one that starts as a body of the last scene did goes on from where
  // that is, if the new stops let it. The world is bound already; each of its objects gets the index of its body.
  [[gnu::cold]] void bind(const SceneView& scene, Binding binding, World& world) noexcept;
  // Binding::kKeepState: poses and velocities stay.
  [[gnu::cold]] void apply_materials(const SceneView& scene) noexcept;

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] std::span<const BodyState> states() const noexcept { return {states_.data(), count_}; }

  [[nodiscard]] BodySet asleep() const noexcept { return asleep_; }

  // Whether the last step() has not ended: the bodies, or some of them, have not moved.
  [[nodiscard]] bool wait() const noexcept { return stage_ != Stage::kBegin; }

  // The velocity of a body's material at a point of the world, in the time of the ticks: slower than the body's own where a step takes several.
  [[nodiscard]] Vec3 velocity_at(std::uint8_t body, const Vec3& point_m) const noexcept {
    return pace_ * speed_at(body, point_m);
  }

  // The same in the time of the bodies.
  [[nodiscard]] Vec3 speed_at(std::uint8_t body, const Vec3& point_m) const noexcept {
    const Centre& centre = centres_[body];
    return centre.velocity_m_s + states_[body].spin_rad_s.cross(point_m - centre.position_m);
  }

  // A force on a body at a point of the world, for the next step().
  void push(std::uint8_t body, const Vec3& point_m, const Vec3& force_N) noexcept {
    add(loads_[body], body, point_m, force_N);
    pushed_ |= of_body(body);
  }

  // A force on a body that depends on nothing but the bodies: for the whole step that begins next, or waits to begin (step()).
  void press_on(std::uint8_t body, const Vec3& point_m, const Vec3& force_N) noexcept {
    add(pressing_[body], body, point_m, force_N);
    pressed_ |= of_body(body);
  }

  // A fingertip on a body, for the next step. It resists the spin of free bodies only: round a dial the hand turns with it.
  void grip(const Grip& grip) noexcept {
    if (models_[grip.body].motion == scene::Motion::Free && grip_count_ < grips_.size())
      grips_[grip_count_++] = grip;
  }

  // The mass that a force along `direction`, a unit vector, meets at a point of the body; 0 where it cannot move.
  [[nodiscard]] float mass_at(std::uint8_t body, const Vec3& point_m, const Vec3& direction) const noexcept;

  // One period: moves the bodies, writes their new poses to the world, and carries the fingers' god objects along; or as much of that as
  // the work suffices for. A step begins when all of press_on() is known.
  void step(World& world, std::span<Finger> fingers, float period_s, bool all_pressed,
            Effort& effort) noexcept;

 private:
  struct Load {
    Vec3 force_N = Vec3::Zero();
    Vec3 torque_N_m = Vec3::Zero();  // about the centre of mass
  };
  struct Centre {  // of mass
    Vec3 position_m = Vec3::Zero();
    Vec3 velocity_m_s = Vec3::Zero();
  };

  struct Last;  // a body of the scene before

  struct CarriedPart {  // of a finger: what carry() changes
    GodObject god;
    GodObject rest;
    Anchor anchor;
  };
  struct Before {  // of what a move changes, to take it back
    BodyState state;
    Centre centre;
    Vec3 angular_momentum;
    ControlElementState control;
    float effort;
  };

  void add(Load& load, std::uint8_t body, const Vec3& point_m, const Vec3& force_N) const noexcept {
    load.force_N += force_N;
    load.torque_N_m += (point_m - centres_[body].position_m).cross(force_N);
  }
  [[gnu::cold]] void go_on_from(std::size_t i, const Last& last, std::uint8_t in_image,
                                PlacedObject& object) noexcept;
  [[gnu::cold]] void start(std::size_t i, const scene::Body& body, const Vec3& position_m) noexcept;
  [[nodiscard]] bool begin(const World& world, float period_s, Work& work) noexcept;
  void begin_anew() noexcept;
  void accelerate(std::size_t body, const Load& load, float period_s) noexcept;
  void accelerate_all(float period_s) noexcept;
  [[nodiscard]] Load searched_load(std::size_t body, float period_s) const noexcept;
  [[nodiscard]] bool go_on(World& world, std::span<Finger> fingers, float period_s, Effort& effort) noexcept;
  [[nodiscard]] bool move(World& world, std::span<Finger> fingers, float period_s, bool whole_tick,
                          Effort& effort) noexcept;
  [[nodiscard]] bool move_body(std::size_t body, World& world, std::span<Finger> fingers, float period_s,
                               bool may_wait, Effort& effort) noexcept;
  void apply_contacts(std::size_t body, float period_s) noexcept;
  void wake(BodySet bodies) noexcept;
  void wake_touched(const World& world, float period_s, Work& work) noexcept;
  void let_sleep(const World& world, float period_s) noexcept;
  [[nodiscard]] bool is_still(std::size_t body) const noexcept;
  void limit_speed(std::size_t body, float period_s) noexcept;
  void advance(std::size_t body, float period_s) noexcept;
  void advance_along_axis(std::size_t body, float period_s) noexcept;
  void place(std::size_t body, PlacedObject& object) noexcept;
  void stop(std::size_t body) noexcept;
  void apply_impulse(std::size_t body, const Vec3& point_m, const Vec3& impulse_N_s) noexcept;
  void press(const World& world, std::size_t body, const Pin& pin) noexcept;

  Vec3 gravity_m_s2_ = Vec3::Zero();
  std::array<BodyModel, kMaxBodies> models_;
  std::array<BodyState, kMaxBodies> states_;
  std::array<Centre, kMaxBodies> centres_;
  std::array<Vec3, kMaxBodies> angular_momentum_;         // Free, kg m2/s: conserved while no torque acts
  std::array<ControlElementState, kMaxBodies> controls_;  // Slide, Turn
  std::array<Load, kMaxBodies> loads_;                    // of this tick
  std::array<float, kMaxBodies> efforts_;                 // Slide, Turn: N or N m of this step
  std::size_t count_ = 0;
  std::array<Grip, kMaxArms * kMaxContacts> grips_;
  std::size_t grip_count_ = 0;
  ContactSolver solver_;

  // Of the step that is going on.
  enum class Stage : std::uint8_t { kBegin, kPress, kSearch, kSolve, kMove };
  Stage stage_ = Stage::kBegin;
  std::uint32_t ticks_ = 0;                      // that it has taken
  float pace_ = 1.0F;                            // one over the ticks that a step takes
  std::array<Load, kMaxBodies> pressing_;        // press_on()
  BodySet pressed_ = 0;                          // by that
  std::array<Load, kMaxBodies> searched_loads_;  // with which its search began
  std::array<SolverBody, kMaxBodies> solver_bodies_;
  std::array<Vec3, kMaxBodies> accelerated_momentum_;  // Free: angular
  std::size_t moved_ = 0;                              // of the bodies

  BodySet pushed_ = 0;  // in this tick
  BodySet asleep_ = 0;
  std::array<BodySet, kMaxBodies> islands_{};  // of those asleep: that sleep and wake together
  std::array<float, kMaxBodies> still_s_{};    // for how long

  std::array<CarriedPart, kMaxArms - 1> fingers_before_;  // the move of a body: all but the last one

  std::array<Pin, kMaxBodies> pins_;
  std::array<bool, kMaxBodies> pinned_{};
};

}  // namespace thimble::control
