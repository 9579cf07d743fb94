// The checks of the parts of a scene image and what they share. For SceneView::check(), and for the compiler,
// which refuses the same things with longer messages.
#pragma once

#include "control/scene/limits.h"
#include "control/scene/pauses.h"
#include "control/scene/scene_view.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

struct VolumeOps;

// A check returns its first error.
#define RETURN_IF_BAD(expression)                                                               \
  do {                                                                                          \
    if (const ImageVerdict verdict = (expression); verdict != ImageStatus::kOk) return verdict; \
  } while (false)

inline ImageVerdict require(bool sound, ImageStatus otherwise) {
  return sound ? ImageStatus::kOk : otherwise;
}

inline ImageVerdict at_most(std::size_t limit, std::size_t count, const char* what, ImageStatus otherwise) {
  return count <= limit ? ImageVerdict() : ImageVerdict(otherwise, what, count, limit);
}

// Comparisons with NaN are false, so these functions refuse it too.
inline bool in_range(float value, float lo, float hi) { return value >= lo && value <= hi; }
inline bool is_coordinate(const scene::Vec3& v) {
  return in_range(v.x(), -kMaxCoordinate_m, kMaxCoordinate_m) &&
         in_range(v.y(), -kMaxCoordinate_m, kMaxCoordinate_m) &&
         in_range(v.z(), -kMaxCoordinate_m, kMaxCoordinate_m);
}
inline bool is_size(float value) { return value > 0.0F && value <= kMaxCoordinate_m; }
inline bool is_unit(float length2) { return in_range(length2, 0.998F, 1.002F); }
inline bool is_unit(const scene::Quat& q) {
  return is_unit(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
}
inline bool is_unit(const scene::Vec3& v) { return is_unit(v.x() * v.x() + v.y() * v.y() + v.z() * v.z()); }

// object.surface, when it has one
[[nodiscard]] ImageVerdict check_surface(const scene::Object& object, Pauses& pauses) noexcept;
// The largest stiffness anywhere on a surface, N/m: a spline is never above the largest of its control
// points.
[[nodiscard]] inline float stiffest_N_m(float of_material_N_m, const scene::Surface* surface) noexcept {
  if (surface == nullptr || surface->stiffness_map() == nullptr) return of_material_N_m;
  const auto& points_N_m = *surface->stiffness_map()->stiffness_n_per_m();
  float stiffest = 0.0F;  // the map takes the place of the material's
  for (const float each_N_m : points_N_m) stiffest = each_N_m > stiffest ? each_N_m : stiffest;
  return stiffest;
}
[[nodiscard]] ImageVerdict check_body(const scene::Object& object) noexcept;  // object.body, when it has one
// The control element of an object's body, when it has one. The numbers of the body itself are checked
// already.
[[nodiscard]] ImageVerdict check_control(const scene::Object& object) noexcept;
// Adds to the scene's triangles.
[[nodiscard]] ImageVerdict check_mesh(const scene::Mesh& mesh, std::size_t& triangles_in_scene,
                                      Pauses& pauses) noexcept;
// An object whose shape is a volume with these operations (control/fields/volume.h).
[[nodiscard]] ImageVerdict check_volume(const scene::Object& object, const VolumeOps& volume,
                                        Pauses& pauses) noexcept;
[[nodiscard]] ImageVerdict check_vector_field(const scene::VectorField& field) noexcept;
[[nodiscard]] ImageVerdict check_potential_field(const scene::PotentialField& field, Pauses& pauses) noexcept;
[[nodiscard]] ImageVerdict check_force_field(const scene::ForceField& field) noexcept;
[[nodiscard]] ImageVerdict check_needle(const scene::Needle& needle) noexcept;
[[nodiscard]] ImageVerdict check_tissue(const scene::Tissue& tissue,
                                        float stiffness_N_m) noexcept;  // of the object's material

}  // namespace thimble::control
