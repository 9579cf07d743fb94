#include "host-tools/keys/part.h"

namespace thimble::host {

FilePart::FilePart(const Value& value, const FileKind& kind) : value_(value), kind_(kind) {
  value_.object(kind_.what, kind_.key_names);
  if (kind_.exactly_one && value_.raw().size() != 1)
    value_.wrong("an object with exactly one of " + listed(kind_.key_names));
}

std::string FilePart::only_key() const { return value_.raw().begin().key(); }

double FilePart::number(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && !row.default_numbers.empty()) return row.default_numbers.front();
  return at(key).number(row.range);
}

Quantity FilePart::quantity(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && !row.default_numbers.empty()) return {row.default_numbers.front(), 0, {}};
  const Value given = at(key);
  if (!given.raw().is_object()) return {given.number(row.range), 0, {}};
  given.object("a number with its spread", {"value", "spread", "by"});
  return {given.at("value").number(row.range), given.number_or("spread", {0, 1.0e9}, 0),
          given.has("by") ? given.at("by").text() : "a measurement"};
}

std::vector<double> FilePart::numbers(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  const Value given = at(key);
  const auto least = static_cast<std::size_t>(row.count.least),
             most = static_cast<std::size_t>(row.count.most);
  static_cast<void>(given.size(least, most));
  return given.numbers(row.range, most);
}

Eigen::Vector3d FilePart::vector(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && row.default_numbers.size() == 3)
    return {row.default_numbers[0], row.default_numbers[1], row.default_numbers[2]};
  return at(key).vector(row.range);
}

Eigen::Vector3d FilePart::direction(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && row.default_numbers.size() == 3)
    return {row.default_numbers[0], row.default_numbers[1], row.default_numbers[2]};
  return at(key).direction();
}

bool FilePart::flag(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && !row.default_numbers.empty()) return row.default_numbers.front() != 0;
  return at(key).boolean();
}

std::size_t FilePart::word(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  if (!has(key) && !row.default_word.empty()) {
    std::size_t index = 0;
    while (row.words.at(index) != row.default_word) ++index;
    return index;
  }
  return at(key).word(row.words);
}

std::array<double, 2> FilePart::pair(std::string_view key) const {
  const FileKey& row = key_of(kind_, key);
  const Value value = at(key);
  if (!value.raw().is_array() || value.raw().size() != 2) value.wrong("an array of two numbers [x, y]");
  return {value.at(std::size_t{0}).number(row.range), value.at(std::size_t{1}).number(row.range)};
}

std::string FilePart::text(std::string_view key) const {
  return at(key).text(static_cast<std::size_t>(key_of(kind_, key).range.most));
}

Value FilePart::list(std::string_view key, const char* name, const char* things, const char* remedy) const {
  const FileKey& row = key_of(kind_, key);
  Value value = at(key);
  const auto least = static_cast<std::size_t>(row.range.least);
  const auto most = static_cast<std::size_t>(row.range.most);
  if (!value.raw().is_array() || value.raw().size() < least)
    value.wrong(std::string("an array of ") + things +
                (least == 0 ? "" : ", at least " + std::to_string(least)));
  if (value.raw().size() > most)
    value.fail(name,
               "has " + std::to_string(value.raw().size()) + " " + things + ", at most " +
                   std::to_string(most) + " are allowed",
               remedy);
  return value;
}

}  // namespace thimble::host
