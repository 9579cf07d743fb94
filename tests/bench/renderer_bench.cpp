// ns per tick of the whole renderer (complete solution, friction on) along the path that is used to compare
// haptic engines, together with Embree's segment query on the same mesh and path in the same run.
// docs/bench.md has usage and results.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "tests/bench/bodies.h"
#include "tests/bench/embree_scene.h"
#include "tests/support/ideal_run.h"

namespace thimble::test {
namespace {

using Clock = std::chrono::steady_clock;

double ns_since(Clock::time_point start) {
  return std::chrono::duration<double, std::nano>(Clock::now() - start).count();
}

// The renderer along the path of a body, with as many tips as it has arms.
class RendererPass {
 public:
  explicit RendererPass(const BenchBody& body)
      : body_(body), tips_(body.path.size() * body.arms), touches_(tips_.size()) {
    for (std::size_t i = 0; i < tips_.size(); ++i) {
      const std::size_t tick = i / body.arms;
      tips_[i].position_m = body.path[tick].cast<float>();
      if (tick > 0)
        tips_[i].velocity_m_s = ((body.path[tick] - body.path[tick - 1]) * kRate_Hz).cast<float>();
    }
  }

  [[nodiscard]] double ns() {
    control::Renderer renderer;
    renderer.bind(body_.image->view());
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < tips_.size(); i += body_.arms) tick(renderer, i);
    benchmark::DoNotOptimize(touches_.data());
    return ns_since(start) / static_cast<double>(body_.path.size());
  }
  // The worst tick: each tick timed by itself, the least of several passes for each, and the most of those.
  [[nodiscard]] double worst_us() {
    constexpr int kPasses = 7;
    std::vector<double> least_ns(tips_.size(), 1e12);
    for (int pass = 0; pass < kPasses; ++pass) {
      control::Renderer renderer;
      renderer.bind(body_.image->view());
      for (std::size_t i = 0; i < tips_.size(); i += body_.arms) {
        const Clock::time_point start = Clock::now();
        tick(renderer, i);
        least_ns[i] = std::min(least_ns[i], ns_since(start));
      }
    }
    double worst_ns = 0.0;
    for (std::size_t i = 0; i < tips_.size(); i += body_.arms) worst_ns = std::max(worst_ns, least_ns[i]);
    return 1e-3 * worst_ns;
  }
  [[nodiscard]] const Vec3& tip_m(std::size_t tick) const { return tips_[tick * body_.arms].position_m; }
  [[nodiscard]] const control::Touch& touch(std::size_t tick) const { return touches_[tick * body_.arms]; }

 private:
  void tick(control::Renderer& renderer, std::size_t first) {
    renderer.tick(std::span(&tips_[first], body_.arms), 1.0F / static_cast<float>(kRate_Hz),
                  std::span(&touches_[first], body_.arms));
  }

  const BenchBody& body_;
  std::vector<control::Tip> tips_;
  std::vector<control::Touch> touches_;
};

// Embree on the same path: the segment a renderer would ask for, from just outside where the god object was to where the tip is.
class EmbreePass {
 public:
  EmbreePass(const BenchBody& body, const RendererPass& renderer)
      : scene_(body.soup), from_(body.path.size()), to_(body.path.size()) {
    for (std::size_t i = 0; i < from_.size(); ++i) {
      const Vec3& last_m = renderer.touch(i == 0 ? 0 : i - 1).god_object_m;
      from_[i] = last_m + 1e-5F * last_m.normalized();
      to_[i] = renderer.tip_m(i);
    }
  }
  [[nodiscard]] double ns() const {
    std::size_t hits = 0;
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < from_.size(); ++i) hits += scene_.segment(from_[i], to_[i]) ? 1U : 0U;
    benchmark::DoNotOptimize(hits);
    return ns_since(start) / static_cast<double>(from_.size());
  }

 private:
  EmbreeScene scene_;
  std::vector<Vec3> from_, to_;
};

// The fastest of the passes, which take turns: so both see the machine in the same state.
void bench(benchmark::State& state, const std::string& name) {
  const BenchBody body = bench_body(name);
  RendererPass renderer(body);
  double renderer_ns = renderer.ns();
  std::optional<EmbreePass> embree;
  if (!body.soup.triangles.empty()) embree.emplace(body, renderer);
  double embree_ns = embree ? embree->ns() : 0.0;
  for (auto _ : state) {
    const double ns = renderer.ns();
    renderer_ns = std::min(renderer_ns, ns);
    if (embree) embree_ns = std::min(embree_ns, embree->ns());
    state.SetIterationTime(1e-9 * ns * static_cast<double>(body.path.size()));
  }
  std::size_t touching = 0;
  for (std::size_t i = 0; i < body.path.size(); ++i) touching += renderer.touch(i).contacts > 0 ? 1U : 0U;
  state.counters["triangles"] = static_cast<double>(body.soup.triangles.size());
  state.counters["bytes_per_triangle"] = body.bytes_per_triangle;
  state.counters["renderer_ns"] = renderer_ns;
  state.counters["embree_ns"] = embree_ns;
  state.counters["worst_us"] = renderer.worst_us();
  state.counters["contact_percent"] =
      100.0 * static_cast<double>(touching) / static_cast<double>(body.path.size());
}

// Google Benchmark's own report, and after it the table of docs/bench.md.
class Table : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      const auto counter = [&run](const char* name) { return run.counters.at(name).value; };
      const double embree_ns = counter("embree_ns");
      const std::string ratio =
          embree_ns > 0.0 ? fmt::format("{:.0f} | {:.2f}", embree_ns, counter("renderer_ns") / embree_ns)
                          : "- | -";
      rows_ += fmt::format("| {} | {:.0f} | {:.1f} | {:.0f} | {} | {:.2f} | {:.0f} % |\n",
                           run.run_name.function_name, counter("triangles"), counter("bytes_per_triangle"),
                           counter("renderer_ns"), ratio, counter("worst_us"), counter("contact_percent"));
    }
  }
  void Finalize() override {
    fmt::print(
        "\n| body | triangles | bytes per triangle | renderer, ns per tick | Embree segment, ns | ratio | "
        "worst tick, us | in contact "
        "|\n|---|---|---|---|---|---|---|---|\n{}",
        rows_);
  }

 private:
  std::string rows_;
};

int run(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  for (const char* name : {"icosphere-80",
                           "icosphere-320",
                           "icosphere-1280",
                           "icosphere-5120",
                           "icosphere-20480",
                           "icosphere-81920",
                           "icosphere-327680",
                           "icosphere-20480+plane",
                           "icosphere-20480+far",
                           "icosphere-20480+arms",
                           "icosphere-20480+shaded",
                           "icosphere-20480+textured",
                           "knot",
                           "lumpy",
                           "3DS/fels.3ds",
                           "OBJ/spider.obj",
                           "OFF/Wuson.off",
                           "Collada/duck.dae",
                           "BLEND/HUMAN.blend",
                           "AC/SphereWithLightUvScaling4X.ac",
                           "glTF2/draco/2CylinderEngine.gltf",
                           "sphere",
                           "box"})
    benchmark::RegisterBenchmark(name, [name](benchmark::State& state) { bench(state, name); })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.4);
  Table table;
  benchmark::RunSpecifiedBenchmarks(&table);
  return 0;
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) { return thimble::test::run(argc, argv); }
