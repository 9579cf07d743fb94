// Vector fields from hand-made subvolumes (paper, section 4): each subvolume belongs to one surface, which
// pushes a tip inside it along its normal. There is no state: the force depends on the position alone, so it
// jumps between subvolumes.
#include "control/fields/volume.h"
#include "control/scene/check.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace vector_field {
namespace {

float behind(const scene::HalfSpace& half, const Vec3& p) {
  return half.offset_m() - to_vec(half.normal()).dot(p);
}

bool is_in(const scene::Subvolume& subvolume, const Vec3& p) {
  for (const scene::HalfSpace* side : *subvolume.sides()) {
    if (!(behind(*side, p) >= 0.0F)) return false;
  }
  return true;
}

ImageVerdict check(const scene::Object& object, Pauses& /*pauses*/) noexcept {
  return check_vector_field(*object.shape_as_VectorField());
}

[[gnu::cold]] VolumeBounds bounds(const scene::Object& object) noexcept {
  const scene::VectorField& field = *object.shape_as_VectorField();
  return {to_vec(*field.lo_m()), to_vec(*field.hi_m())};
}

VolumeTouch tick(const scene::Object& object, const Material& material, const Tip& tip, float /*period_s*/,
                 SharedState& /*shared*/, ArmState& /*own*/) noexcept {
  for (const scene::Subvolume* subvolume : *object.shape_as_VectorField()->subvolumes()) {
    Vec3 normal = to_vec(subvolume->plane()->normal());
    float depth = behind(*subvolume->plane(), tip.position_m);
    if (subvolume->radius_m() > 0.0F) {
      const Vec3 arm = tip.position_m - to_vec(*subvolume->centre_m());
      const float distance = arm.norm();
      depth = subvolume->radius_m() - distance;
      normal = distance > 0.0F ? Vec3(arm / distance) : Vec3(Vec3::Zero());
    }
    if (!(depth > 0.0F) || !is_in(*subvolume, tip.position_m)) continue;
    return {damped_push(material.stiffness_N_m * depth, normal, tip.velocity_m_s, material.damping_N_s_m),
            tip.position_m + depth * normal, 1};
  }
  return {};
}

}  // namespace
}  // namespace vector_field

const VolumeOps kVectorFieldVolume{vector_field::check, vector_field::bounds, vector_field::tick};

}  // namespace thimble::control
