// The cache of solved potentials: the same image with it and without, whatever has happened to its files.
#include "host-tools/compiler/solved_cache.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <set>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/compile_help.h"
#include "host-tools/compiler/potential_solver.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using host::SolvedCache;

std::vector<fs::path> entries(const fs::path& folder) {
  std::vector<fs::path> all;
  for (const auto& entry : fs::directory_iterator(folder)) all.push_back(entry.path());
  return all;
}

std::string content(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void overwrite(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
}

std::string random_bytes(Random& random, std::size_t most) {
  std::string bytes(random.below(most), '\0');
  for (char& c : bytes) c = static_cast<char>(random.below(256));
  return bytes;
}

TEST(SolvedCache, GivesBackWhatWasKept) {
  const TemporaryFolder folder;
  const SolvedCache cache(folder.path() / "a" / "thimble");
  Random random(1);
  EXPECT_FALSE(cache.find("key"));
  for (int i = 0; i < 50; ++i) {
    const std::string key = random_bytes(random, 300);
    const std::string value = random_bytes(random, 5000);
    cache.keep(key, value);
    EXPECT_EQ(cache.find(key), value);
    cache.keep(key, value + "x");
    EXPECT_EQ(cache.find(key), value + "x");
  }
  struct stat about {};
  ASSERT_EQ(stat((folder.path() / "a" / "thimble").c_str(), &about), 0);
  EXPECT_EQ(about.st_mode & 0777U, 0700U);
}

TEST(SolvedCache, IgnoresWhatIsDamagedAndWritesItAgain) {
  const TemporaryFolder folder;
  const SolvedCache cache(folder.path() / "thimble");
  const std::string key = "a key";
  const std::string value = "a value of some length";
  cache.keep(key, value);
  const fs::path file = entries(folder.path() / "thimble").at(0);
  const std::string good = content(file);
  const auto is_ignored = [&](const std::string& bytes) {
    overwrite(file, bytes);
    EXPECT_FALSE(cache.find(key)) << bytes.size();
    cache.keep(key, value);
    EXPECT_EQ(cache.find(key), value);
  };
  for (std::size_t i = 0; i < good.size(); ++i) {
    std::string bytes = good;
    bytes[i] = static_cast<char>(bytes[i] ^ 0x10);
    is_ignored(bytes);
    is_ignored(good.substr(0, i));
  }
  is_ignored(good + "x");
  // Of another key, under this one's name.
  cache.keep("another key", value);
  for (const fs::path& other : entries(folder.path() / "thimble"))
    if (other != file) is_ignored(content(other));
  // No file at all.
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_FALSE(cache.find(key));
  cache.keep(key, value);
  fs::remove(file);
  ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
  EXPECT_FALSE(cache.find(key));
  fs::remove(file);
  folder.write("elsewhere", good);
  fs::create_symlink(folder.path() / "elsewhere", file);
  EXPECT_FALSE(cache.find(key));
  cache.keep(key, value);
  EXPECT_EQ(cache.find(key), value);
  EXPECT_FALSE(fs::is_symlink(file));
}

TEST(SolvedCache, UsesNoFolderThatOthersMayWriteOrThatIsNone) {
  const TemporaryFolder folder;
  fs::create_directory(folder.path() / "open");
  for (const unsigned mode : {0755U, 0770U, 0701U}) {
    ASSERT_EQ(chmod((folder.path() / "open").c_str(), mode), 0);
    const SolvedCache cache(folder.path() / "open");
    cache.keep("key", "value");
    EXPECT_FALSE(cache.find("key")) << mode;
  }
  EXPECT_TRUE(entries(folder.path() / "open").empty());
  fs::create_directory(folder.path() / "own");
  ASSERT_EQ(chmod((folder.path() / "own").c_str(), 0700), 0);
  fs::create_directory_symlink(folder.path() / "own", folder.path() / "link");
  folder.write("file", "");
  // /proc takes no folder, from root neither.
  for (const fs::path& place : {folder.path() / "link", folder.path() / "file",
                                folder.path() / "file" / "below", fs::path("/proc/thimble"), fs::path()}) {
    const SolvedCache cache(place);
    cache.keep("key", "value");
    EXPECT_FALSE(cache.find("key")) << place;
  }
  EXPECT_TRUE(entries(folder.path() / "own").empty());
}

TEST(SolvedCache, RemovesWhatWasUnusedForLongest) {
  const TemporaryFolder folder;
  const SolvedCache cache(folder.path() / "thimble", 10000);
  const std::string value(2000, 'v');
  const auto pause = [] { usleep(20000); };  // clocks of file systems tick every few ms
  for (const char* key : {"1", "2", "3", "4"}) {
    cache.keep(key, value);
    pause();
  }
  EXPECT_TRUE(cache.find("1"));
  pause();
  cache.keep("5", value);
  EXPECT_TRUE(cache.find("1"));
  EXPECT_FALSE(cache.find("2"));
  EXPECT_TRUE(cache.find("5"));
  cache.keep("large", std::string(20000, 'v'));
  EXPECT_FALSE(cache.find("large"));
  EXPECT_TRUE(cache.find("5"));
}

// Programs that keep and find the same keys at once find the right value or none.
TEST(SolvedCache, MayBeSharedByPrograms) {
  const TemporaryFolder folder;
  const SolvedCache cache(folder.path() / "thimble", 200000);
  const auto value_of = [](std::uint64_t key) {
    return std::string(20000 + 1000 * key, static_cast<char>('a' + key));
  };
  std::vector<pid_t> programs;
  for (unsigned program = 0; program < 4; ++program) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      Random random(program);
      int found = 0;
      bool right = true;
      for (int i = 0; i < (kUnderSanitizers ? 100 : 1000); ++i) {
        const std::uint64_t key = random.below(12);
        const std::string name = "key " + std::to_string(key);
        if (const auto kept = cache.find(name)) {
          ++found;
          right = right && *kept == value_of(key);
        } else {
          cache.keep(name, value_of(key));
        }
      }
      _exit(right && found > 0 ? 0 : 1);
    }
    programs.push_back(child);
  }
  for (const pid_t program : programs) {
    int status = 0;
    ASSERT_EQ(waitpid(program, &status, 0), program);
    EXPECT_EQ(status, 0);
  }
  for (const fs::path& file : entries(folder.path() / "thimble"))
    EXPECT_EQ(file.string().find(".part-"), std::string::npos) << file;
}

