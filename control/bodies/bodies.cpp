#include "control/bodies/bodies.h"

#include <algorithm>
#include <cstring>
#include <numbers>

#include "kinematics/trig.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

using Eigen::Quaternionf;

// A rotation in one tick is integrated, and swept against the god objects, as a small one.
constexpr float kMaxTurnPerTick_rad = 0.25F;

BodyModel read(const scene::Object& object, std::uint8_t index) {
  const scene::Body& body = *object.body();
  BodyModel model;
  model.object = index;
  model.motion = body.motion();
  model.mass_kg = body.mass_kg();
  model.restitution = body.restitution();
  model.inertia_kg_m2 = to_vec(*body.inertia_kg_m2());
  model.even = (model.inertia_kg_m2.array() == model.inertia_kg_m2.x()).all();
  model.spring_N_m = body.spring_n_per_m();
  model.damping_N_s_m = body.damping_n_s_per_m();
  model.angular_damping_N_m_s = body.angular_damping_n_m_s();
  model.axis = to_vec(*body.axis());
  model.pivot_m = to_vec(*body.pivot_m());
  model.start_rotation = to_rotation(object.pose()->rotation());
  if (body.centre_m() != nullptr) model.centre_m = to_vec(*body.centre_m());
  if (body.principal_axes() != nullptr) model.principal_axes = to_rotation(*body.principal_axes());
  model.start_m = to_vec(object.pose()->position_m()) + model.start_rotation * model.centre_m;
  model.control = control_element_params(body);
  model.control_inertia = control_element_inertia(object);
  return model;
}

// Scales along the principal axes of a body; an even one has no others.
Vec3 scale(const BodyModel& model, const Quaternionf& rotation, const Vec3& by, const Vec3& v) {
  if (model.even) return by.x() * v;
  const Quaternionf axes = rotation * model.principal_axes;
  return axes * by.cwiseProduct(axes.conjugate() * v).eval();
}

Vec3 to_spin(const BodyModel& model, const Quaternionf& rotation, const Vec3& momentum) {
  return scale(model, rotation, model.inertia_kg_m2.cwiseInverse(), momentum);
}

Vec3 to_momentum(const BodyModel& model, const Quaternionf& rotation, const Vec3& spin) {
  return scale(model, rotation, model.inertia_kg_m2, spin);
}

// Alike along all axes. By its elements: a loop over so few becomes a call of memset.
Mat3 all_axes(float x) {
  Mat3 m;
  m << x, 0.0F, 0.0F, 0.0F, x, 0.0F, 0.0F, 0.0F, x;
  return m;
}

Mat3 inverse_inertia(const BodyModel& model, const Quaternionf& rotation) {
  const Vec3 inverse = model.inertia_kg_m2.cwiseInverse();
  if (model.even) return all_axes(inverse.x());
  const Mat3 axes = (rotation * model.principal_axes).toRotationMatrix();
  return axes * inverse.asDiagonal() * axes.transpose();
}

Quaternionf turned(const Quaternionf& rotation, const Vec3& by) {
  const Vec3 half = 0.5F * by;
  return (Quaternionf(1.0F, half.x(), half.y(), half.z()) * rotation).normalized();
}

Vec3 limited(const Vec3& v, float most) {
  const float length2 = v.squaredNorm();
  return length2 > most * most ? Vec3(v * (most / std::sqrt(length2))) : v;
}

// As bytes, because a scene is bound seldom: for the vectors of Eigen it is half as much code as element by element.
void copy(auto& to, const auto& from) {
  static_assert(sizeof to == sizeof from);
  std::memcpy(static_cast<void*>(&to), &from, sizeof to);
}

}  // namespace

Bodies::Bodies() noexcept = default;

// Re-point to the control's curve in the new image; no number of a body is part of a material.
void Bodies::apply_materials(const SceneView& scene) noexcept {
  std::size_t body = 0;
  wake(asleep_);
  if (stage_ == Stage::kPress || stage_ == Stage::kSearch)
    begin_anew();  // it was at the shapes of the old image
  for (const scene::Object* object : *scene.scene()->objects()) {
    if (object->body() == nullptr || is_volume(object->shape_type()) || body == count_) continue;
    models_[body++].control = control_element_params(*object->body());
  }
}

