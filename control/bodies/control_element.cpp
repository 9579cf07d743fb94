#include "control/bodies/control_element.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/solids/mesh_view.h"
#include "kinematics/trig.h"

namespace thimble::control {
namespace {

float curve_effort(std::span<const scene::CurvePoint> curve, float q) {
  if (q <= curve.front().at()) return curve.front().effort();
  for (std::size_t i = 1; i < curve.size(); ++i) {  // kMaxCurvePoints
    const scene::CurvePoint& end = curve[i];
    if (q > end.at()) continue;
    const scene::CurvePoint& begin = curve[i - 1];
    return begin.effort() + (end.effort() - begin.effort()) * ((q - begin.at()) / (end.at() - begin.at()));
  }
  return curve.back().effort();
}

void set_switch(const ControlElementParams& params, ControlElementState& state) {
  const bool upwards = params.on_at > params.off_at;
  const float bound = state.on ? params.off_at : params.on_at;
  const bool beyond = state.on == upwards ? state.q <= bound : state.q >= bound;
  if (beyond) state.on = !state.on;
}

}  // namespace

ControlElementParams control_element_params(const scene::Body& body) noexcept {
  ControlElementParams params;
  params.restitution = body.restitution();
  const scene::Control* control = body.control();
  if (control == nullptr) {
    const bool turns = body.motion() == scene::Motion::Turn;
    params.stiffness = turns ? 0.0F : body.spring_n_per_m();
    params.damping = turns ? body.angular_damping_n_m_s() : body.damping_n_s_per_m();
    params.high = turns ? kMaxTurn_rad : kMaxCoordinate_m;
    params.low = -params.high;
    return params;
  }
  params.stiffness = control->stiffness();
  params.rest = control->rest();
  params.damping = control->damping();
  params.friction = control->friction();
  params.low = control->low();
  params.high = control->high();
  params.detent_pitch = control->detent_pitch();
  params.detent_phase = control->detent_phase();
  params.detent_effort = control->detent_effort();
  if (const auto* curve = control->curve(); curve != nullptr && curve->size() != 0)
    params.curve = {curve->Get(0), curve->size()};
  params.has_switch = control->has_switch();
  params.on_at = control->on_at();
  params.off_at = control->off_at();
  return params;
}

float control_element_inertia(const scene::Object& object) noexcept {
  const scene::Body& body = *object.body();
  if (body.motion() != scene::Motion::Turn) return body.mass_kg();
  const Eigen::Quaternionf rotation = to_rotation(object.pose()->rotation());
  const Vec3 axis = to_vec(*body.axis()).normalized();
  Vec3 own_axis = rotation.conjugate() * axis;
  if (body.principal_axes() != nullptr)
    own_axis = to_rotation(*body.principal_axes()).conjugate() * own_axis.eval();
  Vec3 arm = to_vec(object.pose()->position_m()) - to_vec(*body.pivot_m());
  if (body.centre_m() != nullptr) arm += rotation * to_vec(*body.centre_m());
  return own_axis.cwiseAbs2().dot(to_vec(*body.inertia_kg_m2())) +
         body.mass_kg() * axis.cross(arm).squaredNorm();
}

float control_element_effort(const ControlElementParams& params, float q) noexcept {
  float effort = -params.stiffness * (q - params.rest);
  if (params.detent_pitch > 0.0F) {
    const float turns = (q - params.detent_phase) / params.detent_pitch;
    const float part = turns - std::floor(turns + 0.5F);
    effort -= params.detent_effort * kinematics::sin_cos(2.0F * std::numbers::pi_v<float> * part).sin;
  }
  if (!params.curve.empty()) effort -= curve_effort(params.curve, q);
  return effort;
}

ControlElementState start_control_element(const ControlElementParams& params, float speed) noexcept {
  ControlElementState state;
  state.speed = speed;
  if (params.has_switch) set_switch(params, state);
  return state;
}

bool is_held_by_friction(const ControlElementParams& params, const ControlElementState& state, float effort,
                         float inertia, float period_s) noexcept {
  const float momentum =
      inertia * state.speed + period_s * (effort + control_element_effort(params, state.q));
  return params.friction > 0.0F && std::abs(momentum) <= period_s * params.friction;
}

// Semi-implicit Euler: first the speed, then the position with the new speed. It is symplectic, so potentials
// neither gain nor lose energy over any number of ticks. It is stable for a total stiffness, with that of the
// tips, below 4 inertia / period^2; kMaxControlRate_rad_s is far below that. Damping and friction act on the
// new speed, so they are stable for any value. When friction suffices, the speed is exactly 0, so a control
// element at rest does not creep.
void advance_control_element(const ControlElementParams& params, ControlElementState& state, float effort,
                             float inertia, float period_s) noexcept {
  const float before = state.speed;
  const float momentum = inertia * before + period_s * (effort + control_element_effort(params, state.q));
  const float held = period_s * params.friction;
  const float left = std::max(std::abs(momentum) - held, 0.0F);
  state.speed = std::copysign(left, momentum) / (inertia + period_s * params.damping);

  const float step = period_s * state.speed + state.carry;
  const float q = state.q + step;
  state.carry = step - (q - state.q);
  state.q = std::clamp(q, params.low, params.high);
  if (state.q != q) {
    // Elastic stop: position and speed are mirrored, which conserves energy at restitution 1. A motion that
    // only this tick's effort started ends at the stop.
    const bool hits = (q > state.q) == (before > 0.0F) && before != 0.0F;
    const float back = hits ? params.restitution : 0.0F;
    state.q = std::clamp(state.q - back * (q - state.q), params.low, params.high);
    state.speed *= -back;
    state.carry = 0.0F;
  }
  if (params.has_switch) set_switch(params, state);
}

}  // namespace thimble::control
