// The inertia of a two-link arm, whose file gives the coefficients of M(q) and G(q) instead of bodies (kinematics::InertiaModel has the
// equations). Adds them to the terms; axes are the joints. Written for the simulated arm and apart from kinematics/dynamics.h.
#pragma once

#include "board/sim/mechanics/arm_dynamics.h"
#include "kinematics/arm_data.h"

namespace thimble::board {

void add_two_link_inertia(const kinematics::InertiaModel& inertia, const JointVector& q,
                          const JointVector& qd, ArmTerms& terms);

}  // namespace thimble::board
