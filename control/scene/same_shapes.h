// How a new scene image can replace another one while a fingertip is in contact (Renderer::bind). Called in the background after an upload
// was verified.
#pragma once

#include <cstddef>
#include <span>

#include "control/scene/pauses.h"
#include "control/scene/scene_view.h"

namespace thimble::control {

// By the checked views of the images. Other materials keep everything; what else is changed in a scene that keeps its name keeps places.
// O(bytes), with pauses.
[[nodiscard]] Binding binding_of(std::span<const std::byte> before, const SceneView& before_view,
                                 std::span<const std::byte> after, const SceneView& after_view,
                                 Pause pause = nullptr) noexcept;

// a_view and b_view are the checked views of the images. True when no byte differs outside the objects'
// materials. O(bytes), with pauses; it ends at the first other difference.
[[nodiscard]] bool differs_in_materials_only(std::span<const std::byte> a, const SceneView& a_view,
                                             std::span<const std::byte> b, const SceneView& b_view,
                                             Pause pause = nullptr) noexcept;

}  // namespace thimble::control
