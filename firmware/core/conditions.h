// The conditions of conditions.def as bits and as a table with a remedy for each. Used by the controller, the link and the host tools:
// it depends on nothing else.
#pragma once

#include <cstdint>
#include <string_view>

#include "firmware/texts.h"

namespace thimble::firmware {

// Unmet conditions, as bits. The numbers travel over the link.
using Conditions = std::uint32_t;
enum Condition : Conditions {
#define THIMBLE_CONDITION(bit, identifier, name, remedy) identifier = 1U << (bit),
#include "firmware/core/conditions.def"
#undef THIMBLE_CONDITION
};
inline constexpr Conditions kAnyCondition = ~Conditions{0};

struct ConditionRow {
  Condition bit;
  const char* name;
  const char* remedy;
};

inline constexpr ConditionRow kConditionTable[] = {
#define THIMBLE_CONDITION(bit, identifier, name, remedy) {identifier, #name, THIMBLE_TEXT(remedy)},
#include "firmware/core/conditions.def"
#undef THIMBLE_CONDITION
};

// The row of a condition by the name that a refusal has; null for any other word.
[[nodiscard]] constexpr const ConditionRow* find_condition(std::string_view name) noexcept {
  for (const ConditionRow& row : kConditionTable)
    if (name == row.name) return &row;
  return nullptr;
}

}  // namespace thimble::firmware
