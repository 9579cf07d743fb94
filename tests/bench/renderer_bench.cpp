// ns per tick of the whole renderer (complete solution, friction on) along the path that is used to compare
// haptic engines, together with Embree's segment query on the same mesh and path in the same run.
// docs/bench.md has usage and results.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
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

// The fastest of the passes: what the machine does when nothing else runs on the core.
struct Row {
  std::string name;
  std::size_t triangles = 0;
  double bytes_per_triangle = 0;
  double renderer_ns = 0;
  double embree_ns = 0;
  double worst_us = 0;
  double contact_share = 0;
};

std::vector<Row>& rows() {
  static std::vector<Row> all;
  return all;
}

Row& row_of(const std::string& name) {
  for (Row& row : rows()) {
    if (row.name == name) return row;
  }
  rows().push_back({.name = name});
  return rows().back();
}

double least(double before, double now) { return before == 0.0 ? now : std::min(before, now); }

std::vector<control::Tip> tips_along(const std::vector<Vector3d>& path) {
  std::vector<control::Tip> tips(path.size());
  for (std::size_t i = 0; i < path.size(); ++i) {
    tips[i].position_m = path[i].cast<float>();
    if (i > 0) tips[i].velocity_m_s = ((path[i] - path[i - 1]) * kRate_Hz).cast<float>();
  }
  return tips;
}

// One pass along the path; the touches, for those who want them.
void render_path(const control::SceneView& scene, const std::vector<control::Tip>& tips,
                 std::vector<control::Touch>& touches) {
  control::Renderer renderer;
  renderer.bind(scene);
  constexpr float kPeriod_s = 1.0F / static_cast<float>(kRate_Hz);
  for (std::size_t i = 0; i < tips.size(); ++i)
    renderer.tick(std::span(&tips[i], 1), kPeriod_s, std::span(&touches[i], 1));
}

// The worst tick: each tick timed by itself, the least of several passes for each, and the most of those.
double worst_tick_us(const control::SceneView& scene, const std::vector<control::Tip>& tips) {
  constexpr int kPasses = 7;
  constexpr float kPeriod_s = 1.0F / static_cast<float>(kRate_Hz);
  std::vector<double> ns(tips.size(), 1e12);
  for (int pass = 0; pass < kPasses; ++pass) {
    control::Renderer renderer;
    renderer.bind(scene);
    for (std::size_t i = 0; i < tips.size(); ++i) {
      control::Touch touch;
      const Clock::time_point start = Clock::now();
      renderer.tick(std::span(&tips[i], 1), kPeriod_s, std::span(&touch, 1));
      ns[i] = std::min(ns[i], ns_since(start));
      benchmark::DoNotOptimize(touch);
    }
  }
  return 1e-3 * *std::max_element(ns.begin(), ns.end());
}

void bench_renderer(benchmark::State& state, const std::string& name, const control::SceneView& scene,
                    const std::vector<Vector3d>& path) {
  const std::vector<control::Tip> tips = tips_along(path);
  std::vector<control::Touch> touches(tips.size());
  double best_ns = 0.0;
  for (auto _ : state) {
    const Clock::time_point start = Clock::now();
    render_path(scene, tips, touches);
    const double ns = ns_since(start);
    benchmark::DoNotOptimize(touches.data());
    best_ns = least(best_ns, ns / static_cast<double>(tips.size()));
    state.SetIterationTime(1e-9 * ns);
  }
  Row& row = row_of(name);
  row.renderer_ns = least(row.renderer_ns, best_ns);
  row.worst_us = worst_tick_us(scene, tips);
  const auto touching =
      std::count_if(touches.begin(), touches.end(), [](const auto& touch) { return touch.contacts > 0; });
  row.contact_share = static_cast<double>(touching) / static_cast<double>(touches.size());
  state.counters["ns_per_tick"] = best_ns;
  state.counters["worst_tick_us"] = row.worst_us;
}

