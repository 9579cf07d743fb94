// The values of the rows of a table of keys, as in
//   .required("height_m", number(above(0, 10, "m")), "Metres per unit of the values.")
//   .optional("friction_N", number(from(0, 100, "N")).by_default(0))
#pragma once

#include <concepts>
#include <cstddef>
#include <initializer_list>
#include <string_view>

#include "host-tools/keys/keys.h"

namespace thimble::host::keys {

// As a double; a float with the digits of its source text: 0.1 for 0.1F.
template <typename Number>
[[nodiscard]] double written(Number value) {
  if constexpr (std::same_as<Number, float>)
    return board::as_written(value);
  else
    return static_cast<double>(value);
}

// Numbers from `least` to `most`.
template <typename Least, typename Most>
[[nodiscard]] Range from(Least least, Most most, const char* unit = "") {
  return {written(least), written(most), unit};
}

// Numbers above `least`, up to `most`.
template <typename Least, typename Most>
[[nodiscard]] Range above(Least least, Most most, const char* unit = "") {
  return {written(least), written(most), unit, true};
}

[[nodiscard]] inline KeyValue version() { return {KeyType::kVersion}; }
[[nodiscard]] inline KeyValue number(const Range& range) { return {KeyType::kNumber, range}; }
[[nodiscard]] inline KeyValue pair(const Range& range) { return {KeyType::kPair, range}; }
[[nodiscard]] inline KeyValue vector(const Range& range) { return {KeyType::kVector, range}; }
[[nodiscard]] inline KeyValue direction() { return {KeyType::kDirection, {-1.0e9, 1.0e9}}; }
[[nodiscard]] inline KeyValue text(std::size_t most_bytes) { return {KeyType::kText, from(1, most_bytes)}; }
[[nodiscard]] inline KeyValue one_of(std::initializer_list<std::string_view> words) {
  return {KeyType::kWord, {}, words};
}
[[nodiscard]] inline KeyValue flag() { return {KeyType::kFlag}; }
[[nodiscard]] inline KeyValue rows(const Range& range) { return {KeyType::kRows, range}; }
[[nodiscard]] inline KeyValue rows_or_file(const Range& range) { return {KeyType::kRowsOrFile, range}; }
[[nodiscard]] inline KeyValue quantity(const Range& range) { return {KeyType::kQuantity, range}; }
[[nodiscard]] inline KeyValue numbers(const Range& range, std::size_t least, std::size_t most) {
  KeyValue value{KeyType::kNumbers, range};
  value.count = from(least, most);
  return value;
}
[[nodiscard]] inline KeyValue curve(const Range& at, std::size_t most_points, double most_effort) {
  KeyValue value{KeyType::kCurve, at};
  value.count = from(1, most_points);
  value.most_effort = most_effort;
  return value;
}

// Of the kind, or of one of the kinds.
[[nodiscard]] inline KeyValue part(std::string_view kind) { return {KeyType::kPart, {}, {kind}}; }
[[nodiscard]] inline KeyValue one_part_of(std::initializer_list<std::string_view> kinds) {
  return {KeyType::kPart, {}, kinds};
}
[[nodiscard]] inline KeyValue list(std::string_view kind, std::size_t least, std::size_t most) {
  return {KeyType::kList, from(least, most), {kind}};
}
[[nodiscard]] inline KeyValue named_parts(std::string_view kind) {
  return {KeyType::kNamedParts, {}, {kind}};
}
[[nodiscard]] inline KeyValue part_or_name(std::string_view kind) {
  return {KeyType::kPartOrName, {}, {kind}};
}

}  // namespace thimble::host::keys
