// The renderer under motions that no hand makes (tests/support/adversary.h), beside Embree's segment query on the same mesh and path, with the
// work that a board gives to a tick. Prints the table of docs/bench.md.
//
//   adversary_bench [UNITS]     default 300
//
// Passes of the two alternate; the figure of a tick is the least of the passes.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "control/renderer.h"
#include "tests/bench/embree_scene.h"
#include "tests/support/adversary.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"

namespace thimble::test {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kPasses = 5;
constexpr std::size_t kTicks = 8000;
constexpr double kRadius_m = 0.05;

struct Ticks {
  std::vector<double> ns = std::vector<double>(kTicks, 1e18);
  void take(std::size_t i, Clock::time_point start) {
    ns[i] = std::min(ns[i], std::chrono::duration<double, std::nano>(Clock::now() - start).count());
  }
  [[nodiscard]] double worst_us() const { return 1e-3 * *std::ranges::max_element(ns); }
  [[nodiscard]] double median_ns() const {
    std::vector<double> sorted = ns;
    std::ranges::nth_element(sorted, sorted.begin() + kTicks / 2);
    return sorted[kTicks / 2];
  }
};

void bench(const std::string& name, const host::TriangleSoup& soup, std::uint32_t units) {
  const host::CompiledMesh mesh = host::compile_mesh(soup, {}, name);
  const EmbreeScene embree(as_soup(mesh));
  const SceneImage image =
      SceneBuilder().mesh(mesh, {.static_friction = 0.6F, .dynamic_friction = 0.4F}).image();
  for (std::size_t attack = 0; attack < kAttacks.size(); ++attack) {
    const std::vector<Eigen::Vector3d> path = attack_path(kAttacks.at(attack), kRadius_m, kTicks, 1);
    Ticks ours, theirs;
    std::vector<std::uint32_t> work(kTicks);
    std::vector<Vec3> from(kTicks);
    std::size_t put_off = 0, hits = 0;
    for (int pass = 0; pass < kPasses; ++pass) {
      control::Renderer renderer;
      renderer.bind(image.view());
      renderer.bound_work(units);
      control::Tip tip;
      control::Touch touch;
      put_off = 0;
      for (std::size_t i = 0; i < kTicks; ++i) {
        from[i] = touch.god_object_m + 1e-5F * touch.god_object_m.normalized();
        tip.position_m = path[i].cast<float>();
        const Clock::time_point start = Clock::now();
        renderer.tick(std::span(&tip, 1), 1.0F / static_cast<float>(kRate_Hz), std::span(&touch, 1));
        ours.take(i, start);
        work[i] = renderer.tick_work();
        put_off += renderer.is_put_off() ? 1U : 0U;
      }
      for (std::size_t i = 0; i < kTicks; ++i) {
        const Vec3 to = path[i].cast<float>();
        const Clock::time_point start = Clock::now();
        hits += embree.segment(from[i], to) ? 1U : 0U;
        theirs.take(i, start);
      }
    }
    std::ranges::sort(work);
    std::printf("| %s | %zu | %s | %.0f | %.1f | %.0f | %.1f | %u | %u | %.1f %% |%s\n", name.c_str(),
                mesh.triangles.size(), kAttackNames.at(attack), ours.median_ns(), ours.worst_us(),
                theirs.median_ns(), theirs.worst_us(), work[kTicks / 2], work.back(),
                100.0 * static_cast<double>(put_off) / static_cast<double>(kTicks),
                hits == 0 ? " (no hits)" : "");
    std::fflush(stdout);
  }
}

host::TriangleSoup crossing_boxes() {
  host::TriangleSoup all;
  for (int n = 0; n < 40; ++n) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(0.7 * n, Eigen::Vector3d(1, 0.3 * n, 2).normalized()).toRotationMatrix();
    const host::TriangleSoup part =
        transformed(box_mesh({0.05, 0.03, 0.02}, 4), turn, 0.02 * Eigen::Vector3d(turn.col(0)));
    const auto first = static_cast<std::uint32_t>(all.vertices_m.size());
    all.vertices_m.insert(all.vertices_m.end(), part.vertices_m.begin(), part.vertices_m.end());
    for (const auto& t : part.triangles) all.triangles.push_back({first + t[0], first + t[1], first + t[2]});
  }
  return all;
}

void run(std::uint32_t units) {
  std::printf(
      "| body | triangles | motion | median, ns | worst, us | Embree median, ns | worst, us | median units | "
      "most | put off |\n");
  std::printf("|---|---|---|---|---|---|---|---|---|---|\n");
  bench("icosphere", icosphere(7, kRadius_m), units);
  bench("terrain", hostile_terrain(64, 1.5e-3, 3e-3, 1), units);
  bench("sheet, open", sheet(0.1, 200), units);
  bench("boxes, crossing", crossing_boxes(), units);
  for (const char* file : {"OFF/Wuson.off", "OBJ/spider.obj", "glTF2/draco/2CylinderEngine.gltf"})
    bench(file, test_model(file, 2.0 * kRadius_m), units);
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  thimble::test::run(argc > 1 ? static_cast<std::uint32_t>(std::strtoul(argv[1], nullptr, 10)) : 300);
  return 0;
}
