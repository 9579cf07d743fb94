// Objects that move (paper, section 3.9): masses that fingers push, throw and pick up.
//
// Each tick, after the fingers are rendered: every finger's force acts on what it touches, at its god object, exactly opposite to
// what the hand feels; velocities are advanced with gravity, spring and damping; contacts between objects change them
// (control/bodies/contact_solver.h); each object moves in its turn and takes the god objects along (control/bodies/carry.h).
//
// Speeds are at most kMaxBodySpeed_m_s and kMaxBodySpin_rad_s, positions within kMaxCoordinate_m. An object that would squeeze a
// god object against something stays where it was and stops: a fingertip is a point that gives way to the hand's spring alone.
// SI units, world frame. Nothing here allocates or fails.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bodies/contact_solver.h"
#include "control/bodies/control.h"
#include "control/contact/finger.h"
#include "control/contact/world.h"
#include "control/renderer_types.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "kinematics/vector.h"

namespace thimble::control {

// What telemetry and a viewer see of a moving object. `object` counts the objects of the scene image.
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

// What the scene says of one body.
struct BodyModel {
  std::uint8_t object = 0;  // in the world
  scene::Motion motion{};
  float mass_kg = 1.0F;
  Vec3 inertia_kg_m2 = Vec3::Ones();  // in the object's frame
  ControlParams control;              // Slide, Turn
  float control_inertia = 1.0F;       // kg or kg m2
  float restitution = 0.0F;
  float spring_N_m = 0.0F;
  float damping_N_s_m = 0.0F;
  float angular_damping_N_m_s = 0.0F;
  Vec3 axis = Vec3::UnitZ();
  Vec3 pivot_m = Vec3::Zero();
  Vec3 start_m = Vec3::Zero();
  Eigen::Quaternionf start_rotation = Eigen::Quaternionf::Identity();
};

class Bodies {
 public:
  // Takes the scene's bodies to their start. World is bound already; its objects learn which body they are.
  void bind(const SceneView& scene, World& world) noexcept;
  void go_on(const SceneView& scene) noexcept;  // Binding::kGoOn: they stay where they are, and as fast

  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  [[nodiscard]] std::span<const BodyState> states() const noexcept { return {states_.data(), count_}; }

  // The velocity of a body's material at a point of the world.
  [[nodiscard]] Vec3 velocity_at(std::uint8_t body, const Vec3& point_m) const noexcept {
    const BodyState& state = states_[body];
    return state.velocity_m_s + state.spin_rad_s.cross(point_m - state.position_m);
  }

  // A force on a body at a point of the world, for the next step.
  void push(std::uint8_t body, const Vec3& point_m, const Vec3& force_N) noexcept {
    Load& load = loads_[body];
    load.force_N += force_N;
    load.torque_N_m += (point_m - states_[body].position_m).cross(force_N);
  }

  // One period: the objects go on, the world has their new poses, and the fingers have been taken along.
  void step(World& world, std::span<Finger> fingers, float period_s, RenderCounters& counters) noexcept;

 private:
  struct Load {
    Vec3 force_N = Vec3::Zero();
    Vec3 torque_N_m = Vec3::Zero();  // about the object's origin
  };

  [[nodiscard]] Mover accelerate(std::size_t body, float period_s) noexcept;
  void take_over(std::size_t body, const Vec3& velocity_before_m_s, const Vec3& spin_before_rad_s,
                 const Mover& after, float period_s) noexcept;
  void limit_speed(std::size_t body) noexcept;
  void advance(std::size_t body, float period_s) noexcept;
  void advance_along_axis(std::size_t body, float period_s) noexcept;
  void stop(std::size_t body) noexcept;

  Vec3 gravity_m_s2_ = Vec3::Zero();
  std::array<BodyModel, kMaxBodies> models_;
  std::array<BodyState, kMaxBodies> states_;
  std::array<Vec3, kMaxBodies> angular_momentum_;  // Free, kg m2/s: what a top keeps
  std::array<ControlState, kMaxBodies> controls_;  // Slide, Turn
  std::array<Load, kMaxBodies> loads_;
  std::array<float, kMaxBodies> efforts_;  // Slide, Turn: N or N m of this tick
  std::size_t count_ = 0;
  ContactSolver solver_;
};

}  // namespace thimble::control
