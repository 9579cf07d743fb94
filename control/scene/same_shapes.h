// Whether two scene images differ in materials only. Then the new image can replace the old one while a
// fingertip is in contact: contacts, moving objects and tissue keep their state (Renderer::bind). Called in
// the background after an upload was verified.
#pragma once

#include <cstddef>
#include <span>

#include "control/scene/pauses.h"
#include "control/scene/scene_view.h"

namespace thimble::control {

// a_view and b_view are the checked views of the images. True when no byte differs outside the objects'
// materials. O(bytes), with pauses; it ends at the first other difference.
[[nodiscard]] bool differs_in_materials_only(std::span<const std::byte> a, const SceneView& a_view,
                                             std::span<const std::byte> b, const SceneView& b_view,
                                             Pause pause = nullptr) noexcept;

}  // namespace thimble::control