// Sets a body to the pose and velocity at which the scene starts it.
void Bodies::start(std::size_t i, const scene::Body& body, const Vec3& position_m) noexcept {
  const BodyModel& model = models_[i];
  BodyState state;
  state.position_m = position_m;
  state.rotation = model.start_rotation;
  Centre centre{model.start_m, Vec3::Zero()};
  Vec3 angular_momentum = Vec3::Zero();
  float speed = 0.0F;
  const Vec3 velocity = to_vec(*body.velocity_m_per_s());
  const Vec3 spin = to_vec(*body.spin_rad_per_s());
  switch (model.motion) {
    case scene::Motion::Free:
      angular_momentum = to_momentum(model, state.rotation, spin);
      state.spin_rad_s = spin;
      centre.velocity_m_s = velocity;
      break;
    case scene::Motion::Translate:
      centre.velocity_m_s = velocity;
      break;
    case scene::Motion::Plane:
      centre.velocity_m_s = velocity - model.axis * model.axis.dot(velocity);
      break;
    case scene::Motion::Slide:
      speed = model.axis.dot(velocity);
      centre.velocity_m_s = model.axis * speed;
      break;
    case scene::Motion::Turn:
      speed = model.axis.dot(spin);
      state.spin_rad_s = model.axis * speed;
      centre.velocity_m_s = state.spin_rad_s.cross(centre.position_m - model.pivot_m);
      break;
  }
  state.velocity_m_s = centre.velocity_m_s - state.spin_rad_s.cross(state.rotation * model.centre_m);
  state.controlled = model.motion == scene::Motion::Slide || model.motion == scene::Motion::Turn;
  controls_[i] = start_control_element(model.control, speed);
  state.on = controls_[i].on;
  copy(states_[i], state);
  copy(centres_[i], centre);
  angular_momentum_[i] = angular_momentum;
}

// Kept as bytes: an array of them has no values to begin with, which would take time in every swap.
struct Bodies::Last {
  template <class T>
  struct Bytes {
    alignas(T) std::array<std::byte, sizeof(T)> bytes;
  };
  bool goes_on;  // as a body of the new scene
  scene::Motion motion;
  Bytes<BodyStart> start;
  Bytes<BodyState> state;
  Bytes<Centre> centre;
  Bytes<ControlElementState> control;
};

// Goes on from where a body of the last scene is, unless the new stops are short of that.
void Bodies::go_on_from(std::size_t i, const Last& last, std::uint8_t in_image,
                        PlacedObject& object) noexcept {
  const BodyModel& model = models_[i];
  ControlElementState control;
  copy(control, last.control);
  if (control.q < model.control.low || control.q > model.control.high) return;
  control.on = control.on && model.control.has_switch;
  controls_[i] = control;
  BodyState& state = states_[i];
  copy(state, last.state);
  state.object = in_image;
  state.on = control.on;
  copy(centres_[i], last.centre);
  if (model.motion == scene::Motion::Free)
    angular_momentum_[i] = to_momentum(model, state.rotation, state.spin_rad_s);
  place(i, object);
}

