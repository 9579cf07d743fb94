// An object of a scene file, and the ranges that many of its keys have.
#pragma once

#include <string_view>

#include "control/scene/limits.h"
#include "host-tools/compiler/scene_keys.h"
#include "host-tools/keys/part.h"

namespace thimble::host {

class ScenePart : public FilePart {
 public:
  ScenePart(const Value& value, std::string_view kind) : FilePart(value, scene_kind(kind)) {}
};

inline constexpr double kMaxCoordinate = static_cast<double>(control::kMaxCoordinate_m);
inline constexpr Range kCoordinate{-kMaxCoordinate, kMaxCoordinate, "m"};
inline constexpr Range kLength{1.0e-5, kMaxCoordinate, "m"};

}  // namespace thimble::host
