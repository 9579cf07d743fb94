// The keys of an arm file. docs/arm-format.md is compared with the table (arm_keys_test.cpp). To add a key, add a row in arm_keys.cpp.
#pragma once

#include <string>

#include "host-tools/keys/keys.h"

namespace thimble::host {

[[nodiscard]] const KeyTable& arm_kinds();

// The text of arm.schema.json (JSON Schema 2020-12).
[[nodiscard]] std::string arm_schema();

}  // namespace thimble::host
