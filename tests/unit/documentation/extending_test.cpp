// docs/extending.md is true: for each kind of extension, the listed files exist and contain the named example, no other
// product file contains it, and there are at most five product files to change, or the
// number that the section states.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

const fs::path kTop = THIMBLE_SOURCE_DIR;
const std::vector<std::string> kKinds = {"A shape",        "A parameter", "A fault",   "A message",
                                         "A force source", "An observer", "A service", "An arm",
                                         "A board",        "A verb"};
constexpr std::size_t kMostFiles = 5;

struct Step {
  std::string step;  // a number: a product file to change; "test", "page", "scene": others
  std::string file;  // from the top; a folder ends in /
};
struct Section {
  std::vector<std::string> search;  // any of these is the example
  std::size_t most_files = kMostFiles;
  std::vector<Step> steps;
};
using Sections = std::map<std::string, Section>;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

// The parts of a line between `left` and `right`.
std::vector<std::string> between(const std::string& line, const std::string& left, const std::string& right) {
  std::vector<std::string> parts;
  std::size_t at = 0;
  while ((at = line.find(left, at)) != std::string::npos) {
    const std::size_t begin = at + left.size(), end = line.find(right, begin);
    if (end == std::string::npos) break;
    parts.push_back(line.substr(begin, end - begin));
    at = end + right.size();
  }
  return parts;
}

// A section begins with "## NAME"; "More than five: N. WHY" allows N files; "Search: `a`, `b`" names the example; a row is | step | [file](link) | change |.
Sections parse(const std::string& page) {
  Sections sections;
  Section* section = nullptr;
  std::istringstream in(page);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind("## ", 0) == 0) section = &sections[line.substr(3)];
    if (section == nullptr) continue;
    if (line.rfind("Search: ", 0) == 0) section->search = between(line, "`", "`");
    const std::string kMore = "More than five: ";
    if (line.rfind(kMore, 0) == 0) section->most_files = std::stoul(line.substr(kMore.size()));
    const std::vector<std::string> links = between(line, "](../", ")");
    if (line.rfind("| ", 0) == 0 && !links.empty())
      section->steps.push_back({line.substr(2, line.find(" |", 2) - 2), links.front()});
  }
  return sections;
}

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// Whether the text contains the word, not as a part of a longer word.
bool contains(const std::string& text, const std::string& word) {
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
    const std::size_t end = at + word.size();
    if (is_word(word.front()) && at > 0 && is_word(text[at - 1])) continue;
    if (is_word(word.back()) && end < text.size() && is_word(text[end])) continue;
    return true;
  }
  return false;
}
bool contains(const std::string& text, const std::vector<std::string>& words) {
  return std::any_of(words.begin(), words.end(),
                     [&](const std::string& word) { return contains(text, word); });
}

// A comment may mention the example.
std::string without_comments(const std::string& text, const fs::path& file) {
  const std::string mark =
      file.extension() == ".txt" || file.extension() == ".cmake" || file.extension() == ".py" ? "#" : "//";
  std::ostringstream code;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) code << line.substr(0, line.find(mark)) << '\n';
  return code.str();
}

// The code of every product file, by its path.
std::map<std::string, std::string> product() {
  static const std::set<std::string> kExtensions = {".h",     ".cpp", ".c",    ".def", ".fbs",  ".txt",
                                                    ".cmake", ".ts",  ".json", ".py",  ".bash", ".ld"};
  static const std::set<std::string> kOthers = {"node_modules", "dist",  "test",     "mock",
                                                "pictures",     "build", "generated"};
  std::map<std::string, std::string> files;
  for (const char* module : {"kinematics", "control", "firmware", "board", "host-tools", "cmake"}) {
    for (auto it = fs::recursive_directory_iterator(kTop / module); it != fs::recursive_directory_iterator();
         ++it) {
      if (it->is_directory() && kOthers.contains(it->path().filename().string()))
        it.disable_recursion_pending();
      if (!it->is_regular_file() || !kExtensions.contains(it->path().extension().string())) continue;
      files[it->path().lexically_relative(kTop).generic_string()] =
          without_comments(text_of(it->path()), it->path());
    }
  }
  return files;
}

// What is wrong in a section; empty: nothing.
std::vector<std::string> errors_of(const Section& section, const std::map<std::string, std::string>& code) {
  std::vector<std::string> errors;
  if (section.search.empty()) errors.emplace_back("has no line \"Search: ...\"");
  std::set<std::string> listed;
  std::size_t numbered = 0;
  for (const Step& step : section.steps) {
    const fs::path file = kTop / step.file;
    const bool folder = step.file.back() == '/';
    const bool to_change = std::isdigit(static_cast<unsigned char>(step.step.front())) != 0;
    if (to_change) ++numbered;
    listed.insert(step.file);
    if (!fs::exists(file))
      errors.push_back(step.file + " does not exist");
    else if (!folder && !contains(text_of(file), section.search))
      errors.push_back(step.file + " does not contain the example");
  }
  if (numbered == 0) errors.emplace_back("lists no file");
  if (numbered > section.most_files || (section.most_files > kMostFiles && numbered != section.most_files))
    errors.push_back("needs " + std::to_string(numbered) + " files");
  for (const auto& [file, text] : code) {
    const bool known = std::any_of(listed.begin(), listed.end(), [&, &file = file](const std::string& entry) {
      return entry == file || (entry.back() == '/' && file.rfind(entry, 0) == 0);
    });
    if (!known && contains(text, section.search))
      errors.push_back(file + " contains the example and is not listed");
  }
  return errors;
}

TEST(Extending, EveryListIsComplete) {
  const Sections sections = parse(text_of(kTop / "docs/extending.md"));
  const auto code = product();
  EXPECT_GT(code.size(), 300U);
  for (const std::string& kind : kKinds) {
    const auto section = sections.find(kind);
    if (section == sections.end()) {
      ADD_FAILURE() << "docs/extending.md has no section \"" << kind << "\"";
      continue;
    }
    for (const std::string& error : errors_of(section->second, code)) ADD_FAILURE() << kind << ": " << error;
    std::printf("%s: %zu entries\n", kind.c_str(), section->second.steps.size());
  }
}

// The test can fail: a file that is left out, one that does not exist, one without the example, and too many of them.
TEST(Extending, AWrongListIsDetected) {
  const std::map<std::string, std::string> code = {{"firmware/a.cpp", "int example_x = 1;"},
                                                   {"firmware/b.cpp", "int longer_example_x;"}};
  const auto list = [](const std::string& rows) {
    return parse("## A thing\n\nSearch: `example_x`\n\n| step | file | change |\n|---|---|---|\n" + rows)
        .at("A thing");
  };
  const std::string row = "| 1 | [docs/extending.md](../docs/extending.md) | a change |\n";
  using testing::ElementsAre;
  EXPECT_THAT(errors_of(list(row), code),
              ElementsAre("docs/extending.md does not contain the example",
                          "firmware/a.cpp contains the example and is not listed"));
  EXPECT_THAT(
      errors_of(list("| 1 | [x](../firmware/none.cpp) | a change |\n| test | [x](../firmware/) | all |\n"),
                code),
      ElementsAre("firmware/none.cpp does not exist"));
  std::string rows;
  for (int i = 0; i < 6; ++i) rows += "| 1 | [x](../firmware/) | a change |\n";
  EXPECT_THAT(errors_of(list(rows), code), ElementsAre("needs 6 files"));
}

}  // namespace
}  // namespace thimble::test
