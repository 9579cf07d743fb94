// outside SCENE ARM: renders the force on a fingertip 2 mm below the origin, simulates a hand there, and moves an arm to a point and back. Its figures
// are JSON.
#include <control/renderer.h>
#include <host-tools/arms/arm_data.h>
#include <host-tools/arms/arm_file.h>
#include <host-tools/client/discovery.h>
#include <host-tools/compiler/compile.h>
#include <host-tools/error.h>
#include <host-tools/lab/simulation_run.h>
#include <kinematics/arm.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <span>

using namespace thimble;

namespace {

double rendered_N(const char* file) {
  const host::CompiledScene compiled = host::compile_scene(file);
  control::SceneView scene;
  if (control::SceneView::check(compiled.image, scene) != control::ImageStatus::kOk) return 0;
  static control::Renderer renderer;
  renderer.bind(scene);
  control::Tip tip;
  control::Touch touch;
  for (const float z : {0.001F, -0.002F}) {  // from outside
    tip.position_m = {0.0F, 0.0F, z};
    renderer.tick(std::span(&tip, 1), 1.0F / 4000.0F, std::span(&touch, 1));
  }
  return static_cast<double>(touch.force_N.z());
}

double simulated_N(const char* file) {
  const host::SimulationRun run(
      host::load_image(file),
      {{0.0, {0.0, 0.0, 0.001}, 0}, {0.5, {0.0, 0.0, -0.002}, 0}, {1.0, {0.0, 0.0, -0.002}, 0}});
  board::SimulationOptions options;
  options.ideal = true;
  double last_N = 0;
  static_cast<void>(
      run.go(options, [&](const board::LogRow& row) { last_N = static_cast<double>(row.force_N.z()); }));
  return last_N;
}

// How far the tip is from where the arm was sent.
double missed_m(const char* file) {
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const kinematics::ArmData data = host::arm_data(host::read_arm_file(text, file));
  const kinematics::Arm<double> arm(data);
  const kinematics::Vector3<double> wanted_m(0.01, -0.02, 0.015);
  kinematics::PerAxis<double> axes = arm.home();
  if (!arm.inverse(wanted_m, axes)) return 1;
  kinematics::Posture<double> posture = arm.home_posture();
  arm.move_to(axes, posture);
  return (posture.tip_m - wanted_m).norm();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 3) return 2;
  std::printf(R"({"rendered_N": %.6f, "simulated_N": %.6f, "missed_m": %.9f, "devices": %zu})",
              rendered_N(argv[1]), simulated_N(argv[1]), missed_m(argv[2]), host::discover().size());
} catch (const host::Error& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
