// The validated view of a scene image: the only way from bytes to the renderer.
#pragma once

#include <cstddef>
#include <span>

#include "control/scene/image_verdict.h"
#include "control/scene/pauses.h"

namespace thimble::scene {
struct Scene;
}

namespace thimble::control {

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
