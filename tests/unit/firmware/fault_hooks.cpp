#include "tests/unit/firmware/fault_hooks.h"

#include "control/renderer.h"

namespace thimble {

namespace kinematics {
// The library's own, compiled under another name (CMakeLists.txt); the program's arm_models() and
// find_arm_model() follow.
std::span<const ArmModel> library_arm_models() noexcept;
}  // namespace kinematics

namespace test {

Vec3 scripted_force_N = Vec3::Zero();

kinematics::ArmModel& spoilable_model() noexcept {
  static kinematics::ArmModel model = kinematics::library_arm_models().front();
  return model;
}
void restore_model() noexcept { spoilable_model() = kinematics::library_arm_models().front(); }

}  // namespace test

namespace kinematics {

std::span<const ArmModel> arm_models() noexcept { return {&test::spoilable_model(), 1}; }
const ArmModel* find_arm_model(std::string_view name) noexcept {
  return name == test::spoilable_model().name ? &test::spoilable_model() : nullptr;
}

}  // namespace kinematics

namespace control {

void Renderer::bind(const SceneView&, Binding) noexcept {}
void Renderer::reset() noexcept {}
void Renderer::tick(std::span<const Tip> tips, float, std::span<Touch> touches) noexcept {
  for (std::size_t i = 0; i < tips.size(); ++i) touches[i] = {test::scripted_force_N, tips[i].position_m, 1};
}

}  // namespace control
}  // namespace thimble
