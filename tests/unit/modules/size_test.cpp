// No file of product code is longer than 450 lines and no function longer than 80, but for those of kLonger, each with its reason.
// Lines are those of the file, comments and blank ones included: what a reader scrolls through.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFileLines = 450;
constexpr std::size_t kMostFunctionLines = 80;

struct Longer {
  std::string_view name;  // "path", or "path: function"
  std::size_t lines;      // at most so many
  std::string_view why;
};
constexpr Longer kLonger[] = {
    {"firmware/link/messages.def", 748, "the table of the messages, a row a field"},
};

struct Function {
  std::string name;
  std::size_t line = 0;
  std::size_t lines = 0;
};

// The text with comments, strings and character literals blanked; lines stay where they are.
std::string without_text(const std::string& source) {
  std::string out = source;
  const auto blank = [&out](std::size_t from, std::size_t to) {
    for (std::size_t i = from; i < std::min(to, out.size()); ++i)
      if (out[i] != '\n') out[i] = ' ';
  };
  std::size_t i = 0;
  while (i < source.size()) {
    const char c = source[i];
    std::size_t end = i + 1;
    if (source.compare(i, 2, "//") == 0) {
      end = std::min(source.find('\n', i), source.size());
      blank(i, end);
    } else if (source.compare(i, 2, "/*") == 0) {
      end = std::min(source.find("*/", i + 2), source.size() - 2) + 2;
      blank(i, end);
    } else if (source.compare(i, 2, "R\"") == 0) {
      const std::size_t open = source.find('(', i);
      const std::string close = ")" + source.substr(i + 2, open - i - 2) + "\"";
      end = std::min(source.find(close, open), source.size() - close.size()) + close.size();
      blank(i, end);
    } else if (c == '"' || c == '`' ||
               (c == '\'' && (i == 0 || std::isalnum(static_cast<unsigned char>(source[i - 1])) == 0))) {
      while (end < source.size() && source[end] != c && (c == '`' || source[end] != '\n'))
        end += source[end] == '\\' ? 2U : 1U;
      end = std::min(end + 1, source.size());
      blank(i, end);
    } else if (c == '#' && (i == 0 || source[i - 1] == '\n')) {  // a directive with its continuation lines
      end = i;
      do {
        end = std::min(source.find('\n', end), source.size() - 1) + 1;
      } while (end < source.size() && source[end - 2] == '\\');
      blank(i, end);
    }
    i = end;
  }
  return out;
}

std::string first_word(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(" \n\t");
  if (begin == std::string::npos) return {};
  std::size_t end = begin;
  while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_'))
    ++end;
  return text.substr(begin, end - begin);
}

// What a '{' begins, by the text since the last ';', '{' or '}'.
bool begins_function(const std::string& head) {
  const std::size_t open = head.find('(');
  if (open == std::string::npos) return false;
  for (const char* word : {"namespace", "class", "struct", "enum", "union", "if", "for", "while", "switch",
                           "else", "do", "catch"})
    if (first_word(head) == word) return false;
  if (head.find("=>") != std::string::npos) return true;       // TypeScript
  return head.substr(0, open).find('=') == std::string::npos;  // else an initialiser
}

std::string name_of(const std::string& head) {
  const std::size_t open = head.find('(');
  std::size_t begin = open;
  while (begin > 0 && (std::isalnum(static_cast<unsigned char>(head[begin - 1])) != 0 ||
                       head[begin - 1] == '_' || head[begin - 1] == ':' || head[begin - 1] == '~'))
    --begin;
  return head.substr(begin, open - begin);
}

// Functions of C++ and TypeScript, the outermost ones: a lambda belongs to the function around it.
std::vector<Function> functions_of(const std::string& source) {
  const std::string text = without_text(source);
  std::vector<Function> found;
  std::string head;
  std::size_t line = 1, head_line = 1, depth = 0, parentheses = 0;
  std::size_t inside = 0;  // depth of the function that is being read; 0: none
  Function now;
  for (const char c : text) {
    if (c == '\n') ++line;
    if (head.empty() && std::isspace(static_cast<unsigned char>(c)) != 0) continue;
    if (head.empty()) head_line = line;
    if (c == '(') ++parentheses;
    if (c == ')' && parentheses > 0) --parentheses;
    if (c == '{') {
      ++depth;
      if (inside == 0 && parentheses == 0 && begins_function(head)) {
        inside = depth;
        now = {name_of(head), head_line, 0};
      }
      if (parentheses == 0) head.clear();
    } else if (c == '}') {
      if (inside != 0 && depth == inside) {
        now.lines = line - now.line + 1;
        found.push_back(now);
        inside = 0;
      }
      if (depth > 0) --depth;
      if (parentheses == 0) head.clear();
    } else if (c == ';' && parentheses == 0) {
      head.clear();
    } else {
      head += c;
    }
  }
  return found;
}

