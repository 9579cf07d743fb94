// An object of a file that is read by a table of keys (keys.h): the reader asks for a key, and the table says its range and its default.
// Every function throws board::JsonError for what the file has wrong, and std::logic_error for a key that the table does not have.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "board/files/json_value.h"
#include "host-tools/error.h"
#include "host-tools/keys/keys.h"

namespace thimble::host {

using board::describe;
using board::listed;
using board::number;
using board::suggestion;
using Value = board::JsonValue;

// A number with how it was found.
struct Quantity {
  double value = 0;
  double spread = 0;  // 0: not known
  std::string by;     // "commission 2026-12-01"; empty: the file has the number alone
};

class FilePart {
 public:
  // Checks that the value is an object with no other keys than the table's, and with exactly one where the table says so.
  FilePart(const Value& value, const FileKind& kind);

  [[nodiscard]] const Value& value() const { return value_; }
  [[nodiscard]] const FileKind& kind() const { return kind_; }
  [[nodiscard]] std::string only_key() const;  // of a kind that has exactly one key

  [[nodiscard]] bool has(std::string_view key) const { return value_.has(key); }
  [[nodiscard]] Value at(std::string_view key) const { return value_.at(key); }
  [[nodiscard]] const Range& range(std::string_view key) const { return key_of(kind_, key).range; }
  // Each: the value, or the table's default if the key is not there.
  [[nodiscard]] double number(std::string_view key) const;
  [[nodiscard]] Quantity quantity(std::string_view key) const;
  [[nodiscard]] std::vector<double> numbers(std::string_view key) const;  // that are required
  [[nodiscard]] Eigen::Vector3d vector(std::string_view key) const;
  [[nodiscard]] Eigen::Vector3d direction(std::string_view key) const;  // normalised
  [[nodiscard]] bool flag(std::string_view key) const;
  [[nodiscard]] std::size_t word(std::string_view key) const;  // index in the table's words
  [[nodiscard]] std::array<double, 2> pair(std::string_view key) const;
  [[nodiscard]] std::string text(std::string_view key) const;
  // The array, of an allowed length. Too long: the error `name`, "has 5 <things>, at most 4 are allowed".
  [[nodiscard]] Value list(std::string_view key, const char* name, const char* things,
                           const char* remedy) const;

 private:
  Value value_;
  const FileKind& kind_;
};

// As the error of the host tools.
[[nodiscard]] inline Error to_error(const board::JsonError& error) {
  return {ExitCode::kBadInput, error.name, error.what(), error.remedy};
}

}  // namespace thimble::host
