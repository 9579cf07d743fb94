// What every verb shares on its way out: JSON with a schema version, messages on stderr.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "firmware/link/messages.h"
#include "host-tools/error.h"

namespace thimble::host {

inline constexpr int kJsonSchema = 1;
using Json = nlohmann::ordered_json;

// {"schema": 1, "verb": verb}: the beginning of every document.
[[nodiscard]] Json document(std::string_view verb);
void print(const Json& document);       // stdout, indented
void print_line(const Json& document);  // stdout, one line, flushed: streams

// On stderr, as text or JSON.
void report(const Error& error, bool json);

// The double that prints like the float: 0.1F as 0.1.
[[nodiscard]] double tidy(float value);

// A message of messages.def, field by field under its names.
template <class Message>
[[nodiscard]] Json to_json(const Message& message) {
  Json json = Json::object();
  firmware::link::visit_fields(message, [&json](auto, const char* name, const auto& value, auto&&...) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, float>) {
      json[name] = tidy(value);
    } else {
      json[name] = value;
    }
  });
  return json;
}

}  // namespace thimble::host
