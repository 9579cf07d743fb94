// The flags of a FLAG_SET of messages.def by their names.
#pragma once

#include <string>
#include <vector>

#include "firmware/link/messages.h"

namespace thimble::host {

// {"clamp", "thermal"} of the limiters 0x09; empty: no flag is set. Bits that the table does not name are left out.
template <firmware::link::TableEnum Set>
[[nodiscard]] std::vector<std::string> flag_names(unsigned bits) {
  std::vector<std::string> names;
  for (const firmware::link::EnumRow& row : firmware::link::EnumTable<Set>::kRows)
    if ((bits & row.number) != 0) names.emplace_back(row.name);
  return names;
}

}  // namespace thimble::host
