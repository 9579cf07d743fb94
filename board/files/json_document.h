// JSON text with the line of every value, so that an error can say where. JsonValue (json_value.h) reads it.
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace thimble::board {

// what(): "file:line: /pointer is 5, allowed is ...".
class JsonError : public std::runtime_error {
 public:
  JsonError(std::string slug, const std::string& cause, std::string what_to_do)
      : std::runtime_error(cause), name(std::move(slug)), remedy(std::move(what_to_do)) {}
  std::string name;    // "bad-value"
  std::string remedy;  // what to do next
};

class JsonDocument {
 public:
  // `name` stands in errors; root: what the whole is called there, "the scene". Throws JsonError for text that is not JSON
  // (RFC 8259, UTF-8), that repeats a key, nests deeper than 32, or has a JSON pointer of more than 256 bytes.
  JsonDocument(const std::string& text, std::string name, std::string root);

  [[nodiscard]] const nlohmann::json& root() const { return root_; }

  // "file:line: /pointer"; a pointer to something that is not there takes the line of its parent.
  [[nodiscard]] std::string place(const std::string& pointer) const;

 private:
  void find_lines(const std::string& text);

  nlohmann::json root_;
  std::string name_;
  std::string root_name_;
  std::map<std::string, std::size_t> line_of_;  // by JSON pointer
};

// A key as a step of a JSON pointer (RFC 6901).
[[nodiscard]] std::string pointer_step(const std::string& key);

}  // namespace thimble::board
