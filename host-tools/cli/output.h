// Output that all verbs share: JSON with a schema version on stdout, messages on stderr.
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "firmware/link/messages.h"
#include "host-tools/client/flag_names.h"
#include "host-tools/error.h"

namespace thimble::host {

inline constexpr int kJsonSchema = 2;
using Json = nlohmann::ordered_json;

// fmt::print() for a terminal: names come from devices and files, so control characters are shown (printable.h).
void vsay(std::FILE* to, fmt::string_view format, fmt::format_args arguments);
template <class... T>
void say(std::FILE* to, fmt::format_string<T...> format, T&&... values) {
  vsay(to, format, fmt::make_format_args(values...));
}
template <class... T>
void say(fmt::format_string<T...> format, T&&... values) {
  vsay(stdout, format, fmt::make_format_args(values...));
}

// {"schema": 2, "verb": verb}: the beginning of every document.
[[nodiscard]] Json document(std::string_view verb);
void print(const Json& document);       // stdout, indented
void print_line(const Json& document);  // stdout, one line, flushed: streams
// What was printed is the result of the command: throws Error (kRefused, "cannot-write") where it could not be written. A reader that went away
// wanted no more.
void demand_written();

// On stderr, as text or JSON.
void report(const Error& error, bool json);

// The double that prints like the float: 0.1F as 0.1.
[[nodiscard]] double tidy(float value);

// A number of messages.def: an enum by its name, flags as a list of names.
template <class Row, class Value>
[[nodiscard]] Json number_json(const Row& /*row*/, const Value& value) {
  if constexpr (firmware::link::TableEnum<Value>) {
    return firmware::link::name(value);
  } else if constexpr (!std::is_void_v<typename Row::Flags>) {
    return flag_names<typename Row::Flags>(value);
  } else if constexpr (std::is_same_v<Value, float>) {
    return tidy(value);
  } else {
    return value;
  }
}

// A message of messages.def, field by field under its names.
template <class Message>
[[nodiscard]] Json to_json(const Message& message) {
  Json json = Json::object();
  firmware::link::visit_fields(message, [&json](auto row, const auto& value) {
    using Field = std::remove_cvref_t<decltype(value)>;
    if constexpr (firmware::link::kIsPart<Field>) {
      json[row.name] = to_json(value);
    } else if constexpr (firmware::link::kIsArray<Field>) {
      json[row.name] = Json::array();
      for (const auto& one : value) json[row.name].push_back(number_json(row, one));
    } else {
      json[row.name] = number_json(row, value);
    }
  });
  return json;
}

}  // namespace thimble::host
