// One value of a JSON file with its position: checked access, and errors with file, JSON pointer, value and
// allowed range. Used by the reader of the board's configuration.
#pragma once

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace thimble::board {

class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class JsonValue {
 public:
  // Both must outlive it.
  JsonValue(const std::string& file, const nlohmann::json& value, std::string pointer = "")
      : file_(file), value_(value), pointer_(std::move(pointer)) {}

  [[noreturn]] void fail(const std::string& cause) const {
    throw ConfigError(file_ + ": " + (pointer_.empty() ? "/" : pointer_) + " " + cause);
  }
  [[noreturn]] void wrong(const std::string& allowed) const {
    std::string given = value_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (given.size() > 60) given = given.substr(0, 57) + "...";
    fail("is " + given + ", allowed is " + allowed);
  }

  // Checks that this value is an object; keys that are not listed are an error.
  const JsonValue& object(std::span<const std::string_view> keys) const {
    std::string all;
    for (const std::string_view key : keys) all += (all.empty() ? "\"" : ", \"") + std::string(key) + "\"";
    if (!value_.is_object()) wrong("an object with the keys " + all);
    for (const auto& [key, unused] : value_.items())
      if (std::find(keys.begin(), keys.end(), key) == keys.end())
        at(key).fail("is no key here; allowed: " + all);
    return *this;
  }
  template <std::size_t kCount>
  const JsonValue& object(const std::array<std::string_view, kCount>& keys) const {
    return object(std::span<const std::string_view>(keys));
  }

  [[nodiscard]] bool has(const std::string& key) const { return value_.contains(key); }
  [[nodiscard]] JsonValue at(const std::string& key) const {
    if (!has(key)) fail("has no \"" + key + "\"");
    return {file_, value_.at(key), pointer_ + "/" + key};
  }
  [[nodiscard]] std::size_t size(std::size_t least, std::size_t most) const {
    if (!value_.is_array() || value_.size() < least || value_.size() > most)
      wrong("an array of " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
            " values");
    return value_.size();
  }
  [[nodiscard]] JsonValue at(std::size_t index) const {
    return {file_, value_.at(index), pointer_ + "/" + std::to_string(index)};
  }

  [[nodiscard]] double number(double least, double most) const {
    if (!value_.is_number() || !(value_.get<double>() >= least && value_.get<double>() <= most))
      wrong("a number from " + nlohmann::json(least).dump() + " to " + nlohmann::json(most).dump());
    return value_.get<double>();
  }
  [[nodiscard]] int integer(int least, int most) const {
    if (!value_.is_number_integer() || value_.get<double>() < least || value_.get<double>() > most)
      wrong("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
    return value_.get<int>();
  }
  [[nodiscard]] bool boolean() const {
    if (!value_.is_boolean()) wrong("true or false");
    return value_.get<bool>();
  }
  [[nodiscard]] std::string text(std::size_t most_bytes = 200) const {
    if (!value_.is_string() || value_.get_ref<const std::string&>().empty() ||
        value_.get_ref<const std::string&>().size() > most_bytes)
      wrong("a string of 1 to " + std::to_string(most_bytes) + " bytes");
    return value_.get<std::string>();
  }
  // The place of the word among those allowed.
  template <std::size_t kCount>
  [[nodiscard]] std::size_t word(const std::array<std::string_view, kCount>& words) const {
    std::string all;
    for (std::size_t i = 0; i < kCount; ++i) {
      if (value_.is_string() && value_.get_ref<const std::string&>() == words[i]) return i;
      all += (all.empty() ? "\"" : ", \"") + std::string(words[i]) + "\"";
    }
    wrong("one of " + all);
  }

 private:
  const std::string& file_;
  const nlohmann::json& value_;
  std::string pointer_;
};

}  // namespace thimble::board
