#include "control/scene/same_shapes.h"

#include <algorithm>
#include <array>

#include "control/scene/limits.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

using Offsets = std::array<std::ptrdiff_t, kMaxObjects>;  // of the materials in an image

std::size_t material_offsets(std::span<const std::byte> image, const scene::Scene& scene,
                             Offsets& offsets) noexcept {
  std::size_t count = 0;
  for (const scene::Object* object : *scene.objects()) {
    if (count == offsets.size()) break;
    offsets[count++] = reinterpret_cast<const std::byte*>(object->material()) - image.data();
  }
  return count;
}

}  // namespace

bool differs_in_materials_only(std::span<const std::byte> a, const SceneView& a_view,
                               std::span<const std::byte> b, const SceneView& b_view, Pause pause) noexcept {
  if (a.size() != b.size() || a_view.scene() == nullptr || b_view.scene() == nullptr) return false;
  Offsets in_a;
  Offsets in_b;
  const std::size_t count = material_offsets(a, *a_view.scene(), in_a);
  if (count != material_offsets(b, *b_view.scene(), in_b)) return false;
  const std::span<const std::ptrdiff_t> materials(in_a.data(), count);
  if (!std::equal(materials.begin(), materials.end(), in_b.begin())) return false;
  constexpr std::size_t kPiece = 4096;  // between two pauses
  std::size_t at = 0;
  while (at < a.size()) {  // each pass compares one piece, or skips one material
    const std::size_t bytes = std::min(kPiece, a.size() - at);
    const auto from = a.begin() + static_cast<std::ptrdiff_t>(at);
    const auto differs = std::mismatch(from, from + static_cast<std::ptrdiff_t>(bytes),
                                       b.begin() + static_cast<std::ptrdiff_t>(at))
                             .first;
    const std::ptrdiff_t place = differs - a.begin();
    at += bytes;
    if (differs != from + static_cast<std::ptrdiff_t>(bytes)) {
      constexpr auto kSize = static_cast<std::ptrdiff_t>(sizeof(scene::Material));
      const auto material = std::find_if(materials.begin(), materials.end(), [place](std::ptrdiff_t begin) {
        return begin <= place && place < begin + kSize;
      });
      if (material == materials.end()) return false;
      at = static_cast<std::size_t>(*material + kSize);
    }
    if (pause != nullptr) pause();
  }
  return true;
}

Binding binding_of(std::span<const std::byte> before, const SceneView& before_view,
                   std::span<const std::byte> after, const SceneView& after_view, Pause pause) noexcept {
  if (before_view.scene() == nullptr || after_view.scene() == nullptr) return Binding::kStart;
  if (differs_in_materials_only(before, before_view, after, after_view, pause)) return Binding::kKeepState;
  const bool edited = before_view.scene()->name()->string_view() == after_view.scene()->name()->string_view();
  return edited ? Binding::kKeepPlaces : Binding::kStart;
}

}  // namespace thimble::control
