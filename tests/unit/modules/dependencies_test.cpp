// The dependencies of the modules: kinematics <- control <- firmware <- board, with host-tools beside them, and the ones inside
// firmware/. Reads every include of every module and fails on one that is not allowed, on a standard header that brings heap, locks or
// I/O into the controller, and on an atomic in the firmware outside firmware/exchange/.
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

// Inside firmware/: the exchange depends on nothing. The tick side (core, sources, and observe but for the frames) does not know who
// reads it: no service, store or controller.
bool tick_side(const std::string& file) {
  return starts_with_any(file, {"firmware/core/", "firmware/sources/"}) ||
         (starts_with(file, "firmware/observe/") && file.find("_frames.") == std::string::npos);
}
bool firmware_dependency_allowed(const std::string& file, const std::string& included) {
  if (starts_with(file, "firmware/exchange/")) return starts_with(included, "firmware/exchange/");
  if (tick_side(file) &&
      starts_with_any(included, {"firmware/services/", "firmware/store/", "firmware/controller."}))
    return false;
  return starts_with_any(
      included, {"kinematics/", "control/", "firmware/", "thimble_scene_schema/", "thimble_arm_schema/"});
}

// May a file of the project (path from the top) include "included"?
bool dependency_allowed(const std::string& file, const std::string& included) {
  const std::string kSchema = "thimble_scene_schema/";
  if (!starts_with_any(included, kModules) && !starts_with_any(included, {"tests/", kSchema}))
    return true;  // a library
  // The link is for both of its ends: it depends on nothing of the controller.
  if (starts_with(file, "firmware/link/")) return starts_with(included, "firmware/link/");
  if (starts_with(file, "kinematics/")) return starts_with(included, "kinematics/");
  if (starts_with(file, "control/")) return starts_with_any(included, {"kinematics/", "control/", kSchema});
  if (starts_with(file, "firmware/")) return firmware_dependency_allowed(file, included);
  // Readers of text files, for boards under an operating system and for the host tools: they depend on nothing else.
  if (starts_with(file, "board/files/")) return starts_with(included, "board/files/");
  if (starts_with(file, "board/"))
    return starts_with_any(included, {"kinematics/", "control/", "firmware/", "board/"});
  // To judge an arm file, its arm is moved.
  if (starts_with(file, "host-tools/arms/") &&
      starts_with_any(included, {"kinematics/", "thimble_arm_schema/"}))
    return true;
  // To judge what an arm does, its arm is moved, too; walls push and axes are driven as the firmware's.
  if (starts_with(file, "host-tools/commission/") &&
      starts_with_any(included, {"kinematics/", "firmware/core/force_limits.", "firmware/core/encoder_",
                                 "firmware/sources/axis_drive."}))
    return true;
  // host-tools: the scene's schema, check and limits, the protocol, the tables of faults, conditions and parameters, the
  // simulated board, and what boards under Linux know of the machine as well.
  return starts_with_any(included, {"host-tools/", kSchema, "control/scene/", "firmware/link/",
                                    "firmware/core/faults.", "firmware/core/conditions.", "firmware/params.",
                                    "board/sim/", "board/files/", "board/posix/can_interfaces."});
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
  std::size_t all_includes = 0;
  for (const std::string& module : kModules) {
    const auto includes = includes_of(THIMBLE_SOURCE_DIR, module);
    EXPECT_GT(includes.size(), 5U) << module << ": are its sources where they should be?";
    for (const Include& include : includes) {
      EXPECT_TRUE(include.system || dependency_allowed(include.file, include.name))
          << include.file << ":" << include.line << " includes \"" << include.name
          << "\", which is a forbidden dependency";
    }
    std::printf("%s: %zu includes\n", module.c_str(), includes.size());
    all_includes += includes.size();
  }
  EXPECT_GT(all_includes, 100U);
}

TEST(Modules, NoHeapLockOrStreamHeaderInTheCore) {
  for (const std::string& module : kCore) {
    for (const Include& include : includes_of(THIMBLE_SOURCE_DIR, module)) {
      EXPECT_TRUE(!include.system || header_allowed_in_core(include.name))
          << include.file << ":" << include.line << " includes <" << include.name << ">";
    }
  }
}

