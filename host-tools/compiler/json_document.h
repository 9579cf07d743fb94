// JSON text with a line for every value, so that an error can say where. Used by the scene reader only.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

namespace thimble::host {

class JsonDocument {
 public:
  // `name` stands in messages. Throws Error (kBadInput) for text that is not JSON (RFC 8259, UTF-8), that
  // repeats a key, or that nests deeper than 32.
  JsonDocument(const std::string& text, std::string name);

  [[nodiscard]] const nlohmann::json& root() const { return root_; }

  // "file:line: /pointer"; a pointer to something that is not there takes the line of its parent.
  [[nodiscard]] std::string place(const std::string& pointer) const;

 private:
  void find_lines(const std::string& text);

  nlohmann::json root_;
  std::string name_;
  std::map<std::string, std::size_t> line_of_;  // by JSON pointer
};

// A key as a step of a JSON pointer (RFC 6901).
[[nodiscard]] std::string pointer_step(const std::string& key);

}  // namespace thimble::host
