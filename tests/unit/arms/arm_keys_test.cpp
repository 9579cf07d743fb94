// The table of the arm file's keys: the schema file is its text, and the documentation has each key with its unit.
#include "host-tools/arms/arm_keys.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include "tests/support/generated_docs.h"

namespace thimble::test {
namespace {

std::string source_of(const char* path) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(ArmKeys, TheSchemaFileIsTheTable) {
  const std::string wanted = host::arm_schema();
  if (source_of("arms/arm.schema.json") == wanted) return;
  std::ofstream("arm.schema.json") << wanted;
  ADD_FAILURE() << "arms/arm.schema.json is not what arm_keys.cpp says: copy arm.schema.json from "
                   "the folder in which "
                   "this test ran over it";
}

std::string value_of(const host::FileKey& key) {
  using host::KeyType;
  const std::string range = board::describe(key.range);
  const auto count = [&key] {
    const std::string least = board::number(key.count.least), most = board::number(key.count.most);
    return least == most ? least : least + " to " + most;
  };
  std::string words;
  for (const std::string_view word : key.words)
    words += (words.empty() ? "" : ", ") + ("`" + std::string(word) + "`");
  switch (key.type) {
    case KeyType::kVersion:
      return "1";
    case KeyType::kNumber:
      return range;
    case KeyType::kQuantity:
      return range + " *";
    case KeyType::kNumbers:
      return "array of " + count() + ", each " + range;
    case KeyType::kVector:
      return "`[x, y, z]`, each " + range;
    case KeyType::kDirection:
      return "`[x, y, z]` of any length but zero";
    case KeyType::kText:
      return "text of at most " + board::number(key.range.most) + " bytes";
    case KeyType::kWord:
      return words;
    case KeyType::kPart:
      return "a " + words;
    case KeyType::kList:
      return board::number(key.range.least) + " to " + board::number(key.range.most) + " of " + words;
    case KeyType::kNamedParts:
      return "names, each with a " + words;
    case KeyType::kPartOrName:
      return "a " + words + ", or the name of one";
    case KeyType::kRows:
      return "rows of numbers, each " + range;
    case KeyType::kPair:
    case KeyType::kFlag:
    case KeyType::kRowsOrFile:
    case KeyType::kCurve:
      break;  // no key of an arm
  }
  ADD_FAILURE() << key.name << " is of a type that this test does not know";
  return {};
}

std::string otherwise(const host::FileKey& key, bool exactly_one) {
  if (key.required) return "required";
  if (exactly_one) return "exactly one";
  if (!key.default_word.empty()) return "`" + std::string(key.default_word) + "`";
  std::string numbers;
  for (const double number : key.default_numbers)
    numbers += (numbers.empty() ? "" : ", ") + board::number(number);
  if (key.default_numbers.size() > 1) return "`[" + numbers + "]`";
  return numbers.empty() ? "none" : numbers;
}

TEST(ArmKeys, DocsHaveThem) {
  std::string tables;
  for (const host::FileKind& kind : host::arm_kinds()) {
    tables += "### " + std::string(kind.name) + "\n\n";
    if (!kind.text.empty()) tables += std::string(kind.text) + "\n\n";
    tables += "| key | value | default | meaning |\n|---|---|---|---|\n";
    for (const host::FileKey& key : kind.keys)
      tables += "| `" + std::string(key.name) + "` | " + value_of(key) + " | " +
                otherwise(key, kind.exactly_one) + " | " + std::string(key.text) + " |\n";
    tables += "\n";
  }
  while (tables.ends_with("\n")) tables.pop_back();
  expect_generated("docs/arm-format.md", "keys", std::regex_replace(tables, std::regex("\\.0(?![0-9])"), ""));
}

}  // namespace
}  // namespace thimble::test
