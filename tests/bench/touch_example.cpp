// How a C++ program uses the renderer: a scene file in, forces out. Link thimble_control (and
// thimble_compiler for scene files).
//   touch_example scenes/asteroid/asteroid.scene.json
#include <cstdio>
#include <span>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"

using namespace thimble;

int main(int argc, char** argv) try {
  const host::CompiledScene compiled = host::compile_scene(argc > 1 ? argv[1] : "scene.json");
  control::SceneView scene;
  if (const auto status = control::SceneView::check(compiled.image, scene);
      status != control::ImageStatus::kOk) {
    std::fprintf(stderr, "refused: %s\n", control::name(status));
    return 1;
  }
  static control::Renderer renderer;
  renderer.bind(scene);
  // A fingertip that goes down through the origin at 0.1 m/s, at 4 kHz.
  constexpr float kPeriod_s = 1.0F / 4000.0F;
  control::Tip tip;
  control::Touch touch;
  tip.velocity_m_s = {0.0F, 0.0F, -0.1F};
  for (int tick = 0; tick < 8000; ++tick) {
    tip.position_m = {0.0F, 0.0F, 0.1F - 0.1F * kPeriod_s * static_cast<float>(tick)};
    renderer.tick(std::span(&tip, 1), kPeriod_s, std::span(&touch, 1));
    if (touch.contacts > 0) break;
  }
  std::printf("z %.4f m: %d contacts, force %.4f %.4f %.4f N\n", static_cast<double>(tip.position_m.z()),
              touch.contacts, static_cast<double>(touch.force_N.x()), static_cast<double>(touch.force_N.y()),
              static_cast<double>(touch.force_N.z()));
} catch (const host::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return static_cast<int>(error.code);
}
