// The keys of a sweep plan. docs/sweep.md is compared with the table.
#pragma once

#include "host-tools/keys/keys.h"

namespace thimble::host {

// "sweep" is the whole file.
[[nodiscard]] const KeyTable& sweep_kinds();
[[nodiscard]] const FileKind& sweep_kind(std::string_view name);

}  // namespace thimble::host
