// What the fault tests put in place of the renderer and the arm models at link time, so that the very
// firmware library can be given a force or a model that no sound input produces.
#pragma once

#include "kinematics/arm_model.h"
#include "kinematics/vector.h"

namespace thimble::test {

extern Vec3 scripted_force_N;  // what the renderer answers for every tip

// The model that the next controllers use for "premium-1.5": a copy of the library's that a test may spoil.
[[nodiscard]] kinematics::ArmModel& spoilable_model() noexcept;
void restore_model() noexcept;

}  // namespace thimble::test
