#include "control/scene/check.h"
#include "control/scene/shape_table.h"

namespace thimble::control {
namespace {

ImageVerdict check_free(const scene::Body& body) {
  const scene::Vec3& inertia = *body.inertia_kg_m2();
  for (const float each : {inertia.x(), inertia.y(), inertia.z()}) {
    RETURN_IF_BAD(require(in_range(each, kMinInertia_kg_m2, kMaxInertia_kg_m2), ImageStatus::kBadNumber));
  }
  if (body.centre_m() != nullptr)
    RETURN_IF_BAD(require(is_coordinate(*body.centre_m()), ImageStatus::kBadNumber));
  if (body.principal_axes() != nullptr)
    RETURN_IF_BAD(require(is_unit(*body.principal_axes()), ImageStatus::kBadNumber));
  const scene::Vec3& spin = *body.spin_rad_per_s();
  for (const float each : {spin.x(), spin.y(), spin.z()}) {
    RETURN_IF_BAD(require(in_range(each, -kMaxBodySpin_rad_s, kMaxBodySpin_rad_s), ImageStatus::kBadNumber));
  }
  return ImageStatus::kOk;
}

}  // namespace

ImageVerdict check_body(const scene::Object& object) noexcept {
  if (object.body() == nullptr) return ImageStatus::kOk;
  const scene::Body& body = *object.body();
  if (shape_row(object.shape_type()).mobility != Mobility::kMovable) return ImageStatus::kNoShape;
  RETURN_IF_BAD(require(body.motion() <= scene::Motion::MAX &&
                            in_range(body.mass_kg(), kMinMass_kg, kMaxMass_kg) &&
                            stiffest_N_m(object.material()->stiffness_n_per_m(), object.surface()) <=
                                kMaxStiffnessPerMass_1_s2 * body.mass_kg() &&
                            in_range(body.restitution(), 0.0F, 1.0F) &&
                            in_range(body.spring_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                            body.spring_n_per_m() <= kMaxStiffnessPerMass_1_s2 * body.mass_kg() &&
                            in_range(body.damping_n_s_per_m(), 0.0F, kMaxDamping_N_s_m) &&
                            in_range(body.angular_damping_n_m_s(), 0.0F, kMaxAngularDamping_N_m_s),
                        ImageStatus::kBadNumber));
  const scene::Vec3& v = *body.velocity_m_per_s();
  for (const float each : {v.x(), v.y(), v.z()}) {
    RETURN_IF_BAD(require(in_range(each, -kMaxBodySpeed_m_s, kMaxBodySpeed_m_s), ImageStatus::kBadNumber));
  }
  RETURN_IF_BAD(require(is_unit(*body.axis()) && is_coordinate(*body.pivot_m()), ImageStatus::kBadNumber));
  RETURN_IF_BAD(check_free(body));
  return check_control(object);
}

}  // namespace thimble::control
