// Potential fields (paper, section 5.1): the force is minus the gradient of an energy that is zero on the
// whole surface, so no closed path gains work. The energy is a tricubic B-spline; its gradient is exact.
#include <array>
#include <cmath>

#include "control/fields/volume.h"
#include "control/scene/check.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace potential_field {
namespace {

constexpr unsigned kTaps = 4;  // along each axis

struct Blend {
  unsigned first = 0;
  std::array<float, kTaps> value{};
  std::array<float, kTaps> slope{};  // per step
};

// The uniform cubic B-spline's four pieces at x, in steps from the first coefficient; x is from 1 to count -
// 2.
Blend blend(float x, unsigned count) {
  Blend b;
  const float cell = std::fmin(std::fmax(std::floor(x), 1.0F), static_cast<float>(count - 3));
  b.first = static_cast<unsigned>(cell) - 1;
  const float t = x - cell;
  const float s = 1.0F - t;
  b.value = {s * s * s / 6.0F, (4.0F - 6.0F * t * t + 3.0F * t * t * t) / 6.0F,
             (4.0F - 6.0F * s * s + 3.0F * s * s * s) / 6.0F, t * t * t / 6.0F};
  b.slope = {-0.5F * s * s, 1.5F * t * t - 2.0F * t, 2.0F * s - 1.5F * s * s, 0.5F * t * t};
  return b;
}

ImageVerdict check(const scene::Object& object, Pauses& pauses) noexcept {
  return check_potential_field(*object.shape_as_PotentialField(), pauses);
}

[[gnu::cold]] VolumeBounds bounds(const scene::Object& object) noexcept {
  const scene::PotentialField& field = *object.shape_as_PotentialField();
  const Vec3 origin = to_vec(*field.origin_m());
  const auto& count = *field.count();
  const auto last = [&](unsigned axis) { return static_cast<float>(count[axis] - 2); };
  return {origin + Vec3::Constant(field.step_m()), origin + field.step_m() * Vec3(last(0), last(1), last(2))};
}

VolumeTouch tick(const scene::Object& object, const Material& material, const Tip& tip, float /*period_s*/,
                 SharedState& /*shared*/, ArmState& /*own*/) noexcept {
  const scene::PotentialField& field = *object.shape_as_PotentialField();
  const auto& count = *field.count();
  const float* coefficients = field.coefficients()->data();
  const Vec3 at = (tip.position_m - to_vec(*field.origin_m())) / field.step_m();
  const Blend x = blend(at.x(), count[0]);
  const Blend y = blend(at.y(), count[1]);
  const Blend z = blend(at.z(), count[2]);
  float u = 0.0F;
  Vec3 slope = Vec3::Zero();
  for (unsigned k = 0; k < kTaps; ++k) {
    for (unsigned j = 0; j < kTaps; ++j) {
      const std::uint32_t row =
          ((z.first + k) * std::uint32_t{count[1]} + y.first + j) * std::uint32_t{count[0]} + x.first;
      float value = 0.0F;
      float along = 0.0F;
      for (unsigned i = 0; i < kTaps; ++i) {
        const float c = coefficients[row + i];
        value += x.value[i] * c;
        along += x.slope[i] * c;
      }
      u += y.value[j] * z.value[k] * value;
      slope.x() += y.value[j] * z.value[k] * along;
      slope.y() += y.slope[j] * z.value[k] * value;
      slope.z() += y.value[j] * z.slope[k] * value;
    }
  }
  if (!(u > 0.0F)) return {};
  slope /= field.step_m();
  const float steepness = slope.norm();
  const Vec3 normal = steepness > 0.0F ? Vec3(-slope / steepness) : Vec3(Vec3::Zero());
  // -grad of K u^2 / 2, or of u.
  const bool spring = field.law() == scene::PotentialLaw::Spring;
  const float push = spring ? material.stiffness_N_m * u * steepness : steepness;
  const float reach = spring ? u * steepness : push / material.stiffness_N_m;
  return {damped_push(push, normal, tip.velocity_m_s, material.damping_N_s_m),
          tip.position_m + reach * normal, 1};
}

}  // namespace
}  // namespace potential_field

const VolumeOps kPotentialFieldVolume{potential_field::check, potential_field::bounds, potential_field::tick};

}  // namespace thimble::control
