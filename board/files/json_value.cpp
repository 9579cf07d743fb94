#include "board/files/json_value.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

namespace thimble::board {
namespace {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row[b.size()];
}

constexpr double kAnyNumber = 1.0e9;
constexpr double kLeastLength = 1.0e-6;

}  // namespace

std::string listed(Words words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "\"" : ", \"") + std::string(word) + "\"";
  return text;
}

std::string suggestion(std::string_view given, Words words) {
  std::string_view best;
  std::size_t least = given.size() / 3 + 2;
  for (const std::string_view word : words) {
    const std::size_t distance = edit_distance(given.substr(0, 100), word);
    // The beginning of a key ("stiffness" for "stiffness_N_m") is close too.
    const bool stem = given.size() >= 4 && word.starts_with(given);
    if (distance < least || (stem && best.empty())) {
      least = std::min(least, distance);
      best = word;
    }
  }
  const std::string all = words.empty() ? "there is none" : "allowed: " + listed(words);
  return best.empty() ? all : "did you mean \"" + std::string(best) + "\"? " + all;
}

double as_written(float value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value).ptr;
  double read = 0;
  std::from_chars(text.data(), end, read);
  return read;
}

std::string number(double value) {
  const auto single = static_cast<float>(value);
  if (static_cast<double>(single) == value) return nlohmann::json(as_written(single)).dump();
  std::string text = nlohmann::json(value).dump();
  constexpr std::ptrdiff_t kWritten = 12;  // digits that a person might write; a computed value has up to 17
  const auto digits = std::count_if(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
  if (digits <= kWritten) return text;
  constexpr int kDigits = 7;
  std::array<char, 32> rounded{};
  const auto end = std::to_chars(rounded.data(), rounded.data() + rounded.size(), value,
                                 std::chars_format::scientific, kDigits - 1)
                       .ptr;
  std::from_chars(rounded.data(), end, value);
  return nlohmann::json(value).dump();
}

std::string describe(const Range& range) {
  return std::string("a number ") + (range.least_excluded ? "above " : "from ") + number(range.least) +
         (range.least_excluded ? " and at most " : " to ") + number(range.most) +
         (*range.unit != '\0' ? " " : "") + range.unit;
}

void JsonValue::fail(const std::string& name, const std::string& cause, const std::string& remedy) const {
  throw JsonError(name, place() + " " + cause, remedy);
}

void JsonValue::wrong(const std::string& allowed) const {
  std::string given = value_.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  if (given.size() > 60) given = given.substr(0, 57) + "...";
  fail("bad-value", "is " + given + ", allowed is " + allowed, "give " + allowed);
}

const JsonValue& JsonValue::object(const char* what, Words keys) const {
  if (!value_.is_object()) wrong(std::string("an object (") + what + ") with the keys " + listed(keys));
  for (const auto& [key, child] : value_.items()) {
    if (std::find(keys.begin(), keys.end(), key) != keys.end()) continue;
    JsonValue(document_, child, pointer_ + "/" + pointer_step(key))
        .fail("unknown-key", std::string("is not a key of ") + what + "; " + suggestion(key, keys),
              "correct the key");
  }
  return *this;
}

JsonValue JsonValue::at(std::string_view key) const {
  if (!has(key)) {
    const std::string name(key);
    fail("missing-key", "has no \"" + name + "\"", "add \"" + name + "\"");
  }
  return {document_, value_.at(std::string(key)), pointer_ + "/" + pointer_step(std::string(key))};
}

JsonValue JsonValue::at(std::size_t index) const {
  return {document_, value_.at(index), pointer_ + "/" + std::to_string(index)};
}

std::size_t JsonValue::size(std::size_t least, std::size_t most) const {
  if (!value_.is_array() || value_.size() < least || value_.size() > most)
    wrong("an array of " + std::to_string(least) + (least == most ? "" : " to " + std::to_string(most)) +
          " values");
  return value_.size();
}

double JsonValue::number(const Range& range) const {
  const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!range.holds(value)) wrong(describe(range));
  return value;
}

int JsonValue::integer(int least, int most) const {
  const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
  if (!(value >= least && value <= most) || std::trunc(value) != value)
    wrong("a whole number from " + std::to_string(least) + " to " + std::to_string(most));
  return static_cast<int>(value);
}

std::vector<double> JsonValue::numbers(const Range& range, std::size_t most) const {
  std::vector<double> values(size(0, most));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = at(i).number(range);
  return values;
}

Eigen::Vector3d JsonValue::vector(const Range& range) const {
  if (!value_.is_array() || value_.size() != 3) wrong("an array of three numbers [x, y, z]");
  return {at(std::size_t{0}).number(range), at(std::size_t{1}).number(range),
          at(std::size_t{2}).number(range)};
}

Eigen::Vector3d JsonValue::direction() const {
  const Eigen::Vector3d given = vector({-kAnyNumber, kAnyNumber});
  if (given.norm() < kLeastLength) wrong("a direction, of any length but zero");
  return given.normalized();
}

bool JsonValue::boolean() const {
  if (!value_.is_boolean()) wrong("true or false");
  return value_.get<bool>();
}

std::string JsonValue::text(std::size_t most_bytes) const {
  if (!value_.is_string() || value_.get_ref<const std::string&>().empty() ||
      value_.get_ref<const std::string&>().size() > most_bytes)
    wrong("a string of 1 to " + std::to_string(most_bytes) + " bytes");
  return value_.get<std::string>();
}

std::size_t JsonValue::word(Words words) const {
  const auto found = value_.is_string()
                         ? std::find(words.begin(), words.end(), value_.get_ref<const std::string&>())
                         : words.end();
  if (found == words.end()) wrong("one of " + listed(words));
  return static_cast<std::size_t>(found - words.begin());
}

}  // namespace thimble::board
