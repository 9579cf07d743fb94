// Force fields: constant, viscous, curl, channel, and a mass that hangs on the tip. They act without a surface, so a hand may be anywhere in
// one when it begins (the parameter `trial`, or where the tip comes in).
//
// What a field's spring stores by then would be given to the hand for nothing: a field begins in the first tick in which that is at most
// kMostAtStart_J. The mass begins at rest where the tip is, so it holds no energy. A damper takes energy, and a constant force does the same
// work on every path from one place to another.
// The curl takes the velocity below 10 Hz, where hands move: what is measured lags by some ms, and where motors and links swing against each
// other, faster than that, a force across the measured velocity would feed the swing (ForceField.ACurlComesToRestInTheWholeLoop). What of it
// would push along the measured velocity is left out, so it gives nothing but by the lag of that.
#include "control/fields/volume.h"
#include "control/scene/check.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace force_field {
namespace {

constexpr float kMostAtStart_J = 2.0e-3F;
constexpr float kCurlLag_s = 0.016F;

const scene::ForceField& field_of(const scene::Object& object) { return *object.shape_as_ForceField(); }

ImageVerdict check(const scene::Object& object, Pauses& /*pauses*/) noexcept {
  return check_force_field(field_of(object));
}

[[gnu::cold]] VolumeBounds bounds(const scene::Object& object) noexcept {
  const Vec3 half_m = to_vec(field_of(object).half_size_m());
  return {-half_m, half_m};
}

// The pull of the mass, which is at grip_m with the velocity middle_m and moves on. The implicit midpoint rule keeps the energy of a swing,
// and is stable with any mass and period.
Vec3 mass_pull_N(const scene::ForceField& field, const Tip& tip, float period_s, ArmState& own) {
  const float stiffness_N_m = field.mass_stiffness_n_per_m();
  const float damping_N_s_m = field.mass_damping_n_s_per_m();
  const float half_s = 0.5F * period_s;
  const float per_mass_s_kg = half_s / field.mass_kg();
  const Vec3 from_tip_m = own.grip_m - tip.position_m;
  // Written as a change of the velocity: the rounding of a divisor near 1 would add up to a swing that grows.
  const Vec3 middle_m_s =
      own.middle_m + per_mass_s_kg / (1.0F + per_mass_s_kg * (damping_N_s_m + half_s * stiffness_N_m)) *
                         (damping_N_s_m * (tip.velocity_m_s - own.middle_m) -
                          stiffness_N_m * (from_tip_m + half_s * own.middle_m));
  own.grip_m += period_s * middle_m_s;
  own.middle_m = 2.0F * middle_m_s - own.middle_m;
  return stiffness_N_m * (from_tip_m + half_s * middle_m_s) + damping_N_s_m * (middle_m_s - tip.velocity_m_s);
}

// The force without what it has along the velocity, where that pushes.
Vec3 across(const Vec3& force_N, const Vec3& velocity_m_s) {
  const float power_W = force_N.dot(velocity_m_s);
  if (!(power_W > 0.0F)) return force_N;
  return force_N - power_W / velocity_m_s.squaredNorm() * velocity_m_s;
}

VolumeTouch tick(const scene::Object& object, const Material& /*material*/, const Tip& tip, float period_s,
                 SharedState& /*shared*/, ArmState& own) noexcept {
  const scene::ForceField& field = field_of(object);
  const Vec3 stiffness_N_m = to_vec(field.stiffness_n_per_m());
  const Vec3 spring_N = -stiffness_N_m.cwiseProduct(tip.position_m);
  if (!own.seen) {
    if (!(-0.5F * spring_N.dot(tip.position_m) <= kMostAtStart_J)) return {};
    own.seen = true;
    own.grip_m = tip.position_m;
    if (field.mass_kg() == 0.0F) own.middle_m = tip.velocity_m_s;
  }
  const bool has_mass = field.mass_kg() > 0.0F;
  if (!has_mass) own.middle_m += period_s / (kCurlLag_s + period_s) * (tip.velocity_m_s - own.middle_m);
  VolumeTouch touch{to_vec(field.constant_n()) + spring_N -
                        to_vec(field.damping_n_s_per_m()).cwiseProduct(tip.velocity_m_s),
                    tip.position_m, 1};
  if (!has_mass)
    touch.force_N += across(to_vec(field.curl_n_s_per_m()).cross(own.middle_m), tip.velocity_m_s);
  for (int axis = 0; axis < 3; ++axis)
    if (stiffness_N_m[axis] > 0.0F) touch.proxy_m[axis] = 0.0F;
  if (has_mass) touch.force_N += mass_pull_N(field, tip, period_s, own);
  return touch;
}

}  // namespace
}  // namespace force_field

const VolumeOps kForceFieldVolume{force_field::check, force_field::bounds, force_field::tick};

}  // namespace thimble::control
