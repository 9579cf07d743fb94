#include "host-tools/keys/keys.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace thimble::host {

KeyValue KeyValue::by_default(double number) const {
  KeyValue value = *this;
  value.default_numbers = {number};
  return value;
}

KeyValue KeyValue::by_default(double x, double y, double z) const {
  KeyValue value = *this;
  value.default_numbers = {x, y, z};
  return value;
}

KeyValue KeyValue::by_default(std::string_view word) const {
  KeyValue value = *this;
  value.default_word = word;
  return value;
}

FileKind& FileKind::required(std::string_view key, KeyValue value, std::string_view for_people) {
  keys.push_back({std::move(value), key, true, for_people});
  key_names.push_back(key);
  return *this;
}

FileKind& FileKind::optional(std::string_view key, KeyValue value, std::string_view for_people) {
  keys.push_back({std::move(value), key, false, for_people});
  key_names.push_back(key);
  return *this;
}

FileKind& FileKind::alternative(std::string_view key, KeyValue value, std::string_view for_people) {
  exactly_one = true;
  return optional(key, std::move(value), for_people);
}

const FileKind& kind_of(const KeyTable& table, std::string_view name) {
  const auto found = std::ranges::find(table, name, &FileKind::name);
  if (found == table.end()) throw std::logic_error("no such kind: " + std::string(name));
  return *found;
}

const FileKey& key_of(const FileKind& kind, std::string_view name) {
  const auto found = std::ranges::find(kind.keys, name, &FileKey::name);
  if (found == kind.keys.end())
    throw std::logic_error(std::string(kind.name) + " has no key " + std::string(name));
  return *found;
}

}  // namespace thimble::host
