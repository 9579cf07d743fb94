// Every value of a file against the table of its keys, for a file in which the readers have found one error: they stop at the first. What
// depends on several keys, and lists of numbers, are the readers' alone.
#pragma once

#include <functional>

#include "host-tools/keys/part.h"

namespace thimble::host {

// kind: of the value, in `table`. `refuse` gets each error.
void check_keys(const Value& value, const FileKind& kind, const KeyTable& table,
                const std::function<void(const board::JsonError&)>& refuse);

}  // namespace thimble::host