void Bodies::bind(const SceneView& scene, Binding binding, World& world) noexcept {
  std::array<Last, kMaxBodies> last;
  auto last_end = last.begin();
  for (std::size_t i = 0; binding == Binding::kKeepPlaces && i < count_; ++i) {
    Last& body = *last_end++;
    body.goes_on = false;
    body.motion = models_[i].motion;
    copy(body.start, static_cast<const BodyStart&>(models_[i]));
    copy(body.state, states_[i]);
    copy(body.centre, centres_[i]);
    copy(body.control, controls_[i]);
  }
  count_ = 0;
  grip_count_ = 0;
  begin_anew();
  ticks_ = 0;
  pace_ = 1.0F;
  pushed_ = asleep_ = 0;
  still_s_ = {};
  gravity_m_s2_ = Vec3::Zero();
  solver_.reset();
  if (scene.scene() == nullptr) return;
  if (scene.scene()->gravity_m_per_s2() != nullptr)
    gravity_m_s2_ = to_vec(*scene.scene()->gravity_m_per_s2());
  std::uint8_t in_image = 0;
  std::uint8_t in_world = 0;
  for (const scene::Object* object : *scene.scene()->objects()) {
    if (object->body() != nullptr && !is_volume(object->shape_type())) {
      const scene::Body& body = *object->body();
      BodyModel model = read(*object, in_world);
      const Vec3 arm = model.start_rotation * model.centre_m;
      const Vec3 half = 0.5F * (world.objects[in_world].hi_m - world.objects[in_world].lo_m);
      const float radius_m = (half + arm.cwiseAbs()).norm();
      model.max_spin_rad_s = std::min(kMaxBodySpeed_m_s / radius_m, kMaxSmallBodySpin_rad_s);
      model.reach_m = radius_m;
      if (model.motion == scene::Motion::Turn) model.reach_m += (model.start_m - model.pivot_m).norm();
      copy(models_[count_], model);
      start(count_, body, world.objects[in_world].position_m);
      states_[count_].object = in_image;
      loads_[count_] = {};
      world.objects[in_world].body = static_cast<std::uint8_t>(count_);
      world.objects[in_world].plain = world.objects[in_world].rolls = false;
      const auto same = std::find_if(last.begin(), last_end, [&](const Last& one) {
        const BodyStart& at_start = model;
        return !one.goes_on && one.motion == model.motion &&
               std::memcmp(&one.start, &at_start, sizeof at_start) == 0;
      });
      if (same != last_end) {
        same->goes_on = true;
        go_on_from(count_, *same, in_image, world.objects[in_world]);
      }
      ++count_;
    }
    if (!is_volume(object->shape_type())) ++in_world;
    ++in_image;
  }
}

// Semi-implicit Euler: first the velocities, then the positions with the new velocities. So the energy of a
// spring stays bounded, also of the spring between a fingertip and the body that it holds. Damping is
// implicit: it can stop a body, and never reverses its motion.
void Bodies::accelerate(std::size_t body, const Load& load, float period_s) noexcept {
  const BodyModel& model = models_[body];
  const BodyState& state = states_[body];
  const Centre& centre = centres_[body];
  SolverBody& solver_body = solver_bodies_[body];
  solver_body.object = model.object;
  solver_body.asleep = (asleep_ & of_body(body)) != 0;
  if (solver_body.asleep) return;
  const Vec3 outside = load.force_N + model.mass_kg * gravity_m_s2_;
  const Vec3 force = outside - model.spring_N_m * (centre.position_m - model.start_m);
  const float slowed = 1.0F / (1.0F + period_s * model.damping_N_s_m / model.mass_kg);
  solver_body.inverse_mass = solver_body.inverse_inertia = all_axes(0.0F);
  solver_body.spin_rad_s = solver_body.constrained_N_s = solver_body.gained_m_s = Vec3::Zero();
  solver_body.correction_m = solver_body.correction_rad = Vec3::Zero();
  solver_body.centre_m = centre.position_m;
  solver_body.restitution = model.restitution;
  solver_body.velocity_m_s = slowed * (centre.velocity_m_s + (period_s / model.mass_kg) * force);
  const float inverse_mass = 1.0F / model.mass_kg;
  const auto axis_squared = [&] { return Mat3(model.axis * model.axis.transpose()); };
  switch (model.motion) {
    case scene::Motion::Free: {
      solver_body.inverse_mass = all_axes(inverse_mass);
      solver_body.inverse_inertia = inverse_inertia(model, state.rotation);
      Vec3& momentum = accelerated_momentum_[body];
      momentum = angular_momentum_[body] + period_s * load.torque_N_m;
      if (model.angular_damping_N_m_s > 0.0F) {
        const Vec3 damped =
            Vec3::Ones() + (period_s * model.angular_damping_N_m_s) * model.inertia_kg_m2.cwiseInverse();
        momentum = scale(model, state.rotation, damped.cwiseInverse(), momentum);
      }
      solver_body.spin_rad_s = solver_body.inverse_inertia * momentum;
      break;
    }
    case scene::Motion::Translate:
      solver_body.inverse_mass = all_axes(inverse_mass);
      break;
    case scene::Motion::Plane: {
      const Mat3 along_axis = axis_squared();
      solver_body.inverse_mass = all_axes(inverse_mass) - inverse_mass * along_axis;
      solver_body.constrained_N_s = period_s * (along_axis * outside);
      solver_body.velocity_m_s -= along_axis * solver_body.velocity_m_s;
      break;
    }
    case scene::Motion::Slide:
    case scene::Motion::Turn: {
      const bool turns = model.motion == scene::Motion::Turn;
      const ControlElementState& control = controls_[body];
      efforts_[body] =
          turns ? model.axis.dot(load.torque_N_m + (centre.position_m - model.pivot_m).cross(outside))
                : model.axis.dot(outside);
      const float speed =
          control.speed + period_s * (efforts_[body] + control_element_effort(model.control, control.q)) /
                              model.control_inertia;
      solver_body.velocity_m_s = turns ? Vec3(Vec3::Zero()) : Vec3(speed * model.axis);
      if (turns) {
        solver_body.centre_m = model.pivot_m;
        solver_body.spin_rad_s = speed * model.axis;
        solver_body.inverse_inertia = axis_squared() / model.control_inertia;
      } else {
        solver_body.inverse_mass = axis_squared() / model.control_inertia;
      }
      break;
    }
  }
  if (model.motion != scene::Motion::Turn)
    solver_body.gained_m_s = solver_body.velocity_m_s - centre.velocity_m_s;
  solver_body.begin_m_s = solver_body.velocity_m_s;
  solver_body.begin_rad_s = solver_body.spin_rad_s;
}

