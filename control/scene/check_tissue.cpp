#include "control/scene/check.h"

namespace thimble::control {

ImageVerdict check_needle(const scene::Needle& needle) noexcept {
  RETURN_IF_BAD(at_most(kMaxLayers, needle.layers()->size(), "layers", ImageStatus::kTooManySamples));
  if (needle.layers()->size() == 0) return ImageStatus::kBadNumber;
  for (const scene::Layer* layer : *needle.layers()) {
    RETURN_IF_BAD(require(is_size(layer->thickness_m()) &&
                              in_range(layer->stiffness_n_per_m(), 0.0F, kMaxStiffness_N_m) &&
                              in_range(layer->tear_n(), 0.0F, kMaxTear_N) &&
                              (layer->stiffness_n_per_m() > 0.0F || layer->tear_n() == 0.0F) &&
                              in_range(layer->friction_n(), 0.0F, kMaxTear_N) &&
                              in_range(layer->viscosity_n_s_per_m2(), 0.0F, kMaxViscosity_N_s_m2),
                          ImageStatus::kBadNumber));
  }
  return ImageStatus::kOk;
}

ImageVerdict check_tissue(const scene::Tissue& tissue, float stiffness_N_m) noexcept {
  return require(
      is_size(tissue.half_x_m()) && is_size(tissue.half_y_m()) && is_size(tissue.contact_radius_m()) &&
          stiffness_N_m > 0.0F &&
          in_range(tissue.relaxed_stiffness_n_per_m(), kMinRelaxedShare * stiffness_N_m, stiffness_N_m) &&
          in_range(tissue.recovery_s(), kMinRecovery_s, kMaxRecovery_s),
      ImageStatus::kBadNumber);
}

}  // namespace thimble::control
