// What the fault tests give the controller through its Config: a force source whose force the test says, and an arm model that the test
// may spoil. So the very firmware library meets a force or a model that no sound input produces.
#pragma once

#include <array>
#include <span>

#include "firmware/core/config.h"
#include "firmware/sources/force_source.h"
#include "kinematics/arm_model.h"
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
inline std::array<kinematics::ArmModel, 1> spoilable_models = {kinematics::arm_models().front()};
inline kinematics::ArmModel& spoilable_model() noexcept { return spoilable_models.front(); }
inline void restore_model() noexcept { spoilable_model() = kinematics::arm_models().front(); }

inline firmware::Config fault_config() {
  static ScriptedSource source;
  static const std::array<firmware::ForceSource*, 1> sources = {&source};
  firmware::Config config;
  config.arm_models = spoilable_models;
  config.sources = sources;
  return config;
}

}  // namespace thimble::test
