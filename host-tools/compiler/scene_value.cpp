#include "host-tools/compiler/scene_value.h"

namespace thimble::host {

ScenePart::ScenePart(const Value& value, std::string_view kind) : value_(value), kind_(scene_kind(kind)) {
  value_.object(kind_.what, kind_.key_names);
  if (kind_.exactly_one && value_.raw().size() != 1)
    value_.wrong("an object with exactly one of " + listed(kind_.key_names));
}

std::string ScenePart::only_key() const { return value_.raw().begin().key(); }

double ScenePart::number(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  if (!has(key) && !row.default_numbers.empty()) return row.default_numbers.front();
  return at(key).number(row.range);
}

Eigen::Vector3d ScenePart::vector(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  if (!has(key) && row.default_numbers.size() == 3)
    return {row.default_numbers[0], row.default_numbers[1], row.default_numbers[2]};
  return at(key).vector(row.range);
}

Eigen::Vector3d ScenePart::direction(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  if (!has(key) && row.default_numbers.size() == 3)
    return {row.default_numbers[0], row.default_numbers[1], row.default_numbers[2]};
  return at(key).direction();
}

bool ScenePart::flag(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  if (!has(key) && !row.default_numbers.empty()) return row.default_numbers.front() != 0;
  return at(key).boolean();
}

std::size_t ScenePart::word(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  if (!has(key) && !row.default_word.empty()) {
    std::size_t index = 0;
    while (row.words.at(index) != row.default_word) ++index;
    return index;
  }
  return at(key).word(row.words);
}

std::array<double, 2> ScenePart::pair(std::string_view key) const {
  const SceneKey& row = scene_key(kind_, key);
  const Value value = at(key);
  if (!value.raw().is_array() || value.raw().size() != 2) value.wrong("an array of two numbers [x, y]");
  return {value.at(std::size_t{0}).number(row.range), value.at(std::size_t{1}).number(row.range)};
}

std::string ScenePart::text(std::string_view key) const {
  return at(key).text(static_cast<std::size_t>(scene_key(kind_, key).range.most));
}

Value ScenePart::list(std::string_view key, const char* name, const char* things, const char* remedy) const {
  const SceneKey& row = scene_key(kind_, key);
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
