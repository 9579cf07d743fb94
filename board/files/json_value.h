// One value of a JSON file and its place: typed, checked access, and errors that name file, line, JSON pointer, the value and
// what is allowed. The readers of scene files, scan plans, specimens and board configurations use it.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "board/files/json_document.h"

namespace thimble::board {

// Words that are allowed: keys of an object, or values.
using Words = std::span<const std::string_view>;

[[nodiscard]] std::string listed(Words words);  // "a", "b"
// "did you mean ...?" if one of the words is close, and the list of them all.
[[nodiscard]] std::string suggestion(std::string_view given, Words words);

// Numbers from least (or above it) to most, in `unit`.
struct Range {
  double least;
  double most;
  const char* unit = "";
  bool least_excluded = false;

  [[nodiscard]] bool holds(double value) const {
    return (least_excluded ? value > least : value >= least) && value <= most;
  }
};
// The double with the digits of the float: 0.1 for 0.1F.
[[nodiscard]] double as_written(float value);
// As JSON: 10.0, 1e-05. A float's value has the digits of the float; a value with more digits than a person writes has 7.
[[nodiscard]] std::string number(double value);
[[nodiscard]] std::string describe(const Range& range);

// The document must outlive it. Every function that fails throws JsonError.
class JsonValue {
 public:
  explicit JsonValue(const JsonDocument& document) : JsonValue(document, document.root(), "") {}
  JsonValue(const JsonDocument& document, const nlohmann::json& value, std::string pointer)
      : document_(document), value_(value), pointer_(std::move(pointer)) {}

  // cause: what follows the place, "is 5, ...".
  [[noreturn]] void fail(const std::string& name, const std::string& cause, const std::string& remedy) const;
  // "is VALUE, allowed is ALLOWED".
  [[noreturn]] void wrong(const std::string& allowed) const;

  [[nodiscard]] const nlohmann::json& raw() const { return value_; }
  [[nodiscard]] std::string place() const { return document_.place(pointer_); }

  // Checks that this is an object with no other keys than these. what: "a plane".
  const JsonValue& object(const char* what, Words keys) const;
  const JsonValue& object(const char* what, std::initializer_list<std::string_view> keys) const {
    return object(what, Words(keys.begin(), keys.size()));
  }
  [[nodiscard]] bool has(std::string_view key) const { return value_.contains(key); }
  [[nodiscard]] JsonValue at(std::string_view key) const;  // the key is required
  [[nodiscard]] JsonValue at(std::size_t index) const;

  [[nodiscard]] std::size_t size(std::size_t least, std::size_t most) const;  // of an array
  [[nodiscard]] double number(const Range& range) const;
  [[nodiscard]] double number_or(std::string_view key, const Range& range, double otherwise) const {
    return has(key) ? at(key).number(range) : otherwise;
  }
  [[nodiscard]] int integer(int least, int most) const;
  [[nodiscard]] std::vector<double> numbers(const Range& range, std::size_t most) const;
  [[nodiscard]] Eigen::Vector3d vector(const Range& range) const;  // [x, y, z]
  [[nodiscard]] Eigen::Vector3d direction() const;  // [x, y, z] of any length but zero; normalised
  [[nodiscard]] bool boolean() const;
  [[nodiscard]] std::string text(std::size_t most_bytes = 200) const;  // at least 1 byte
  [[nodiscard]] std::size_t word(Words words) const;                   // the index of the word
  [[nodiscard]] std::size_t word(std::initializer_list<std::string_view> words) const {
    return word(Words(words.begin(), words.size()));
  }

 private:
  const JsonDocument& document_;
  const nlohmann::json& value_;
  std::string pointer_;
};

}  // namespace thimble::board
