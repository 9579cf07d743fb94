// Whether a scene image is another one in other materials. Then it can take that one's place while a fingertip touches it: contacts,
// objects that move and tissue go on as they are (Renderer::bind). Asked in the background when an upload has been verified.
#pragma once

#include <cstddef>
#include <span>

#include "control/scene/pauses.h"
#include "control/scene/scene_view.h"

namespace thimble::control {

// Both images are checked, and a_view and b_view are theirs. True when not a byte differs outside the objects' materials.
// O(bytes), but the first difference ends it; with breaks.
[[nodiscard]] bool differs_in_materials_only(std::span<const std::byte> a, const SceneView& a_view,
                                             std::span<const std::byte> b, const SceneView& b_view,
                                             Pause pause = nullptr) noexcept;

}  // namespace thimble::control
