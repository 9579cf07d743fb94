#include "control/scene/check.h"

namespace thimble::control {

ImageStatus check_volume(const scene::Object&) noexcept { return ImageStatus::kNoShape; }

}  // namespace thimble::control
