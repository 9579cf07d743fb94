// Prints tables of docs/bench.md.
//
//   scene_bench                ns per tick of every demonstration: each scene of scenes/ along its stroke, all arms in one tick
//   scene_bench --board CORE   which of them runs at which rate on a core, or on all (scene_rates.h)
//
// Exit codes: 0, 2 usage.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/renderer.h"
#include "tests/bench/scene_path.h"
#include "tests/bench/scene_rates.h"
#include "tests/support/ideal_run.h"

namespace thimble::test {
namespace {

using Clock = std::chrono::steady_clock;
constexpr int kPasses = 9;
constexpr float kPeriod_s = 1.0F / static_cast<float>(kRate_Hz);

double ns_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

void bench(const std::filesystem::path& file, const std::string& name) {
  const ScenePath scene = scene_path(file);
  const std::size_t ticks = scene.tips.size();
  // The fastest of the passes for the whole way, and for each tick by itself.
  double best_ns = 1e18;
  std::vector<double> tick_ns(ticks, 1e18);
  std::size_t touching = 0;
  control::Renderer renderer;
  for (int pass = 0; pass < 2 * kPasses; ++pass) {
    const bool whole = pass % 2 == 0;
    renderer.bind(scene.image.view());
    touching = 0;
    std::array<control::Touch, control::kMaxArms> touches;
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < ticks; ++i) {
      const Clock::time_point before = whole ? start : Clock::now();
      renderer.tick(std::span(scene.tips[i].data(), scene.arms), kPeriod_s,
                    std::span(touches.data(), scene.arms));
      if (!whole) tick_ns[i] = std::min(tick_ns[i], ns_since(before));
      if (touches[0].contacts > 0 || touches[1].contacts > 0) ++touching;
    }
    if (whole) best_ns = std::min(best_ns, ns_since(start));
  }
  std::printf("| %s | %u | %zu | %zu | %.0f | %.2f | %.0f %% |\n", name.c_str(),
              scene.image.view().scene()->objects()->size(), scene.image.bytes().size(), scene.arms,
              best_ns / static_cast<double>(ticks), 1e-3 * *std::max_element(tick_ns.begin(), tick_ns.end()),
              100.0 * static_cast<double>(touching) / static_cast<double>(ticks));
}

void bench_all() {
  std::printf("| scene | objects | image, bytes | arms | ns a tick | worst tick, us | in contact |\n");
  std::printf("|---|---|---|---|---|---|---|\n");
  for (const auto& [name, file] : demonstrations()) bench(file, name);
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  const std::span<char*> words(argv, static_cast<std::size_t>(argc));
  if (words.size() == 1) {
    thimble::test::bench_all();
    return 0;
  }
  const bool of_board = words.size() == 3 && std::string_view(words[1]) == "--board";
  const std::string table = of_board ? thimble::test::scene_rates(words[2]) : "";
  if (table.empty()) {
    std::fprintf(stderr, "scene_bench [--board all | %s]\n", thimble::test::core_names().c_str());
    return 2;
  }
  std::puts(table.c_str());
  return 0;
}
