// The parameters of params.def: table, names and values. The background writes them and the tick reads them: each value is
// one word (firmware/exchange/word.h), so neither waits, and a value is never torn. Values last until power-off, unless they
// are saved (firmware/store/param_store.h).
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "firmware/exchange/word.h"
#include "firmware/texts.h"

namespace thimble::firmware {

enum class ParamType : std::uint8_t { kFloat, kUnsigned };
enum class Access : std::uint8_t { kAlways, kAtRest };
enum class Persistence : std::uint8_t { kThisSession, kPersistent };
enum class Recording : std::uint8_t { kNotRecorded, kRecorded, kMarked, kSwitches };

enum class Param : std::uint8_t {  // position in the table
#define THIMBLE_PARAM(id, name, unit, type, initial, min, max, access, persistent, recorded, text) name,
#include "firmware/params.def"
#undef THIMBLE_PARAM
  kCount
};
inline constexpr std::size_t kParamCount = static_cast<std::size_t>(Param::kCount);

struct ParamRow {
  std::uint16_t id;
  const char* name;
  const char* unit;
  ParamType type;
  float initial;
  float min;
  float max;
  Access access;
  Persistence persistent;
  Recording recorded;
  const char* text;
};

// A write of it is taken by one tick, and a recording goes on with it.
[[nodiscard]] constexpr bool marks(const ParamRow& row) noexcept {
  return row.recorded == Recording::kMarked || row.recorded == Recording::kSwitches;
}
[[nodiscard]] constexpr bool has_effect_on_forces(const ParamRow& row) noexcept {
  return row.recorded == Recording::kRecorded || row.recorded == Recording::kSwitches;
}

inline constexpr std::array<ParamRow, kParamCount> kParamTable = {{
#define THIMBLE_PARAM(id, name, unit, type, initial, min, max, access, persistent, recorded, text) \
  {id,                                                                                             \
   #name,                                                                                          \
   unit,                                                                                           \
   ParamType::type,                                                                                \
   static_cast<float>(initial),                                                                    \
   static_cast<float>(min),                                                                        \
   static_cast<float>(max),                                                                        \
   Access::access,                                                                                 \
   Persistence::persistent,                                                                        \
   Recording::recorded,                                                                            \
   THIMBLE_TEXT(text)},
#include "firmware/params.def"
#undef THIMBLE_PARAM
}};

[[nodiscard]] constexpr const ParamRow* find_param(std::uint16_t id) noexcept {
  for (const ParamRow& row : kParamTable)
    if (row.id == id) return &row;
  return nullptr;
}
[[nodiscard]] constexpr const ParamRow* find_param(std::string_view name) noexcept {
  for (const ParamRow& row : kParamTable)
    if (name == row.name) return &row;
  return nullptr;
}

[[nodiscard]] constexpr const ParamRow& row_of(Param param) noexcept {
  return kParamTable[static_cast<std::size_t>(param)];
}

enum class ParamStatus : std::uint8_t { kOk, kUnknown, kOutOfRange, kNotWhileArmed, kBusy };

// The link carries a value as 32 bits, little-endian like the records of messages.def: an IEEE float, or an
// unsigned number.
class Params {
 public:
  Params() noexcept;

  [[nodiscard]] float get(
      Param param) const noexcept;  // kUnsigned values are exact up to 2^24, as all maxima are
  [[nodiscard]] std::uint32_t get_unsigned(Param param) const noexcept;
  [[nodiscard]] bool on(Param param) const noexcept { return get_unsigned(param) != 0; }

  // `bits` is untouched unless kOk. at_rest: the motors are off.
  [[nodiscard]] ParamStatus read(std::uint16_t id, std::uint32_t& bits) const noexcept;
  // What write() would answer.
  [[nodiscard]] ParamStatus check(std::uint16_t id, std::uint32_t bits, bool at_rest) const noexcept;
  [[nodiscard]] ParamStatus write(std::uint16_t id, std::uint32_t bits, bool at_rest) noexcept;

 private:
  std::array<Value<std::uint32_t>, kParamCount> bits_;
};

}  // namespace thimble::firmware
