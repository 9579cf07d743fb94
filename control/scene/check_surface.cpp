#include "control/scene/check.h"

namespace thimble::control {

ImageStatus check_surface(const scene::Object& object) noexcept {
  return require(object.surface() == nullptr, ImageStatus::kNoShape);
}

}  // namespace thimble::control