// Takes the velocities and position corrections of the contact solver.
void Bodies::apply_contacts(std::size_t body, float period_s) noexcept {
  const SolverBody& after = solver_bodies_[body];
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  Centre& centre = centres_[body];
  const Vec3 spin_change = after.spin_rad_s - after.begin_rad_s;
  // What friction holds does not give way to what lies on it either: the solver knows of no friction, and would push it on by a part of each
  // correction.
  const auto correct_control = [&](float by) {
    if (!is_held_by_friction(model.control, controls_[body], efforts_[body], model.control_inertia, period_s))
      controls_[body].q += by;
  };
  switch (model.motion) {
    case scene::Motion::Free:
      state.spin_rad_s = after.spin_rad_s;
      angular_momentum_[body] = accelerated_momentum_[body] + to_momentum(model, state.rotation, spin_change);
      centre.velocity_m_s = after.velocity_m_s;
      centre.position_m += after.correction_m;
      if (!after.correction_rad.isZero(0.0F)) state.rotation = turned(state.rotation, after.correction_rad);
      break;
    case scene::Motion::Translate:
    case scene::Motion::Plane:
      centre.velocity_m_s = after.velocity_m_s;
      centre.position_m += after.correction_m;
      break;
    case scene::Motion::Slide:
      efforts_[body] +=
          model.axis.dot(after.velocity_m_s - after.begin_m_s) * model.control_inertia / period_s;
      correct_control(model.axis.dot(after.correction_m));
      break;
    case scene::Motion::Turn:
      efforts_[body] += model.axis.dot(spin_change) * model.control_inertia / period_s;
      correct_control(model.axis.dot(after.correction_rad));
      break;
  }
}

void Bodies::limit_speed(std::size_t body, float period_s) noexcept {
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  centres_[body].velocity_m_s = limited(centres_[body].velocity_m_s, kMaxBodySpeed_m_s);
  const float most =
      std::max(std::min(model.max_spin_rad_s, kMaxTurnPerTick_rad / period_s), kMaxBodySpin_rad_s);
  if (state.spin_rad_s.squaredNorm() > most * most) {
    state.spin_rad_s = limited(state.spin_rad_s, most);
    angular_momentum_[body] = to_momentum(model, state.rotation, state.spin_rad_s);
  }
}

