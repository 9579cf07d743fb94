// What the checks of a scene image share, and the checks of its parts. Used by SceneView::check only.
#pragma once

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {

// Every check answers the first thing wrong; kOk goes on.
#define RETURN_IF_BAD(expression)                                                           \
  do {                                                                                      \
    if (const ImageStatus status = (expression); status != ImageStatus::kOk) return status; \
  } while (false)

inline ImageStatus require(bool sound, ImageStatus otherwise) { return sound ? ImageStatus::kOk : otherwise; }

// Comparisons with NaN are false, so these refuse it too.
inline bool in_range(float value, float lo, float hi) { return value >= lo && value <= hi; }
inline bool is_coordinate(const scene::Vec3& v) {
  return in_range(v.x(), -kMaxCoordinate_m, kMaxCoordinate_m) &&
         in_range(v.y(), -kMaxCoordinate_m, kMaxCoordinate_m) &&
         in_range(v.z(), -kMaxCoordinate_m, kMaxCoordinate_m);
}
inline bool is_size(float value) { return value > 0.0F && value <= kMaxCoordinate_m; }
inline bool is_unit(float length2) { return in_range(length2, 0.998F, 1.002F); }

[[nodiscard]] ImageStatus check_surface(
    const scene::Object& object) noexcept;  // object.surface, when it has one
[[nodiscard]] ImageStatus check_body(const scene::Object& object) noexcept;  // object.body, when it has one
// The control of an object's body, when it has one; the body's own numbers have been checked before.
[[nodiscard]] ImageStatus check_control(const scene::Object& object) noexcept;
[[nodiscard]] ImageStatus check_volume(const scene::Object& object) noexcept;  // a shape that is a volume
[[nodiscard]] ImageStatus check_needle(const scene::Needle& needle) noexcept;
[[nodiscard]] ImageStatus check_tissue(const scene::Tissue& tissue,
                                       float stiffness_N_m) noexcept;  // of the object's material

}  // namespace thimble::control
