// Slow motions there and back with the board's servo: what torque it takes.
#pragma once

#include "host-tools/commission/estimate.h"
#include "host-tools/commission/steps.h"

namespace thimble::host {

// The motion from one place to another, with gains for the arm at home; its times are the caller's. From a place to the same: the arm is held there.
[[nodiscard]] ServoProgram servo_to(const Expectation& arm, const board::JointVector& from,
                                    const board::JointVector& to);

// All driven axes together, by `way` to each side of a place; both in rad, and by per_radian() of an axis that slides.
[[nodiscard]] PerAxis<Sweep> sweep_all(StepContext& context, const board::JointVector& at, double way,
                                       double speed);
// One axis, the others held by the servo.
[[nodiscard]] Sweep sweep_one(StepContext& context, std::size_t axis, const board::JointVector& at,
                              double way, double speed);

}  // namespace thimble::host