void bench_embree(benchmark::State& state, const MeshBody& body) {
  const EmbreeScene scene(body.soup);
  const std::vector<control::Tip> tips = tips_along(body.path);
  std::vector<control::Touch> touches(tips.size());
  render_path(body.image.view(), tips, touches);
  // The segment a renderer would ask for: from just outside where the god object was to where the tip is.
  std::vector<Vec3> from(tips.size());
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const control::Touch& last = touches[i == 0 ? 0 : i - 1];
    const Vec3 out = last.god_object_m.normalized();
    from[i] = last.god_object_m + 1e-5F * out;
  }
  double best_ns = 0.0;
  std::size_t hits = 0;
  for (auto _ : state) {
    hits = 0;
    const Clock::time_point start = Clock::now();
    for (std::size_t i = 0; i < tips.size(); ++i)
      hits += scene.segment(from[i], tips[i].position_m) ? 1U : 0U;
    const double ns = ns_since(start);
    benchmark::DoNotOptimize(hits);
    best_ns = least(best_ns, ns / static_cast<double>(tips.size()));
    state.SetIterationTime(1e-9 * ns);
  }
  Row& row = row_of(body.name);
  row.embree_ns = least(row.embree_ns, best_ns);
  state.counters["ns_per_query"] = best_ns;
  state.counters["hits"] = static_cast<double>(hits) / static_cast<double>(tips.size());
}

void print_table() {
  std::printf(
      "\n| body | triangles | bytes a triangle | renderer, ns a tick | Embree segment, ns | ratio | worst "
      "tick, us | in contact |\n");
  std::printf("|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : rows()) {
    std::printf("| %s | %zu | %.1f | %.0f | %.0f | %.2f | %.2f | %.0f %% |\n", row.name.c_str(),
                row.triangles, row.bytes_per_triangle, row.renderer_ns, row.embree_ns,
                row.embree_ns > 0.0 ? row.renderer_ns / row.embree_ns : 0.0, row.worst_us,
                100.0 * row.contact_share);
  }
}

int run(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  std::vector<MeshBody> bodies;
  for (int subdivisions = 1; subdivisions <= 7; ++subdivisions) {
    const host::TriangleSoup soup = icosphere(subdivisions, 0.05);
    bodies.push_back(make_body("icosphere " + std::to_string(soup.triangles.size()), soup));
  }
  bodies.push_back(
      make_body("icosphere 20480, shaded", icosphere(5, 0.05), {host::MeshSide::kOutside, 60.0}));
  for (const char* file :
       {"3DS/fels.3ds", "OBJ/spider.obj", "OFF/Wuson.off", "Collada/duck.dae", "BLEND/HUMAN.blend",
        "AC/SphereWithLightUvScaling4X.ac", "glTF2/draco/2CylinderEngine.gltf"}) {
    bodies.push_back(make_body(file, test_model(file, 0.1)));
  }
  const SceneImage sphere = SceneBuilder().sphere(0.05, kPeerMaterial).image();
  const SceneImage box = SceneBuilder().box({0.1, 0.1, 0.1}, kPeerMaterial).image();
  const std::vector<Vector3d> sphere_path = peer_path_on_sphere(0.05);
  const std::vector<Vector3d> box_path = peer_path(MeshOracle(box_mesh({0.1, 0.1, 0.1}, 1)));

  const auto add = [](const std::string& name, auto function) {
    benchmark::RegisterBenchmark(name.c_str(), function)
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond)
        ->MinTime(0.4);
  };
  for (const MeshBody& body : bodies) {
    Row& row = row_of(body.name);
    row.triangles = body.soup.triangles.size();
    row.bytes_per_triangle = body.bytes_per_triangle;
    add("renderer/" + body.name,
        [&](benchmark::State& state) { bench_renderer(state, body.name, body.image.view(), body.path); });
    add("embree/" + body.name, [&](benchmark::State& state) { bench_embree(state, body); });
  }
  add("renderer/sphere",
      [&](benchmark::State& state) { bench_renderer(state, "sphere", sphere.view(), sphere_path); });
  add("renderer/box", [&](benchmark::State& state) { bench_renderer(state, "box", box.view(), box_path); });
  benchmark::RunSpecifiedBenchmarks();
  print_table();
  return 0;
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) { return thimble::test::run(argc, argv); }
