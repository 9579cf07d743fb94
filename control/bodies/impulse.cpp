// What an impulse at a point does to a body.
#include "control/bodies/bodies.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

float Bodies::mass_at(std::uint8_t body, const Vec3& point_m, const Vec3& direction) const noexcept {
  const BodyModel& model = models_[body];
  float response = 0.0F;
  switch (model.motion) {
    case scene::Motion::Free: {
      const Eigen::Quaternionf axes = states_[body].rotation * model.principal_axes;
      const Vec3 arm = axes.conjugate() * (point_m - centres_[body].position_m).cross(direction).eval();
      response = 1.0F / model.mass_kg + arm.cwiseAbs2().dot(model.inertia_kg_m2.cwiseInverse());
      break;
    }
    case scene::Motion::Translate:
      response = 1.0F / model.mass_kg;
      break;
    case scene::Motion::Plane: {
      const float along = model.axis.dot(direction);
      response = (1.0F - along * along) / model.mass_kg;
      break;
    }
    case scene::Motion::Slide: {
      const float along = model.axis.dot(direction);
      response = along * along / model.control_inertia;
      break;
    }
    case scene::Motion::Turn: {
      const float arm = model.axis.dot((point_m - model.pivot_m).cross(direction));
      response = arm * arm / model.control_inertia;
      break;
    }
  }
  return response > kNoResponse ? 1.0F / response : 0.0F;
}

void Bodies::apply_impulse(std::size_t body, const Vec3& point_m, const Vec3& impulse_N_s) noexcept {
  const BodyModel& model = models_[body];
  BodyState& state = states_[body];
  Centre& centre = centres_[body];
  switch (model.motion) {
    case scene::Motion::Free: {
      const Eigen::Quaternionf axes = state.rotation * model.principal_axes;
      centre.velocity_m_s += impulse_N_s / model.mass_kg;
      angular_momentum_[body] += (point_m - centre.position_m).cross(impulse_N_s);
      const Vec3 momentum = axes.conjugate() * angular_momentum_[body];
      state.spin_rad_s = axes * momentum.cwiseQuotient(model.inertia_kg_m2).eval();
      break;
    }
    case scene::Motion::Translate:
      centre.velocity_m_s += impulse_N_s / model.mass_kg;
      break;
    case scene::Motion::Plane:
      centre.velocity_m_s += (impulse_N_s - model.axis * model.axis.dot(impulse_N_s)) / model.mass_kg;
      break;
    case scene::Motion::Slide:
      controls_[body].speed += model.axis.dot(impulse_N_s) / model.control_inertia;
      centre.velocity_m_s = controls_[body].speed * model.axis;
      break;
    case scene::Motion::Turn:
      controls_[body].speed +=
          model.axis.dot((point_m - model.pivot_m).cross(impulse_N_s)) / model.control_inertia;
      state.spin_rad_s = controls_[body].speed * model.axis;
      centre.velocity_m_s = state.spin_rad_s.cross(centre.position_m - model.pivot_m);
      break;
  }
  state.velocity_m_s = centre.velocity_m_s - state.spin_rad_s.cross(centre.position_m - state.position_m);
}

// A body and what it presses a god object against: the impulse that ends their approach there. What is fixed takes its part.
void Bodies::press(const World& world, std::size_t body, const Pin& pin) noexcept {
  const std::uint8_t other = pin.object == kNoBody ? kNoBody : world.objects[pin.object].body;
  const auto index = static_cast<std::uint8_t>(body);
  float approach_m_s = pin.direction.dot(speed_at(index, pin.point_m));
  if (other != kNoBody) approach_m_s -= pin.direction.dot(speed_at(other, pin.point_m));
  const float mass_kg = mass_at(index, pin.point_m, pin.direction);
  // Where it is not the approach that squeezes the god object.
  if (approach_m_s <= 0.0F || mass_kg <= 0.0F) return stop(body);
  float response = 1.0F / mass_kg;
  const float other_kg = other == kNoBody ? 0.0F : mass_at(other, pin.point_m, pin.direction);
  if (other_kg > 0.0F) response += 1.0F / other_kg;
  const Vec3 impulse = (approach_m_s / response) * pin.direction;
  apply_impulse(body, pin.point_m, -impulse);
  if (other_kg > 0.0F) apply_impulse(other, pin.point_m, impulse);
}

}  // namespace thimble::control
