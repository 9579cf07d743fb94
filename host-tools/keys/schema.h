// A table of keys as a JSON Schema (2020-12), for editors.
#pragma once

#include <string>

#include "host-tools/keys/keys.h"

namespace thimble::host {

// root: the kind of the whole file. The order of the text is that of the table.
[[nodiscard]] std::string schema_text(const std::string& title, const std::string& comment,
                                      const std::string& root, const KeyTable& table);

}  // namespace thimble::host
