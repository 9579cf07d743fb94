// The numbers of messages.def in words.
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

// "the dead-man switch was released" of StoppedBy::kDeadMan; empty for a number that the table does not name.
template <firmware::link::TableEnum Enum>
[[nodiscard]] std::string description(Enum value) {
  for (const firmware::link::EnumRow& row : firmware::link::EnumTable<Enum>::kRows)
    if (row.number == static_cast<unsigned>(value)) return row.description;
  return {};
}

}  // namespace thimble::host
