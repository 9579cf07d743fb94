// Every value of a scene file against the table of its keys (scene_keys.h), for a file in which the readers have found one error: they stop at
// the first. What depends on several keys, and lists of numbers, are the readers' alone.
#pragma once

#include <functional>

#include "host-tools/compiler/scene_value.h"

namespace thimble::host {

// `refuse` gets each error.
void check_keys(const Value& value, const FileKind& kind,
                const std::function<void(const board::JsonError&)>& refuse);

}  // namespace thimble::host