void Bodies::advance(std::size_t body, float period_s) noexcept {
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  Centre& centre = centres_[body];
  switch (model.motion) {
    case scene::Motion::Free: {
      // The spin at half the period: the angular momentum is constant, the spin is not.
      Vec3 spin = state.spin_rad_s;
      if (!model.even) {
        const Vec3 grows = solver_bodies_[body].inverse_inertia * angular_momentum_[body].cross(spin);
        spin += (0.5F * period_s) * grows;
      }
      state.rotation = turned(state.rotation, period_s * spin);
      state.spin_rad_s = to_spin(model, state.rotation, angular_momentum_[body]);
      centre.position_m += period_s * centre.velocity_m_s;
      limit_speed(body,
                  period_s);  // the spin of a thin rod can grow as it turns relative to its angular momentum
      break;
    }
    case scene::Motion::Translate:
    case scene::Motion::Plane:
      centre.position_m += period_s * centre.velocity_m_s;
      break;
    case scene::Motion::Slide:
    case scene::Motion::Turn:
      advance_along_axis(body, period_s);
      break;
  }
}

// The pose and the velocity of the object's frame. Positions are limited to kMaxCoordinate_m.
void Bodies::place(std::size_t body, PlacedObject& object) noexcept {
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  Centre& centre = centres_[body];
  if (model.motion == scene::Motion::Free || model.motion == scene::Motion::Turn) {
    object.rotation = state.rotation.toRotationMatrix();
    object.turned = true;
  }
  const Vec3 arm = object.rotation * model.centre_m;
  state.position_m = centre.position_m - arm;
  const Vec3 held = state.position_m.cwiseMax(-kMaxCoordinate_m).cwiseMin(kMaxCoordinate_m);
  if (held != state.position_m) {
    state.position_m = held;
    centre = {held + arm, Vec3::Zero()};
  }
  state.velocity_m_s = centre.velocity_m_s - state.spin_rad_s.cross(arm);
  object.position_m = state.position_m;
  place_box(object);
}

void Bodies::advance_along_axis(std::size_t body, float period_s) noexcept {
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  Centre& centre = centres_[body];
  ControlElementState& control = controls_[body];
  const bool turns = model.motion == scene::Motion::Turn;
  const float most = turns ? kMaxBodySpin_rad_s : kMaxBodySpeed_m_s;
  advance_control_element(model.control, control, efforts_[body], model.control_inertia, period_s);
  control.speed = std::clamp(control.speed, -most, most);
  state.q = control.q;
  state.on = control.on;
  if (!turns) {
    centre.position_m = model.start_m + control.q * model.axis;
    centre.velocity_m_s = control.speed * model.axis;
    return;
  }
  constexpr float kTurn_rad = 2.0F * std::numbers::pi_v<float>;
  const float within = control.q - kTurn_rad * static_cast<float>(static_cast<int>(control.q / kTurn_rad));
  const auto half = kinematics::sin_cos(0.5F * within);
  const Vec3 vector = half.sin * model.axis;
  const Quaternionf about(half.cos, vector.x(), vector.y(), vector.z());
  state.rotation = (about * model.start_rotation).normalized();
  const Vec3 arm = about * (model.start_m - model.pivot_m);
  centre.position_m = model.pivot_m + arm;
  state.spin_rad_s = control.speed * model.axis;
  centre.velocity_m_s = state.spin_rad_s.cross(arm);
}

void Bodies::stop(std::size_t body) noexcept {
  centres_[body].velocity_m_s = Vec3::Zero();
  states_[body].velocity_m_s = Vec3::Zero();
  states_[body].spin_rad_s = Vec3::Zero();
  angular_momentum_[body] = Vec3::Zero();
  controls_[body].speed = 0.0F;
}

}  // namespace thimble::control
