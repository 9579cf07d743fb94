// Instructions per tick of the whole renderer, counted by callgrind: `tests/bench/instructions` runs this
// program under it. Only the ticks are instrumented, so everything before them runs fast.
//
//   tick_instructions BODY TICKS     BODY: of tests/bench/bodies.h, or a NAME.scene.json with NAME.stroke.csv or stroke.csv in its folder,
//                                    repeated; or a layout of bodies_bench (3-at-rest, 16-at-rest, 16-afloat, stack-of-16), awake, at most 300 ticks
// It prints how many ticks it has done.
#include <valgrind/callgrind.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <string>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "tests/bench/bodies.h"
#include "tests/bench/box_layouts.h"
#include "tests/bench/scene_path.h"
#include "tests/support/ideal_run.h"

namespace thimble::test {
namespace {

int run_scene(const std::string& file, int ticks) {
  const ScenePath scene = scene_path(file);
  control::Renderer renderer;
  renderer.bind(scene.image.view());
  std::array<control::Touch, control::kMaxArms> touches;
  CALLGRIND_START_INSTRUMENTATION;
  for (int i = 0; i < ticks; ++i) {
    renderer.tick(std::span(scene.tips[static_cast<std::size_t>(i) % scene.tips.size()].data(), scene.arms),
                  1.0F / static_cast<float>(kRate_Hz), std::span(touches.data(), scene.arms));
  }
  CALLGRIND_STOP_INSTRUMENTATION;
  std::printf("%s: %d ticks\n", file.c_str(), ticks);
  return 0;
}

int run_boxes(const Layout& layout, int most_ticks) {
  constexpr int kSettles = 400;
  constexpr int kAwake = 300;  // ticks after that in which none sleeps yet
  const int ticks = std::min(most_ticks, kAwake);
  constexpr float kPeriod_s = 1.0F / 4000.0F;
  const SceneImage image(host::compile_scene_text(box_scene(layout), "bench.scene.json", ".").image);
  control::Renderer renderer;
  renderer.bind(image.view());
  for (int i = 0; i < kSettles; ++i) renderer.tick({}, kPeriod_s, {});
  CALLGRIND_START_INSTRUMENTATION;
  for (int i = 0; i < ticks; ++i) renderer.tick({}, kPeriod_s, {});
  CALLGRIND_STOP_INSTRUMENTATION;
  std::printf("%s: %d ticks\n", layout.name.c_str(), ticks);
  return 0;
}

int run(const std::string& name, int ticks) {
  const BenchBody body = bench_body(name, {.ticks = ticks, .noise_m = 2e-6, .seed = 1, .lifts = true});
  control::Renderer renderer;
  renderer.bind(body.image->view());
  float sum_N = 0.0F;
  CALLGRIND_START_INSTRUMENTATION;
  for (const Vector3d& p : body.path) {
    std::array<control::Tip, control::kMaxArms> tips;
    tips.fill({.position_m = p.cast<float>(), .velocity_m_s = Vec3::Zero()});
    std::array<control::Touch, control::kMaxArms> touches;
    renderer.tick(std::span(tips).first(body.arms), 1.0F / static_cast<float>(kRate_Hz),
                  std::span(touches).first(body.arms));
    sum_N += touches[0].force_N.norm();
  }
  CALLGRIND_STOP_INSTRUMENTATION;
  std::printf("%s: %zu ticks, mean force %.3f N\n", name.c_str(), body.path.size(),
              static_cast<double>(sum_N) / static_cast<double>(body.path.size()));
  return 0;
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: tick_instructions BODY TICKS\n");
    return 2;
  }
  const std::string body = argv[1];
  for (const thimble::test::Layout& layout : thimble::test::box_layouts())
    if (body == layout.name) return thimble::test::run_boxes(layout, std::stoi(argv[2]));
  if (body.ends_with(".json")) return thimble::test::run_scene(body, std::stoi(argv[2]));
  return thimble::test::run(body, std::stoi(argv[2]));
}
