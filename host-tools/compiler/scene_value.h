// One value of a scene file's JSON and where it is: typed, checked access, and errors that name file, line, JSON
// pointer, the value and what is allowed. Every reader of a part of the scene file takes one.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/compiler/json_document.h"
#include "host-tools/error.h"

namespace thimble::host {

using Keys = std::span<const std::string_view>;

[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

template <typename Words>
std::string listed(const Words& words) {
  std::string text;
  for (const auto& word : words) {
    text += (text.empty() ? "\"" : ", \"") + std::string(word) + "\"";
  }
  return text;
}

// "did you mean ...?" when one of the words is close, and the list of them all.
template <typename Words>
std::string suggestion(std::string_view given, const Words& words) {
  std::string_view best;
  std::size_t least = given.size() / 3 + 2;
  for (const std::string_view word : words) {
    const std::size_t distance = edit_distance(given.substr(0, 100), word);
    // Half a key ("stiffness" for "stiffness_N_m") is close too.
    const bool stem = given.size() >= 4 && word.starts_with(given);
    if (distance < least || (stem && best.empty())) {
      least = std::min(least, distance);
      best = word;
    }
  }
  const std::string all = words.empty() ? "there is none" : "allowed: " + listed(words);
  return best.empty() ? all : "did you mean \"" + std::string(best) + "\"? " + all;
}

struct Range {
  double least;
  double most;
  bool least_excluded = false;
  const char* unit = "";
};

[[nodiscard]] std::string number(double value);
[[nodiscard]] std::string describe(const Range& range);

// One value of the document and where it is.
class Value {
 public:
  Value(const JsonDocument& document, const nlohmann::json& value, std::string pointer)
      : document_(document), value_(value), pointer_(std::move(pointer)) {}

  [[noreturn]] void fail(const std::string& slug, const std::string& cause, const std::string& remedy) const {
    throw Error(ExitCode::kBadInput, slug, document_.place(pointer_) + " " + cause, remedy);
  }
  [[noreturn]] void wrong(const std::string& allowed) const {
    std::string given = value_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    if (given.size() > 60) {
      given = given.substr(0, 57) + "...";
    }
    fail("bad-value", "is " + given + ", allowed is " + allowed, "give " + allowed);
  }

  [[nodiscard]] const nlohmann::json& raw() const { return value_; }
  [[nodiscard]] std::string place() const { return document_.place(pointer_); }

  // This value as an object with these keys, of which no other may occur.
  const Value& object(const char* what, Keys keys) const {
    if (!value_.is_object()) {
      wrong(std::string("an object (") + what + ") with the keys " + listed(keys));
    }
    for (const auto& [key, child] : value_.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        Value(document_, child, pointer_ + "/" + pointer_step(key))
            .fail("unknown-key", std::string("is not a key of ") + what + "; " + suggestion(key, keys),
                  "correct the key");
      }
    }
    return *this;
  }

  [[nodiscard]] bool has(std::string_view key) const { return value_.contains(key); }
  [[nodiscard]] Value at(std::string_view key) const {
    if (!has(key)) {
      fail("missing-key", "has no \"" + std::string(key) + "\"", "add \"" + std::string(key) + "\"");
    }
    return {document_, value_.at(std::string(key)), pointer_ + "/" + pointer_step(std::string(key))};
  }
  [[nodiscard]] Value at(std::size_t index) const {
    return {document_, value_.at(index), pointer_ + "/" + std::to_string(index)};
  }

  [[nodiscard]] double as_number(const Range& range) const {
    const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(range.least_excluded ? value > range.least : value >= range.least) || !(value <= range.most)) {
      wrong(describe(range));
    }
    return value;
  }
  [[nodiscard]] Eigen::Vector3d as_vector(const Range& range) const {
    if (!value_.is_array() || value_.size() != 3) {
      wrong("an array of three numbers [x, y, z]");
    }
    return {at(std::size_t{0}).as_number(range), at(std::size_t{1}).as_number(range),
            at(std::size_t{2}).as_number(range)};
  }
  [[nodiscard]] std::string as_text(std::size_t most_bytes) const {
    if (!value_.is_string() || value_.get_ref<const std::string&>().empty() ||
        value_.get_ref<const std::string&>().size() > most_bytes) {
      wrong("a string of 1 to " + std::to_string(most_bytes) + " bytes");
    }
    return value_.get<std::string>();
  }
  // The index of the word among those allowed.
  template <std::size_t kCount>
  [[nodiscard]] std::size_t as_word(const std::array<std::string_view, kCount>& words) const {
    const auto found = value_.is_string()
                           ? std::find(words.begin(), words.end(), value_.get_ref<const std::string&>())
                           : words.end();
    if (found == words.end()) {
      wrong("one of " + listed(words));
    }
    return static_cast<std::size_t>(found - words.begin());
  }

  [[nodiscard]] double number_or(std::string_view key, const Range& range, double otherwise) const {
    return has(key) ? at(key).as_number(range) : otherwise;
  }

 private:
  const JsonDocument& document_;
  const nlohmann::json& value_;
  std::string pointer_;
};

inline constexpr double kMaxCoordinate = static_cast<double>(control::kMaxCoordinate_m);
inline constexpr double kMinLength = 1.0e-5;
inline constexpr Range kLength{kMinLength, kMaxCoordinate, false, "m"};
inline constexpr Range kCoordinate{-kMaxCoordinate, kMaxCoordinate, false, "m"};

}  // namespace thimble::host
