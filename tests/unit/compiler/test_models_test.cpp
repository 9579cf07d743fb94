// Every file of Debian's assimp-testmodels: it compiles or is refused with a clear error; it never crashes
// the process.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_file.h"
#include "host-tools/compiler/mesh_repair.h"
#include "host-tools/error.h"
#include "tests/support/assimp_leaks.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/sanitizers.h"
#include "tests/unit/compiler/sound_mesh.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;

// Under the sanitizers the large ones would take minutes.
constexpr std::uintmax_t kMostBytes = kUnderSanitizers ? 100'000 : std::numeric_limits<std::uintmax_t>::max();

std::vector<fs::path> model_files(std::uintmax_t most_bytes) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(test_model_path(""))) {
    if (entry.is_regular_file() && entry.file_size() <= most_bytes) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

// 100 mm large, as the file's own unit may be anything.
host::TriangleSoup scaled_model(const fs::path& file, const std::string& name) {
  host::TriangleSoup soup = host::read_mesh_file(file, 1.0, name);
  Eigen::AlignedBox3d box;
  for (const auto& t : soup.triangles)
    for (const std::uint32_t v : t) box.extend(soup.vertices_m[v]);
  const double scale = 0.1 / box.sizes().maxCoeff();
  for (Eigen::Vector3d& p : soup.vertices_m) p = (p - box.center()) * scale;
  return soup;
}

TEST(TestModels, EveryFileCompilesOrIsRefusedClearly) {
  const fs::path root = test_model_path("");
  const std::vector<fs::path> files = model_files(kMostBytes);
  std::size_t compiled = 0;
  std::size_t with_open_edges = 0;
  std::size_t with_crossings = 0;
  std::map<std::string, std::size_t> refused;
  double slowest_s = 0;
  double most_bytes = 0;
  std::printf("%-68s %9s %8s %7s %7s %6s %6s %7s\n", "file", "triangles", "open", "crossed", "dropped",
              "B/tri", "depth", "s");
  for (const fs::path& file : files) {
    const std::string name = fs::relative(file, root).string();
    const auto start = std::chrono::steady_clock::now();
    const auto seconds = [&] {
      return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    };
    try {
      const host::TriangleSoup soup = scaled_model(file, name);
      host::MeshOptions options;
      options.crease_deg = 40;
      const host::CompiledMesh mesh = host::compile_mesh(soup, options, name);
      EXPECT_EQ(unsound(mesh), "") << name;
      const host::MeshReport& report = mesh.report;
      const double bytes = static_cast<double>(report.bytes) / static_cast<double>(report.triangles);
      std::printf("%-68s %9zu %8zu %7zu %7zu %6.1f %6u %7.3f\n", name.c_str(), report.triangles,
                  report.open_edges, report.pierced_triangles, report.degenerate_dropped, bytes, report.depth,
                  seconds());
      if (report.open_edges == 0 && report.triangles >= 80) {
        most_bytes = std::max(most_bytes, bytes);
      }
      ++compiled;
      with_open_edges += report.open_edges > 0 ? 1 : 0;
      with_crossings += report.pierced_triangles > 0 ? 1 : 0;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.code, host::ExitCode::kBadInput) << name;
      EXPECT_EQ(error.cause.rfind(name + ": ", 0), 0U) << error.cause;
      EXPECT_FALSE(error.remedy.empty()) << name;
      std::printf("%-68s %s\n", name.c_str(), error.name.c_str());
      ++refused[error.name];
    }
    slowest_s = std::max(slowest_s, seconds());
  }
  figure("files", static_cast<double>(files.size()), "each one above");
  figure("compiled to a sound mesh", static_cast<double>(compiled), ">= 300; >= 200 under the sanitizers");
  figure("of them with open edges", static_cast<double>(with_open_edges), "for information");
  figure("of them with triangles that touch or cross others", static_cast<double>(with_crossings),
         "for information");
  for (const auto& [name, count] : refused) {
    figure("refused: " + name, static_cast<double>(count), "with a cause and a remedy");
  }
  figure("bytes a triangle, worst closed mesh of 80 triangles or more", most_bytes, "for information");
  EXPECT_GE(compiled, kUnderSanitizers ? 200U : 300U);
  EXPECT_LT(figure("seconds, slowest file", slowest_s, "< 60"), 60.0);
}

// What `thimble mesh` makes of closed models that cross. THIMBLE_REPAIR_BYTES sets the size of the largest file; a tenth of it is the
// largest number of triangles.
TEST(TestModels, ClosedModelsThatCrossBecomeTheirOuterSurface) {
  const char* bytes =
      std::getenv("THIMBLE_REPAIR_BYTES");  // NOLINT(concurrency-mt-unsafe): before any thread
  const double most_bytes = bytes == nullptr ? 2e4 : std::strtod(bytes, nullptr);
  std::size_t crossing = 0;
  std::size_t resolved = 0;
  std::size_t in_part = 0;
  for (const fs::path& file : model_files(static_cast<std::uintmax_t>(most_bytes))) {
    const std::string name = fs::relative(file, test_model_path("")).string();
    try {
      const host::TriangleSoup soup = scaled_model(file, name);
      if (10.0 * static_cast<double>(soup.triangles.size()) > most_bytes) continue;
      const host::MeshReport before = host::compile_mesh(soup, {}, name).report;
      if (before.open_edges > 0 || before.pierced_triangles == 0) continue;
      ++crossing;
      const host::RepairReport report = host::repair_mesh(soup, {}, name).report;
      EXPECT_EQ(report.after.open_edges, 0U) << name;
      const bool done = report.resolved == host::Resolved::kYes;
      resolved += done && report.after.pierced_triangles == 0 ? 1 : 0;
      in_part += done && report.after.pierced_triangles != 0 ? 1 : 0;
      std::printf("%-68s %7zu triangles, %6zu touch or cross others; then %7zu, %6zu: %s\n", name.c_str(),
                  before.triangles, before.pierced_triangles, report.after.triangles,
                  report.after.pierced_triangles, done ? "resolved" : "left");
    } catch (const host::Error&) {  // listed above
    }
  }
  figure("closed models that cross", static_cast<double>(crossing), "");
  figure("closed models that cross: resolved", static_cast<double>(resolved), "");
  figure("closed models that cross: resolved in part", static_cast<double>(in_part), "");
  figure("closed models that cross: left", static_cast<double>(crossing - resolved - in_part),
         "at most a tenth");
  EXPECT_GT(crossing, 0U);
  EXPECT_LE(10 * (crossing - resolved - in_part), crossing);
}

}  // namespace
}  // namespace thimble::test
