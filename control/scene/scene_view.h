// The validated view of a scene image: the only way from bytes to the renderer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "control/scene/image_verdict.h"
#include "control/scene/pauses.h"

namespace thimble::scene {
struct Scene;
}

namespace thimble::control {

// How a scene is taken: from its start, or as the one that is bound in other materials, with all else as it is now. The second only
// where differs_in_materials_only() (control/scene/same_shapes.h) has said so.
enum class Binding : std::uint8_t { kStart, kGoOn };

// Refers to the bytes that were checked; they must stay unchanged and in place for as long as the view is
// used.
class SceneView {
 public:
  // Verifies bytes (FlatBuffers, then numbers, ranges and tree) and sets `view` when they are sound; `view`
  // is untouched otherwise. Cost O(bytes), with breaks. Never reads outside `bytes`, whatever they hold.
  [[nodiscard]] static ImageVerdict check(std::span<const std::byte> bytes, SceneView& view,
                                          Pause pause = nullptr) noexcept;

  [[nodiscard]] const scene::Scene* scene() const noexcept { return scene_; }  // null: the empty scene

 private:
  const scene::Scene* scene_ = nullptr;
};

}  // namespace thimble::control
