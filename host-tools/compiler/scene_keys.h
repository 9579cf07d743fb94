// The keys of a scene file: the one place for their types, units, ranges, defaults and words. The readers
// (scene_value.h) check against this table, scene.schema.json is generated from it, and docs/scene-format.md is
// compared with it (scene_keys_test.cpp). To add a key, add a row in scene_keys.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "board/files/json_value.h"

namespace thimble::host {

using board::Range;

enum class KeyType : std::uint8_t {
  kVersion,     // the number 1
  kNumber,      // within `range`
  kPair,        // [x, y], each within `range`
  kVector,      // [x, y, z], each within `range`
  kDirection,   // [x, y, z], of any length but zero
  kText,        // a string; `range` is its length in bytes
  kWord,        // one of `words`
  kFlag,        // true or false
  kPart,        // an object of the kind words[0], or of one of several kinds
  kList,        // an array of parts; `range` is its length
  kNamedParts,  // an object of parts by name
  kPartOrName,  // a part, or the name of one
  kRows,        // rows of numbers, each within `range`
  kRowsOrFile,  // the same, or the path of a file of them
  kCurve,       // points [at, effort], rising in at within `range`; effort within control::kMaxControlEffort
};

// What the value of a key may be.
struct KeyValue {
  KeyType type;
  Range range{};
  std::vector<std::string_view> words{};
  std::vector<double> default_numbers{};  // of a number or flag one, of a vector three
  std::string_view default_word{};        // of a kWord

  // The same with a default.
  [[nodiscard]] KeyValue by_default(double number) const;
  [[nodiscard]] KeyValue by_default(double x, double y, double z) const;
  [[nodiscard]] KeyValue by_default(std::string_view word) const;
};

struct SceneKey : KeyValue {
  std::string_view name;
  bool required;
  std::string_view text;  // for people
};

struct SceneKind {
  std::string_view name;    // "plane": under $defs in the schema
  const char* what;         // "a plane", in errors
  std::string_view text{};  // for people
  std::vector<SceneKey> keys{};
  bool exactly_one = false;                   // of its keys
  std::vector<std::string_view> key_names{};  // of `keys`

  // Each adds a key. scene_key_values.h has the functions that make its value.
  SceneKind& required(std::string_view key, KeyValue value, std::string_view for_people = {});
  SceneKind& optional(std::string_view key, KeyValue value, std::string_view for_people = {});
  // A key of a kind that has exactly one of its keys.
  SceneKind& alternative(std::string_view key, KeyValue value, std::string_view for_people = {});
};

[[nodiscard]] const std::vector<SceneKind>& scene_kinds();
// std::logic_error if there is none.
[[nodiscard]] const SceneKind& scene_kind(std::string_view name);
[[nodiscard]] const SceneKey& scene_key(const SceneKind& kind, std::string_view name);

// The text of scene.schema.json (JSON Schema 2020-12).
[[nodiscard]] std::string scene_schema();

}  // namespace thimble::host
