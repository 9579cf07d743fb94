// The dependencies of the modules: kinematics <- control <- firmware <- board; host-tools use the link, some tables
// and the simulated board. Reads every include of every module and fails on a forbidden dependency, and on a standard
// header that brings heap, locks or I/O into the controller.
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kModules = {"kinematics", "control", "firmware", "board", "host-tools"};
const std::vector<std::string> kCore = {"kinematics", "control", "firmware"};

bool starts_with(const std::string& text, const std::string& prefix) { return text.rfind(prefix, 0) == 0; }
bool starts_with_any(const std::string& text, const std::vector<std::string>& prefixes) {
  for (const std::string& prefix : prefixes)
    if (starts_with(text, prefix)) return true;
  return false;
}

// Whether `file` (path from the top) may include `included`.
bool dependency_allowed(const std::string& file, const std::string& included) {
  const std::string kSchema = "thimble_scene_schema/";
  if (!starts_with_any(included, kModules) && !starts_with_any(included, {"tests/", kSchema}))
    return true;  // a library
  // Both ends use the link, so it depends on no other module.
  if (starts_with(file, "firmware/link/")) return starts_with(included, "firmware/link/");
  if (starts_with(file, "kinematics/")) return starts_with(included, "kinematics/");
  if (starts_with(file, "control/")) return starts_with_any(included, {"kinematics/", "control/", kSchema});
  if (starts_with(file, "firmware/"))
    return starts_with_any(included, {"kinematics/", "control/", "firmware/", kSchema});
  if (starts_with(file, "board/"))
    return starts_with_any(included, {"kinematics/", "control/", "firmware/", "board/"});
  // host-tools: the scene's schema, check and limits, the protocol, the fault and parameter tables, the
  // simulated board.
  return starts_with_any(included, {"host-tools/", kSchema, "control/scene/", "firmware/link/",
                                    "firmware/faults.", "firmware/params.", "board/sim/"});
}

// False for headers that bring heap, locks, exceptions or I/O.
bool header_allowed_in_core(const std::string& header) {
  static const std::vector<std::string> kForbidden = {"iostream",      "fstream",
                                                      "sstream",       "ostream",
                                                      "istream",       "iomanip",
                                                      "cstdio",        "stdio.h",
                                                      "string",        "vector",
                                                      "deque",         "list",
                                                      "map",           "set",
                                                      "queue",         "stack",
                                                      "functional",    "memory",
                                                      "unordered_map", "unordered_set",
                                                      "any",           "mutex",
                                                      "shared_mutex",  "thread",
                                                      "future",        "condition_variable",
                                                      "stdexcept",     "exception",
                                                      "typeinfo",      "regex",
                                                      "locale",        "filesystem",
                                                      "chrono",        "random",
                                                      "ctime"};
  for (const std::string& forbidden : kForbidden)
    if (header == forbidden) return false;
  return !starts_with(header, "sys/") && header != "unistd.h";
}

struct Include {
  std::string file;  // path from the top
  int line = 0;
  std::string name;
  bool system = false;  // <...>
};

// The include of a line; its name is empty if there is none.
Include parse(const std::string& line) {
  const std::size_t hash = line.find_first_not_of(" \t");
  if (hash == std::string::npos || line[hash] != '#') return {};
  const std::size_t word = line.find_first_not_of(" \t", hash + 1);
  if (word == std::string::npos || line.compare(word, 7, "include") != 0) return {};
  const std::size_t open = line.find_first_of("<\"", word);
  if (open == std::string::npos) return {};
  const bool system = line[open] == '<';
  return {"", 0, line.substr(open + 1, line.find(system ? '>' : '"', open + 1) - open - 1), system};
}

std::vector<Include> includes_of(const fs::path& top, const std::string& module) {
  std::vector<Include> found;
  for (const auto& entry : fs::recursive_directory_iterator(top / module)) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp" && extension != ".c")) continue;
    std::ifstream in(entry.path());
    std::string line;
    for (int number = 1; std::getline(in, line); ++number) {
      Include include = parse(line);
      if (include.name.empty()) continue;
      include.file = entry.path().lexically_relative(top).generic_string();
      include.line = number;
      found.push_back(include);
    }
  }
  return found;
}

TEST(Modules, NoForbiddenDependency) {
  std::size_t dependencies = 0;
  for (const std::string& module : kModules) {
    const auto includes = includes_of(THIMBLE_SOURCE_DIR, module);
    EXPECT_GT(includes.size(), 5U) << module << ": have its sources moved?";
    for (const Include& include : includes) {
      EXPECT_TRUE(include.system || dependency_allowed(include.file, include.name))
          << include.file << ":" << include.line << " includes \"" << include.name
          << "\", which is a forbidden dependency";
    }
    std::printf("%s: %zu includes\n", module.c_str(), includes.size());
    dependencies += includes.size();
  }
  EXPECT_GT(dependencies, 100U);
}

TEST(Modules, NoHeapLockOrStreamHeaderInTheCore) {
  for (const std::string& module : kCore) {
    for (const Include& include : includes_of(THIMBLE_SOURCE_DIR, module)) {
      EXPECT_TRUE(!include.system || header_allowed_in_core(include.name))
          << include.file << ":" << include.line << " includes <" << include.name << ">";
    }
  }
}

// The test can fail: each of these dependencies is forbidden.
TEST(Modules, DetectsAForbiddenDependency) {
  EXPECT_FALSE(dependency_allowed("kinematics/arm.cpp", "control/renderer.h"));
  EXPECT_FALSE(dependency_allowed("control/renderer.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("control/renderer.cpp", "host-tools/error.h"));
  EXPECT_FALSE(dependency_allowed("firmware/servo.cpp", "board/sim/plant.h"));
  EXPECT_FALSE(dependency_allowed("firmware/servo.cpp", "tests/support/scene.h"));
  EXPECT_FALSE(dependency_allowed("firmware/link/iso_tp.cpp", "firmware/servo.h"));
  EXPECT_FALSE(dependency_allowed("board/sim/plant.cpp", "host-tools/error.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "control/renderer.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "kinematics/arm.h"));
  EXPECT_TRUE(dependency_allowed("firmware/servo.cpp", "control/renderer.h"));
  EXPECT_TRUE(dependency_allowed("host-tools/client/device.cpp", "firmware/link/iso_tp.h"));
  EXPECT_EQ(parse("  #  include \"control/renderer.h\"  // why").name, "control/renderer.h");
  EXPECT_TRUE(parse("#include <vector>").system);
  EXPECT_FALSE(header_allowed_in_core("vector"));
  EXPECT_TRUE(header_allowed_in_core("array"));
}

}  // namespace
}  // namespace thimble::test
