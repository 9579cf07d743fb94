// The keys of a scene file. docs/scene-format.md is compared with the table (scene_keys_test.cpp). To add a key, add a row in
// scene_keys.cpp.
#pragma once

#include <string>
#include <string_view>

#include "host-tools/keys/keys.h"

namespace thimble::host {

[[nodiscard]] const KeyTable& scene_kinds();
// std::logic_error if there is none.
[[nodiscard]] const FileKind& scene_kind(std::string_view name);

// The text of scene.schema.json (JSON Schema 2020-12).
[[nodiscard]] std::string scene_schema();

}  // namespace thimble::host
