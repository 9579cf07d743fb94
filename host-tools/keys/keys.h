// Tables of the keys of a file format: the one place for their types, units, ranges, defaults and words. Readers check against the table
// (part.h), its JSON Schema is generated from it (schema.h), and tests compare the documentation with it. Used by scene files and arm files.
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
  kQuantity,    // the same, or { "value", "spread", "by" }: a number with how it was found
  kNumbers,     // `count` numbers, each within `range`
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
  kCurve,       // points [at, effort], rising in at within `range`; effort within +-`most_effort`
};

// What the value of a key may be.
struct KeyValue {
  KeyType type;
  Range range{};
  std::vector<std::string_view> words{};
  std::vector<double> default_numbers{};  // of a number or flag one, of a vector three
  std::string_view default_word{};        // of a kWord
  Range count{};                          // of kNumbers and kCurve: how many
  double most_effort = 0;                 // of a curve

  // The same with a default.
  [[nodiscard]] KeyValue by_default(double number) const;
  [[nodiscard]] KeyValue by_default(double x, double y, double z) const;
  [[nodiscard]] KeyValue by_default(std::string_view word) const;
};

struct FileKey : KeyValue {
  std::string_view name;
  bool required;
  std::string_view text;  // for people
};

struct FileKind {
  std::string_view name;    // "plane": under $defs in the schema
  const char* what;         // "a plane", in errors
  std::string_view text{};  // for people
  std::vector<FileKey> keys{};
  bool exactly_one = false;                   // of its keys
  std::vector<std::string_view> key_names{};  // of `keys`

  // Each adds a key. key_values.h has the functions that make its value.
  FileKind& required(std::string_view key, KeyValue value, std::string_view for_people = {});
  FileKind& optional(std::string_view key, KeyValue value, std::string_view for_people = {});
  // A key of a kind that has exactly one of its keys.
  FileKind& alternative(std::string_view key, KeyValue value, std::string_view for_people = {});
};

using KeyTable = std::vector<FileKind>;

// std::logic_error if there is none.
[[nodiscard]] const FileKind& kind_of(const KeyTable& table, std::string_view name);
[[nodiscard]] const FileKey& key_of(const FileKind& kind, std::string_view name);

}  // namespace thimble::host
