// An object of a scene file that is read by the table of scene_keys.h: the reader asks for a key, and the table says its range and
// its default. Every function throws board::JsonError for what the file has wrong, and std::logic_error for a key that the table does
// not have.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

#include "board/files/json_value.h"
#include "control/scene/limits.h"
#include "host-tools/compiler/scene_keys.h"
#include "host-tools/error.h"

namespace thimble::host {

using board::describe;
using board::listed;
using board::number;
using board::suggestion;
using Value = board::JsonValue;

class ScenePart {
 public:
  // Checks that the value is an object with no other keys than the table's, and with exactly one where the table says so.
  ScenePart(const Value& value, std::string_view kind);

  [[nodiscard]] const Value& value() const { return value_; }
  [[nodiscard]] const SceneKind& kind() const { return kind_; }
  [[nodiscard]] std::string only_key() const;  // of a kind that has exactly one key

  [[nodiscard]] bool has(std::string_view key) const { return value_.has(key); }
  [[nodiscard]] Value at(std::string_view key) const { return value_.at(key); }
  [[nodiscard]] const Range& range(std::string_view key) const { return scene_key(kind_, key).range; }
  // Each: the value, or the table's default if the key is not there.
  [[nodiscard]] double number(std::string_view key) const;
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
  const SceneKind& kind_;
};

inline constexpr double kMaxCoordinate = static_cast<double>(control::kMaxCoordinate_m);
inline constexpr Range kCoordinate{-kMaxCoordinate, kMaxCoordinate, "m"};
inline constexpr Range kLength{1.0e-5, kMaxCoordinate, "m"};

// As the error of the host tools.
[[nodiscard]] inline Error to_error(const board::JsonError& error) {
  return {ExitCode::kBadInput, error.name, error.what(), error.remedy};
}

}  // namespace thimble::host
