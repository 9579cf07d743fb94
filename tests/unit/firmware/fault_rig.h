// What the fault tests give the controller through its Config: a force source whose force the test says, and an arm model that the test
// may spoil. So the very firmware library meets a force or a model that no sound input produces.
#pragma once

#include <array>
#include <span>

#include "firmware/core/config.h"
#include "firmware/sources/force_source.h"
#include "kinematics/built_in_arms.h"
#include "kinematics/vector.h"

namespace thimble::test {

inline Vec3 scripted_force_N = Vec3::Zero();  // for every tip

class ScriptedSource final : public firmware::ForceSource {
 public:
  ScriptedSource() noexcept : ForceSource({.name = "scripted", .scene = true}) {}
  bool wanted(const firmware::Params&) const noexcept override { return true; }
  void start(const firmware::SourceTick&) noexcept override {}
  void forces(const firmware::SourceTick& tick, firmware::SourceForces& out) noexcept override {
    for (std::size_t i = 0; i < out.arms.size(); ++i)
      out.arms[i] = {scripted_force_N, tick.arms[i].posture.tip_m, 1};
  }
};

// The model of "premium-1.5" in fault_config(): a copy of the library's.
inline std::array<kinematics::ArmData, 1> spoilable_models = {kinematics::built_in_arm("premium-1.5")};
inline kinematics::ArmData& spoilable_model() noexcept { return spoilable_models.front(); }
inline void restore_model() noexcept { spoilable_model() = kinematics::built_in_arm("premium-1.5"); }

// A five-bar whose outer links are almost in line at home.
inline std::array<kinematics::ArmData, 1> five_bars = [] {
  kinematics::ArmData arm = kinematics::built_in_arm("premium-1.5");
  arm.name = {"five-bar"};
  arm.geometry.platform = kinematics::FiveBarGeometry{
      .base_distance_m = .1F, .inner_m = {.06F, .06F}, .outer_m = {.08F, .08F}, .up = true};
  constexpr float kOpen_rad = 1.0664F;
  arm.geometry.home.head<3>() << kinematics::kPi - kOpen_rad, kOpen_rad, 0;
  arm.geometry.driven[2] = false;
  for (kinematics::AxisData& axis : arm.axis) {
    axis.lower = -4;
    axis.upper = 4;
  }
  arm.sum_count = 0;
  arm.has_inertia = false;
  arm.max_joint_speed_rad_s = 4000;
  return std::array{arm};
}();

inline firmware::Config fault_config() {
  static ScriptedSource source;
  static const std::array<firmware::ForceSource*, 1> sources = {&source};
  firmware::Config config;
  config.arms_known = spoilable_models;
  config.sources = sources;
  return config;
}

}  // namespace thimble::test