std::string text_of(const fs::path& path) {
  std::ifstream in(path);
  return {std::istreambuf_iterator<char>(in), {}};
}

bool uses_atomics(const std::string& text) {
  for (const char* word : {"std::atomic", "<atomic>", "memory_order", "__atomic", "__sync_", "volatile"})
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// The exchange is the only way between the two contexts.
TEST(Modules, NoAtomicInTheFirmwareButInTheExchange) {
  std::size_t files = 0, with_atomics = 0;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(THIMBLE_SOURCE_DIR) / "firmware")) {
    const std::string extension = entry.path().extension().string();
    if (!entry.is_regular_file() || (extension != ".h" && extension != ".cpp")) continue;
    ++files;
    const bool exchange = entry.path().parent_path().filename() == "exchange";
    const bool uses = uses_atomics(text_of(entry.path()));
    with_atomics += uses ? 1U : 0U;
    EXPECT_TRUE(exchange || !uses) << entry.path() << ": use a type of firmware/exchange/";
  }
  std::printf("firmware: %zu files, %zu with atomics\n", files, with_atomics);
  EXPECT_GT(files, 30U);
  EXPECT_GE(with_atomics, 5U) << "are the types of the exchange where they should be?";
}

// The test can fail: each of these dependencies is forbidden.
TEST(Modules, DetectsAForbiddenDependency) {
  EXPECT_FALSE(dependency_allowed("kinematics/arm.cpp", "control/renderer.h"));
  EXPECT_FALSE(dependency_allowed("control/renderer.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("control/renderer.cpp", "host-tools/error.h"));
  EXPECT_FALSE(dependency_allowed("firmware/core/sense.cpp", "board/sim/plant.h"));
  EXPECT_FALSE(dependency_allowed("firmware/core/sense.cpp", "tests/support/scene.h"));
  EXPECT_FALSE(dependency_allowed("firmware/link/iso_tp.cpp", "firmware/core/core.h"));
  EXPECT_FALSE(dependency_allowed("board/sim/plant.cpp", "host-tools/error.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "control/renderer.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "kinematics/arm.h"));
  EXPECT_TRUE(dependency_allowed("host-tools/arms/arm_checks.cpp", "kinematics/mechanism.h"));
  EXPECT_TRUE(dependency_allowed("host-tools/commission/sim_motions.cpp", "kinematics/mechanism.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/commission/sim_motions.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("firmware/exchange/ring.h", "firmware/params.h"));
  EXPECT_FALSE(dependency_allowed("firmware/core/tick.cpp", "firmware/controller.h"));
  EXPECT_FALSE(dependency_allowed("firmware/sources/scene_source.cpp", "firmware/store/scene_store.h"));
  EXPECT_FALSE(dependency_allowed("firmware/observe/recorder.h", "firmware/services/router.h"));
  EXPECT_FALSE(dependency_allowed("host-tools/client/device.cpp", "firmware/core/core.h"));
  EXPECT_TRUE(dependency_allowed("host-tools/client/device.cpp", "firmware/core/conditions.h"));
  EXPECT_TRUE(dependency_allowed("firmware/observe/status_frames.h", "firmware/store/scene_store.h"));
  EXPECT_TRUE(dependency_allowed("firmware/core/sense.cpp", "control/renderer.h"));
  EXPECT_TRUE(uses_atomics("#include <atomic>"));
  EXPECT_FALSE(uses_atomics("#include \"firmware/exchange/word.h\""));
  EXPECT_TRUE(dependency_allowed("host-tools/client/device.cpp", "firmware/link/iso_tp.h"));
  EXPECT_EQ(parse("  #  include \"control/renderer.h\"  // why").name, "control/renderer.h");
  EXPECT_TRUE(parse("#include <vector>").system);
  EXPECT_FALSE(header_allowed_in_core("vector"));
  EXPECT_TRUE(header_allowed_in_core("array"));
}

}  // namespace
}  // namespace thimble::test
