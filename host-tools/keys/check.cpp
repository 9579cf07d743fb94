#include "host-tools/keys/check.h"

#include <algorithm>

namespace thimble::host {
namespace {

using Refuse = std::function<void(const board::JsonError&)>;

template <typename Read>
void attempt(const Refuse& refuse, Read&& read) {
  try {
    read();
  } catch (const board::JsonError& error) {
    refuse(error);
  }
}

// Of a key whose value is no part.
void check_plain(const Value& value, const FileKey& key) {
  switch (key.type) {
    case KeyType::kNumber:
      static_cast<void>(value.number(key.range));
      return;
    case KeyType::kPair:
      if (!value.raw().is_array() || value.raw().size() != 2) value.wrong("an array of two numbers [x, y]");
      for (std::size_t i = 0; i < 2; ++i) static_cast<void>(value.at(i).number(key.range));
      return;
    case KeyType::kVector:
      static_cast<void>(value.vector(key.range));
      return;
    case KeyType::kDirection:
      static_cast<void>(value.direction());
      return;
    case KeyType::kText:
      static_cast<void>(value.text(static_cast<std::size_t>(key.range.most)));
      return;
    case KeyType::kWord:
      static_cast<void>(value.word(key.words));
      return;
    case KeyType::kFlag:
      static_cast<void>(value.boolean());
      return;
    case KeyType::kVersion:
    case KeyType::kQuantity:
    case KeyType::kNumbers:
    case KeyType::kPart:
    case KeyType::kList:
    case KeyType::kNamedParts:
    case KeyType::kPartOrName:
    case KeyType::kRows:
    case KeyType::kRowsOrFile:
    case KeyType::kCurve:
      return;
  }
}

// The parts that a key holds, one or several.
void check_parts(const Value& value, const FileKey& key, const KeyTable& table, const Refuse& refuse) {
  if (key.words.size() != 1) return;  // of which of several kinds is the reader's to say
  const bool is_part =
      key.type == KeyType::kPart || (key.type == KeyType::kPartOrName && !value.raw().is_string());
  if (is_part) check_keys(value, kind_of(table, key.words[0]), table, refuse);
  if (key.type == KeyType::kList && value.raw().is_array() &&
      value.raw().size() <= static_cast<std::size_t>(key.range.most)) {
    for (std::size_t i = 0; i < value.raw().size(); ++i)
      check_keys(value.at(i), kind_of(table, key.words[0]), table, refuse);
  }
  if (key.type == KeyType::kNamedParts && value.raw().is_object()) {
    for (const auto& each : value.raw().items())
      check_keys(value.at(each.key()), kind_of(table, key.words[0]), table, refuse);
  }
}

}  // namespace

void check_keys(const Value& value, const FileKind& kind, const KeyTable& table, const Refuse& refuse) {
  if (!value.raw().is_object()) {
    attempt(refuse, [&] { value.object(kind.what, kind.key_names); });
    return;
  }
  bool only_known = true;
  for (const auto& each : value.raw().items()) {
    if (std::ranges::find(kind.key_names, std::string_view(each.key())) != kind.key_names.end()) continue;
    only_known = false;
    attempt(refuse, [&] {
      value.at(each.key())
          .fail("unknown-key",
                std::string("is not a key of ") + kind.what + "; " + suggestion(each.key(), kind.key_names),
                "correct the key");
    });
  }
  if (only_known) attempt(refuse, [&] { static_cast<void>(FilePart(value, kind)); });  // exactly one
  for (const FileKey& key : kind.keys) {
    if (!value.has(key.name)) {
      if (key.required) attempt(refuse, [&] { static_cast<void>(value.at(key.name)); });
      continue;
    }
    const Value given = value.at(key.name);
    attempt(refuse, [&] { check_plain(given, key); });
    check_parts(given, key, table, refuse);
  }
}

}  // namespace thimble::host
