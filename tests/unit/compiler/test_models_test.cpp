// Every file of Debian's assimp-testmodels: it compiles or is refused with a clear error; it never crashes
// the process.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <map>

#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/mesh_file.h"
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

TEST(TestModels, EveryFileCompilesOrIsRefusedClearly) {
  const fs::path root = test_model_path("");
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    if (entry.is_regular_file() && entry.file_size() <= kMostBytes) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  std::size_t compiled = 0;
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
      host::TriangleSoup soup = host::read_mesh_file(file, 1.0, name);
      Eigen::Vector3d low = soup.vertices_m[soup.triangles[0][0]];
      Eigen::Vector3d high = low;
      for (const auto& t : soup.triangles) {
        for (const std::uint32_t v : t) {
          low = low.cwiseMin(soup.vertices_m[v]);
          high = high.cwiseMax(soup.vertices_m[v]);
        }
      }
      const double extent = (high - low).maxCoeff();
      for (Eigen::Vector3d& p : soup.vertices_m) {
        p = (p - (low + high) / 2.0) * (0.1 / extent);  // 100 mm, where the file's own unit may be anything
      }
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
  for (const auto& [name, count] : refused) {
    figure("refused: " + name, static_cast<double>(count), "with a cause and a remedy");
  }
  figure("bytes a triangle, worst closed mesh of 80 triangles or more", most_bytes, "for information");
  EXPECT_GE(compiled, kUnderSanitizers ? 200U : 300U);
  EXPECT_LT(figure("seconds, slowest file", slowest_s, "< 60"), 60.0);
}

}  // namespace
}  // namespace thimble::test