host::PotentialProblem random_problem(Random& random) {
  host::PotentialProblem problem;
  const auto solid = [&] {
    host::Solid one;
    one.kind = static_cast<host::Solid::Kind>(random.below(4));
    one.half_size_m = Eigen::Vector3d(random.uniform(0.01, 0.02), random.uniform(0.01, 0.02), 0.01);
    one.radius_m = random.uniform(0.01, 0.02);
    one.half_height_m = random.uniform(0.01, 0.02);
    one.position_m = random.in_box(Eigen::Vector3d::Constant(0.01));
    one.rotation = Eigen::AngleAxisd(random.uniform(0, 3), random.direction());
    return one;
  };
  problem.shape = solid();
  problem.step_m = random.uniform(0.001, 0.002);
  problem.source = random.uniform(0, 50);
  for (std::uint64_t i = random.below(3); i > 0; --i)
    problem.inclusions.push_back({solid(), random.uniform(0, 1), ""});
  for (std::uint64_t i = random.below(3); i > 0; --i)
    problem.regions.push_back({solid(), random.uniform(0, 1)});
  return problem;
}

TEST(SolvedCache, EveryNumberOfAPotentialIsInItsKey) {
  Random random(5);
  for (int run = 0; run < 50; ++run) {
    const host::PotentialProblem base = random_problem(random);
    std::vector<std::function<void(host::PotentialProblem&)>> changes{[](auto& p) { p.step_m *= 1.0000001; },
                                                                      [](auto& p) { p.source += 1e-9; }};
    const auto change_solid = [&](const std::function<host::Solid&(host::PotentialProblem&)>& of) {
      changes.emplace_back([of](auto& p) {
        of(p).kind = static_cast<host::Solid::Kind>((static_cast<int>(of(p).kind) + 1) % 4);
      });
      changes.emplace_back([of](auto& p) { of(p).radius_m += 1e-9; });
      changes.emplace_back([of](auto& p) { of(p).half_height_m += 1e-9; });
      for (const Eigen::Index axis : {0, 1, 2}) {
        changes.emplace_back([of, axis](auto& p) { of(p).half_size_m[axis] += 1e-9; });
        changes.emplace_back([of, axis](auto& p) { of(p).position_m[axis] += 1e-9; });
      }
      for (const Eigen::Index i : {0, 1, 2, 3})
        changes.emplace_back([of, i](auto& p) { of(p).rotation.coeffs()[i] += 1e-9; });
    };
    change_solid([](auto& p) -> host::Solid& { return p.shape; });
    for (std::size_t i = 0; i < base.inclusions.size(); ++i) {
      change_solid([i](auto& p) -> host::Solid& { return p.inclusions[i].solid; });
      changes.emplace_back([i](auto& p) { p.inclusions[i].potential += 1e-9; });
      changes.emplace_back(
          [i](auto& p) { p.inclusions.erase(p.inclusions.begin() + static_cast<std::ptrdiff_t>(i)); });
      // An inclusion is no region with the same numbers.
      changes.emplace_back([i](auto& p) {
        p.regions.insert(p.regions.begin(), {p.inclusions[i].solid, p.inclusions[i].potential});
        p.inclusions.erase(p.inclusions.begin() + static_cast<std::ptrdiff_t>(i));
      });
    }
    for (std::size_t i = 0; i < base.regions.size(); ++i) {
      change_solid([i](auto& p) -> host::Solid& { return p.regions[i].solid; });
      changes.emplace_back([i](auto& p) { p.regions[i].source += 1e-9; });
    }
    std::set<std::string> keys{host::potential_key(base)};
    for (std::size_t i = 0; i < changes.size(); ++i) {
      host::PotentialProblem changed = base;
      changes[i](changed);
      EXPECT_NE(host::potential_key(changed), host::potential_key(base)) << "change " << i;
    }
    EXPECT_EQ(host::potential_key(base), host::potential_key(host::PotentialProblem(base)));
  }
}

