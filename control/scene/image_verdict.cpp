#include "control/scene/image_verdict.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace thimble::control {

const char* name(ImageStatus status) noexcept {
  switch (status) {
    case ImageStatus::kOk:
      return "ok";
    case ImageStatus::kTooLarge:
      return "too_large";
    case ImageStatus::kMisaligned:
      return "misaligned";
    case ImageStatus::kNotAScene:
      return "not_a_scene";
    case ImageStatus::kTooManyObjects:
      return "too_many_objects";
    case ImageStatus::kTooManyTriangles:
      return "too_many_triangles";
    case ImageStatus::kTooManyBodies:
      return "too_many_bodies";
    case ImageStatus::kTooManySamples:
      return "too_many_samples";
    case ImageStatus::kBadNumber:
      return "bad_number";
    case ImageStatus::kBadIndex:
      return "bad_index";
    case ImageStatus::kBadTree:
      return "bad_tree";
    case ImageStatus::kNoShape:
      return "no_shape";
  }
  return "unknown";
}

void write_text(const ImageVerdict& verdict, std::span<char> out) noexcept {
  if (out.empty()) return;
  std::size_t at = 0;
  const auto put = [&](std::string_view text) {
    const std::size_t length = std::min(text.size(), out.size() - 1 - at);
    std::copy_n(text.begin(), length, out.begin() + static_cast<std::ptrdiff_t>(at));
    at += length;
  };
  const auto put_number = [&](std::size_t number) {
    std::array<char, 20> digits{};  // of 2^64
    const std::to_chars_result end = std::to_chars(digits.data(), digits.data() + digits.size(), number);
    put({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  };
  put(name(verdict.status));
  if (verdict.what != nullptr) {
    put(": ");
    put_number(verdict.count);
    put(" ");
    put(verdict.what);
    put(", at most ");
    put_number(verdict.limit);
  }
  out[at] = '\0';
}

}  // namespace thimble::control
