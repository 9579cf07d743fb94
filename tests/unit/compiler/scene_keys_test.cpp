// The table of the scene file's keys: the schema file is its text, the documentation has each key with its bounds and default, and
// what the schema forbids the reader refuses.
#include "host-tools/compiler/scene_keys.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/support/figure.h"

namespace thimble::test {
namespace {

using host::FileKey;
using host::FileKind;
using host::KeyType;

std::string source_text(const std::string& path) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / path);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(SceneKeys, TheSchemaFileIsTheTable) {
  const std::string wanted = host::scene_schema();
  if (source_text("host-tools/compiler/scene.schema.json") == wanted) return;
  std::ofstream("scene.schema.json") << wanted;
  ADD_FAILURE() << "host-tools/compiler/scene.schema.json is not what scene_keys.cpp says: copy "
                   "scene.schema.json from the "
                   "folder in which this test ran over it";
}

TEST(SceneKeys, EveryPartIsAKindAndEveryKindIsUsed) {
  std::set<std::string_view> used{"scene"};
  for (const FileKind& kind : host::scene_kinds()) {
    std::set<std::string_view> names;
    for (const FileKey& key : kind.keys) {
      EXPECT_TRUE(names.insert(key.name).second) << kind.name << " has " << key.name << " twice";
      const bool parts = key.type == KeyType::kPart || key.type == KeyType::kList ||
                         key.type == KeyType::kNamedParts || key.type == KeyType::kPartOrName;
      EXPECT_EQ(key.words.empty(), !parts && key.type != KeyType::kWord) << kind.name << "/" << key.name;
      for (const std::string_view word : parts ? key.words : std::vector<std::string_view>{}) {
        EXPECT_NO_THROW(static_cast<void>(host::scene_kind(word)));
        used.insert(word);
      }
      EXPECT_FALSE(key.required && !(key.default_numbers.empty() && key.default_word.empty()))
          << kind.name << "/" << key.name << " is required and has a default";
      if (key.type == KeyType::kNumber || key.type == KeyType::kVector) {
        for (const double value : key.default_numbers)
          EXPECT_TRUE(key.range.holds(value)) << kind.name << "/" << key.name;
      }
    }
  }
  EXPECT_EQ(used.size(), host::scene_kinds().size());
}

// The numbers of a text: 0.00001 and 1e-5 are one.
std::vector<double> numbers_in(const std::string& text) {
  std::vector<double> numbers;
  const std::regex number("-?[0-9]+(\\.[0-9]+)?(e-?[0-9]+)?");
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end; ++at)
    numbers.push_back(std::stod(at->str()));
  return numbers;
}

// The rows of the page's tables, each under the keys in backticks in its cells but the one of the values. A row of the table of
// shapes has its shape in the first cell, or in that of a row before.
std::multimap<std::string, std::string> rows_by_key() {
  std::multimap<std::string, std::string> rows;
  const std::string page = source_text("docs/scene-format.md");
  const std::regex key("`([A-Za-z$_][A-Za-z0-9_]*)`");
  std::size_t begin = 0;
  while (begin < page.size()) {
    const std::size_t end = std::min(page.find('\n', begin), page.size());
    const std::string line = page.substr(begin, end - begin);
    begin = end + 1;
    if (!line.starts_with("| ")) continue;
    const std::string cells = line.substr(0, std::min(line.find(" | ", line.find(" | ") + 3), line.size()));
    for (std::sregex_iterator at(cells.begin(), cells.end(), key), last; at != last; ++at)
      rows.emplace((*at)[1], line);
  }
  return rows;
}

bool says(const std::string& row, double value) {
  const std::vector<double> numbers = numbers_in(row);
  return std::ranges::any_of(numbers,
                             [value](double n) { return std::abs(n - value) <= 0.02 * std::abs(value); });
}

// A row with the key that gives both ends of its range, or names the kind of number that the page defines once ("a length").
bool row_says_range(const std::string& row, const FileKey& key) {
  const bool length = key.range.least == 1e-5 && key.range.most == 10.0;
  if (length && (row.find("length") != std::string::npos || row.find("lengths") != std::string::npos))
    return true;
  const auto end = [&row](double value) { return value == 0.0 || says(row, value) || says(row, -value); };
  return end(key.range.least) && end(key.range.most);
}

bool row_says_default(const std::string& row, const FileKey& key) {
  const std::string last =
      row.substr(row.rfind(" | ") == std::string::npos ? 0 : row.rfind(" | ", row.size() - 3));
  if (key.required)
    return last.find("required") != std::string::npos || last.find("exactly one") != std::string::npos;
  if (!key.default_word.empty())
    return last.find("\"" + std::string(key.default_word) + "\"") != std::string::npos;
  return true;
}

TEST(SceneKeys, TheDocumentationHasEveryKeyWithItsRangeAndDefault) {
  const auto rows = rows_by_key();
  const std::string page = source_text("docs/scene-format.md");
  std::size_t keys = 0;
  for (const FileKind& kind : host::scene_kinds()) {
    for (const FileKey& key : kind.keys) {
      const std::string place = std::string(kind.name) + "/" + std::string(key.name);
      const std::string name(key.name);
      ASSERT_NE(page.find("`" + name + "`"), std::string::npos) << place << " is not in docs/scene-format.md";
      const auto [first, last] = rows.equal_range(name);
      const bool ranged = key.type == KeyType::kNumber || key.type == KeyType::kVector ||
                          key.type == KeyType::kPair || key.type == KeyType::kRowsOrFile ||
                          key.type == KeyType::kRows;
      ++keys;
      // brake_friction, centre_m: in a sentence.
      bool in_a_sentence = false;
      for (std::size_t at = page.find("`" + name + "`"); at != std::string::npos;
           at = page.find("`" + name + "`", at + 1))
        in_a_sentence =
            in_a_sentence || (ranged && !key.required && row_says_range(page.substr(at, 120), key));
      const auto fits = [&](const auto& row) {
        for (const std::string_view word :
             key.type == KeyType::kWord ? key.words : std::vector<std::string_view>{})
          if (row.second.find("\"" + std::string(word) + "\"") == std::string::npos) return false;
        return (!ranged || row_says_range(row.second, key)) && row_says_default(row.second, key);
      };
      EXPECT_TRUE(in_a_sentence || std::any_of(first, last, fits))
          << place << ": no row of docs/scene-format.md has its range, words and default: " << key.range.least
          << " to " << key.range.most;
    }
  }
  figure("keys compared with the documentation", static_cast<double>(keys), "");
  EXPECT_GT(keys, 120U);
}

}  // namespace
}  // namespace thimble::test
