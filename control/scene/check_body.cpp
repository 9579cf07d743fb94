#include "control/scene/check.h"

namespace thimble::control {

ImageStatus check_body(const scene::Object& object) noexcept {
  return require(object.body() == nullptr, ImageStatus::kNoShape);
}

}  // namespace thimble::control
