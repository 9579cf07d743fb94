// The verdict of a scene image's check, as a string.
#pragma once

#include <array>
#include <string>

#include "control/scene/image_verdict.h"

namespace thimble::board {

[[nodiscard]] inline std::string text_of(const control::ImageVerdict& verdict) {
  std::array<char, 192> text{};
  control::write_text(verdict, text);
  return text.data();
}

}  // namespace thimble::board
