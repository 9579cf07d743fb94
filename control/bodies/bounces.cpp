// Impacts that would give energy (ContactSolver::bounce_less).
#include <cmath>
#include <cstddef>
#include <span>

#include "control/bodies/contact_solver.h"

namespace thimble::control {

// Twice the work of all contacts in this tick. motions: of the bodies, when it began.
float ContactSolver::work_twice_J(std::span<SolverBody> bodies, std::span<const Motion> motions) noexcept {
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].velocity_m_s += motions[i].velocity_m_s;
    bodies[i].spin_rad_s += motions[i].spin_rad_s;
  }
  constexpr float kRounding = 1.0e-4F;  // of bounces of restitution 1, which do none
  float work_J = 0.0F;
  for (const Patch& patch : found_.patches()) {
    work_J += patch.impulse_N_s.dot(slip_speed(bodies, patch));
    for (std::size_t i = 0; i < patch.count; ++i) {
      const PatchPoint& p = found_.point(patch, i);
      work_J += p.impulse_N_s * (separation_speed(bodies, patch, p.row) - kRounding * std::abs(p.target_m_s));
    }
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    bodies[i].velocity_m_s -= motions[i].velocity_m_s;
    bodies[i].spin_rad_s -= motions[i].spin_rad_s;
  }
  return work_J;
}

// Newton's restitution gives energy where friction turns the motion during the impact (Kane and Levinson 1985). Then the bodies bounce less.
void ContactSolver::bounce_less(std::span<SolverBody> bodies, std::span<const Motion> motions) noexcept {
  constexpr int kMaxRounds = 8;
  constexpr float kLess = 0.8F;
  for (int round = 0; round < kMaxRounds && work_twice_J(bodies, motions) > 0.0F; ++round) {
    for (Patch& patch : found_.patches()) {
      for (std::size_t i = 0; i < patch.count; ++i) {
        PatchPoint& p = found_.point(patch, i);
        if (p.bounces) p.target_m_s *= kLess;
      }
    }
    relax(bodies);
  }
}

}  // namespace thimble::control