bool is_product(const fs::path& path) {
  static const std::vector<std::string> kKinds = {".h",  ".cpp", ".c",  ".def", ".fbs",
                                                  ".ts", ".mjs", ".py", ".S",   ".ld"};
  const std::string text = path.generic_string();
  for (const char* other : {"/node_modules/", "/page/test/", "/src/generated/"})
    if (text.find(other) != std::string::npos) return false;
  return std::ranges::find(kKinds, path.extension().string()) != kKinds.end();
}

std::string read(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(Size, NoFileAndNoFunctionIsTooLong) {
  const fs::path top = THIMBLE_SOURCE_DIR;
  std::map<std::string, std::size_t> too_long;
  std::size_t files = 0, functions = 0, longest_file = 0, longest_function = 0;
  for (const char* module : {"kinematics", "control", "firmware", "board", "host-tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(top / module)) {
      if (!entry.is_regular_file() || !is_product(entry.path())) continue;
      const std::string name = entry.path().lexically_relative(top).generic_string();
      const std::string source = read(entry.path());
      const auto lines = static_cast<std::size_t>(std::ranges::count(source, '\n'));
      ++files;
      longest_file = std::max(longest_file, lines);
      if (lines > kMostFileLines) too_long[name] = lines;
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp" && extension != ".c" && extension != ".ts") continue;
      for (const Function& function : functions_of(source)) {
        ++functions;
        longest_function = std::max(longest_function, function.lines);
        if (function.lines > kMostFunctionLines) too_long[name + ": " + function.name] = function.lines;
      }
    }
  }
  std::printf("%zu files, the longest of %zu lines; %zu functions, the longest of %zu\n", files, longest_file,
              functions, longest_function);
  EXPECT_GT(files, 300U) << "are the sources where they should be?";
  EXPECT_GT(functions, 1500U);
  for (const auto& [name, lines] : too_long) {
    const auto* row = std::ranges::find(kLonger, std::string_view(name), &Longer::name);
    EXPECT_TRUE(row != std::end(kLonger) && lines <= row->lines)
        << name << " has " << lines << " lines. Divide it, or give the reason in its header and in kLonger.";
  }
  for (const Longer& row : kLonger)
    EXPECT_TRUE(too_long.contains(std::string(row.name)))
        << row.name << " is not too long any more: remove its row";
}

TEST(Size, FunctionsAreFoundAsTheyAreWritten) {
  const auto found = functions_of(R"sample(// int not_this() {
namespace a {
struct Point {
  int x() const {
    return 1;  // }
  }
  Point(int a, int b)
      : a_(a), b_(b) {}
};
constexpr int kTable[] = {1, 2};
const char* text(int i) noexcept {
  const auto inner = [&] {
    return "}";
  };
  if (i > 0) {
    return inner();
  }
  for (char c : {'{', '}'}) i += c;
  return R"x(
})x";
}
}  // namespace a
function page(a: number): void {
  a.map((b) => {
    return b;
  });
}
)sample");
  ASSERT_EQ(found.size(), 4U);
  EXPECT_EQ(found[0].name, "x");
  EXPECT_EQ(found[0].lines, 3U);
  EXPECT_EQ(found[1].name, "Point");
  EXPECT_EQ(found[1].lines, 2U);
  EXPECT_EQ(found[2].name, "text");
  EXPECT_EQ(found[2].line, 11U);
  EXPECT_EQ(found[2].lines, 11U);
  EXPECT_EQ(found[3].name, "page");
  EXPECT_EQ(found[3].lines, 5U);
}

}  // namespace
}  // namespace thimble::test
