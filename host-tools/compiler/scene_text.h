// The text of a scene file: JSON with comments (`//` to the end of the line, and `/* */`). Where its values are, and changes of numbers that
// leave everything else as it is.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace thimble::host {

// Comments made blanks, so that every byte stays where it is. A comment without an end is left, for the parser to refuse.
[[nodiscard]] std::string without_comments(std::string text);

// Counted from 1; the column in characters.
struct TextPlace {
  std::size_t line = 1;
  std::size_t column = 1;
};
[[nodiscard]] TextPlace place_at(std::string_view text, std::size_t offset);

struct ValueRange {
  std::size_t key = 0;  // where the key of a member begins; of other values as `begin`
  std::size_t begin = 0;
  std::size_t end = 0;
};

// By JSON pointer. `plain` is valid JSON, without comments.
using ValueRanges = std::map<std::string, ValueRange, std::less<>>;
[[nodiscard]] ValueRanges find_values(std::string_view plain);

// The text of a valid scene in which this number of the object's material has the value; every other byte is kept. A material under
// "materials" that other objects name too stays as it is for them: the object gets its own, a copy. Nothing is changed where the value is
// there already. The object has to be there.
[[nodiscard]] std::string with_material(const std::string& text, std::size_t object, const std::string& key,
                                        double value);

}  // namespace thimble::host
