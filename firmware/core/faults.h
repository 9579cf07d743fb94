// The faults of faults.def as an enum and a table. Used by the controller, the link and the host tools.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/texts.h"

namespace thimble::firmware {

enum class Fault : std::uint8_t {
  kNone = 0,
#define THIMBLE_FAULT(id, name, code, reaction, cause, remedy) name = (id),
#include "firmware/core/faults.def"
#undef THIMBLE_FAULT
};

enum class Reaction : std::uint8_t { kDamp, kZero };

struct FaultRow {
  Fault fault;
  const char* name;
  std::uint16_t emergency_code;
  Reaction reaction;
  const char* cause;
  const char* remedy;
};

inline constexpr FaultRow kFaultTable[] = {
#define THIMBLE_FAULT(id, name, code, reaction, cause, remedy) \
  {Fault::name, #name, code, Reaction::reaction, THIMBLE_TEXT(cause), THIMBLE_TEXT(remedy)},
#include "firmware/core/faults.def"
#undef THIMBLE_FAULT
};
inline constexpr std::size_t kFaultCount = sizeof(kFaultTable) / sizeof(kFaultTable[0]);

// The row of a fault; null for kNone and for a number that is no fault.
[[nodiscard]] constexpr const FaultRow* find_fault(Fault fault) noexcept {
  for (const FaultRow& row : kFaultTable)
    if (row.fault == fault) return &row;
  return nullptr;
}

}  // namespace thimble::firmware
