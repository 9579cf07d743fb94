// The checked view of a scene image. The renderer takes nothing else.
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

// How a scene is bound. kStart: from its start. kKeepPlaces: from its start too, but for fingertips in contact, and for moving objects and
// volumes that are in both scenes: each contact begins where the god object is, and each of these objects goes on, so what is the same is
// felt on. kKeepState: with new materials only, while everything else keeps its state; only when differs_in_materials_only()
// (control/scene/same_shapes.h) returned true.
enum class Binding : std::uint8_t { kStart, kKeepPlaces, kKeepState };

// Refers to the checked bytes. They must stay unchanged and at their address as long as the view is used.
class SceneView {
 public:
  // Checks the bytes (FlatBuffers verifier, then numbers, ranges and trees) and sets `view` when they are
  // valid; otherwise `view` is unchanged. O(bytes), with pauses. Never reads outside `bytes`, whatever they
  // contain.
  [[nodiscard]] static ImageVerdict check(std::span<const std::byte> bytes, SceneView& view,
                                          Pause pause = nullptr) noexcept;

  [[nodiscard]] const scene::Scene* scene() const noexcept { return scene_; }  // null: the empty scene

 private:
  const scene::Scene* scene_ = nullptr;
};

}  // namespace thimble::control