// The scene potential with a step of 1 mm, as `thimble compile` does it.
TEST(SolvedCache, TheImageIsTheSameWithAndWithout) {
  std::string text = content(fs::path(THIMBLE_SOURCE_DIR) / "scenes" / "potential" / "potential.scene.json");
  const std::string step = kUnderSanitizers ? "\"step_m\": 0.004" : "\"step_m\": 0.001";
  for (std::size_t at = 0; (at = text.find("\"step_m\": 0.002", at)) != std::string::npos; ++at)
    text.replace(at, step.size(), step);
  const TemporaryFolder folder;
  std::vector<double> shares;
  const auto timed = [&](const std::string& what) {
    shares.clear();
    const auto begin = std::chrono::steady_clock::now();
    std::vector<std::byte> image = host::compile_scene_text(text, "potential", {}).image;
    figure(what + ", s", std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(),
           "reported");
    return image;
  };
  const auto without = timed("potential at 1 mm, compiled without a cache");
  host::CompileHelp help;
  help.cache.emplace(folder.path() / "thimble");
  help.progress = [&](const std::string&, double share) { shares.push_back(share); };
  host::set_compile_help(help);
  const struct Reset {
    ~Reset() { host::set_compile_help({}); }
  } reset;
  EXPECT_EQ(timed("the same, kept"), without);
  EXPECT_GT(shares.size(), 10U);
  EXPECT_EQ(std::ranges::count(shares, 0.0), 3);
  EXPECT_EQ(std::ranges::count(shares, 1.0), 3);
  for (std::size_t i = 1; i < shares.size(); ++i)
    EXPECT_TRUE(shares[i] > shares[i - 1] || shares[i - 1] == 1.0);
  EXPECT_EQ(timed("the same, found"), without);
  EXPECT_EQ(shares.size(), 6U);  // nothing was solved
  Random random(3);
  for (const fs::path& file : entries(folder.path() / "thimble")) {
    std::string bytes = content(file);
    bytes[random.below(bytes.size())] ^= 1;
    overwrite(file, bytes);
  }
  EXPECT_EQ(timed("the same, every entry damaged"), without);
  EXPECT_EQ(timed("the same, found again"), without);
  EXPECT_EQ(shares.size(), 6U);
  for (const fs::path& file : entries(folder.path() / "thimble")) overwrite(file, "");
  EXPECT_EQ(timed("the same, every entry empty"), without);
}

}  // namespace
}  // namespace thimble::test
