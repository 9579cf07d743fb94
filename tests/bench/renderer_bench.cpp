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

std::vector<control::Tip> tips_along(const std::vector<Vector3d>& path) {
  std::vector<control::Tip> tips(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    tips[i].position_m = path[i].cast<float>();
    if (i > 0) tips[i].velocity_m_s = ((path[i] - path[i - 1]) * kRate_Hz).cast<float>();
  }
  return tips;
}

// The renderer along the path of a body.
class RendererPass {
 public:
  explicit RendererPass(const BenchBody& body)
      : body_(body), tips_(tips_along(body.path)), touches_(tips_.size()) {}

  // each(i): called after each tick.
  template <typename Each>
  void run(const Each& each) {
    control::Renderer renderer;
    renderer.bind(body_.image->view());
    for (std::size_t i = 0; i < tips_.size(); ++i) {
      std::array<control::Tip, control::kMaxArms> tips;
      tips.fill(tips_[i]);
      std::array<control::Touch, control::kMaxArms> touches;
      renderer.tick(std::span(tips).first(body_.arms), 1.0F / static_cast<float>(kRate_Hz),
                    std::span(touches).first(body_.arms));
      touches_[i] = touches[0];
      each(i);
    }
  }
  [[nodiscard]] double ns() {
    const Clock::time_point start = Clock::now();
    run([](std::size_t) {});
    benchmark::DoNotOptimize(touches_.data());
    return ns_since(start) / static_cast<double>(tips_.size());
  }
  // The worst tick: each tick timed by itself, the least of several passes for each, and the most of those.
  [[nodiscard]] double worst_us() {
    constexpr int kPasses = 7;
    std::vector<double> least_ns(tips_.size(), 1e12);
    for (int pass = 0; pass < kPasses; ++pass) {
      Clock::time_point start = Clock::now();
      run([&](std::size_t i) {
        least_ns[i] = std::min(least_ns[i], ns_since(start));
        start = Clock::now();
      });
    }
    return 1e-3 * *std::max_element(least_ns.begin(), least_ns.end());
  }
  [[nodiscard]] const std::vector<control::Tip>& tips() const { return tips_; }
  [[nodiscard]] const std::vector<control::Touch>& touches() const { return touches_; }

 private:
  const BenchBody& body_;
  std::vector<control::Tip> tips_;
  std::vector<control::Touch> touches_;
};

// Embree on the same path: the segment a renderer would ask for, from just outside where the god object was to where the tip is.
class EmbreePass {
 public:
  EmbreePass(const host::TriangleSoup& soup, const RendererPass& renderer)
      : scene_(soup), tips_(renderer.tips()), from_(tips_.size()) {
    for (std::size_t i = 0; i < tips_.size(); ++i) {
      const Vec3& last_m = renderer.touches()[i == 0 ? 0 : i - 1].god_object_m;
      from_[i] = last_m + 1e-5F * last_m.normalized();
    }
  }
  [[nodiscard]] double ns() const {
    std::size_t hits = 0;
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < tips_.size(); ++i)
      hits += scene_.segment(from_[i], tips_[i].position_m) ? 1U : 0U;
    benchmark::DoNotOptimize(hits);
    return ns_since(start) / static_cast<double>(tips_.size());
  }

 private:
  EmbreeScene scene_;
  const std::vector<control::Tip>& tips_;
  std::vector<Vec3> from_;
};

// The fastest of the passes, which take turns: so both see the machine in the same state.
void bench(benchmark::State& state, const std::string& name) {
  const BenchBody body = bench_body(name);
  RendererPass renderer(body);
  double renderer_ns = renderer.ns();
  std::optional<EmbreePass> embree;
  if (!body.soup.triangles.empty()) embree.emplace(body.soup, renderer);
  double embree_ns = embree ? embree->ns() : 0.0;
  for (auto _ : state) {
    const double ns = renderer.ns();
    renderer_ns = std::min(renderer_ns, ns);
    if (embree) embree_ns = std::min(embree_ns, embree->ns());
    state.SetIterationTime(1e-9 * ns * static_cast<double>(body.path.size()));
  }
  const auto touching = std::count_if(renderer.touches().begin(), renderer.touches().end(),
                                      [](const control::Touch& touch) { return touch.contacts > 0; });
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
