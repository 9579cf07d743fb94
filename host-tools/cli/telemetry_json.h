// A message of a device's telemetry as a document: a line of `thimble monitor --json`, and what `thimble publish` sends.
#pragma once

#include <cstdint>

#include "host-tools/cli/output.h"

namespace thimble::host {

template <class Message>
[[nodiscard]] Json telemetry_json(std::uint8_t node, const Message& message) {
  Json json;
  json["schema"] = kJsonSchema;
  json["message"] = Message::kName;
  json["node"] = node;
  json.update(to_json(message));
  return json;
}

}  // namespace thimble::host
