#include "control/scene/check.h"

namespace thimble::control {
namespace {

// A grid of as many numbers as it says, all of them in the range.
ImageVerdict check_grid(const flatbuffers::Vector<float>& numbers, std::size_t columns, std::size_t rows,
                        std::size_t most, const char* what, float lo, float hi, Pauses& pauses) {
  RETURN_IF_BAD(at_most(most, columns * rows, what, ImageStatus::kTooManySamples));
  if (columns == 0 || rows == 0 || numbers.size() != columns * rows) return ImageStatus::kBadIndex;
  for (const float number : numbers) {
    pauses.step();
    if (!in_range(number, lo, hi)) return ImageStatus::kBadNumber;
  }
  return ImageStatus::kOk;
}

ImageVerdict check_click(const scene::Click& click) {
  return require(in_range(click.amplitude_n(), 0.0F, kMaxClick_N) &&
                     in_range(click.frequency_hz(), kMinClickFrequency_Hz, kMaxClickFrequency_Hz) &&
                     in_range(click.decay_per_s(), kMinClickDecay_per_s, kMaxClickDecay_per_s),
                 ImageStatus::kBadNumber);
}

// The spline through heights that alternate along both axes has control points nine times as far apart as the heights.
constexpr float kOvershoot = 10.0F;

ImageVerdict check_texture(const scene::Texture& texture, Pauses& pauses) {
  RETURN_IF_BAD(check_grid(*texture.height_m(), texture.columns(), texture.rows(), kMaxTextureSamples,
                           "points of a texture", -kOvershoot * kMaxRelief_m, kOvershoot * kMaxRelief_m,
                           pauses));
  return require(
      texture.kind() <= scene::TextureKind::MAX &&
          in_range(texture.tile_u_m() / static_cast<float>(texture.columns()), kMinSpacing_m,
                   kMaxCoordinate_m) &&
          in_range(texture.tile_v_m() / static_cast<float>(texture.rows()), kMinSpacing_m, kMaxCoordinate_m),
      ImageStatus::kBadNumber);
}

ImageVerdict check_map(const scene::StiffnessMap& map, Pauses& pauses) {
  RETURN_IF_BAD(check_grid(*map.stiffness_n_per_m(), map.columns(), map.rows(), kMaxMapSamples,
                           "points of a map", 0.0F, kMaxStiffness_N_m, pauses));
  if (map.damping_n_s_per_m() != nullptr) {
    RETURN_IF_BAD(check_grid(*map.damping_n_s_per_m(), map.columns(), map.rows(), kMaxMapSamples,
                             "points of a map", 0.0F, kMaxDamping_N_s_m, pauses));
  }
  return require(in_range(map.cell_m(), kMinSpacing_m, kMaxCoordinate_m) && is_coordinate(*map.origin_m()) &&
                     is_unit(*map.u()) && is_unit(*map.v()),
                 ImageStatus::kBadNumber);
}

}  // namespace

ImageVerdict check_surface(const scene::Object& object, Pauses& pauses) noexcept {
  const scene::Surface* surface = object.surface();
  if (surface == nullptr) return ImageStatus::kOk;
  if (surface->click() != nullptr) RETURN_IF_BAD(check_click(*surface->click()));
  RETURN_IF_BAD(require(in_range(surface->brake_friction(), 0.0F, kMaxFriction), ImageStatus::kBadNumber));
  if (surface->texture() != nullptr) RETURN_IF_BAD(check_texture(*surface->texture(), pauses));
  if (surface->stiffness_map() != nullptr) RETURN_IF_BAD(check_map(*surface->stiffness_map(), pauses));
  return ImageStatus::kOk;
}

}  // namespace thimble::control
