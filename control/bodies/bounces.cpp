// Impacts that would give energy (ContactSolver::bounce_less).
#include <cmath>
#include <cstddef>
#include <span>

#include "control/bodies/contact_solver.h"
#include "control/bodies/pair_motion.h"

namespace thimble::control {

constexpr int kMaxBounceRounds = 8;

// Twice the work of all contacts in this step.
float ContactSolver::work_twice_J(std::span<SolverBody> bodies) noexcept {
  for (SolverBody& body : bodies) {
    body.velocity_m_s += body.begin_m_s;
    body.spin_rad_s += body.begin_rad_s;
  }
  constexpr float kRounding = 1.0e-4F;  // of bounces of restitution 1, which do none
  float work_J = grips_.work_twice_J(bodies);
  for (const Patch& patch : found_.patches()) {
    work_J += patch.impulse_N_s.dot(slip_speed(bodies, patch));
    const PairMotion motion(bodies, patch);
    for (std::size_t i = 0; i < patch.count; ++i) {
      const PatchPoint& p = found_.point(patch, i);
      work_J += p.impulse_N_s * (motion.separation_speed(p.row) - kRounding * std::abs(p.target_m_s));
    }
  }
  for (SolverBody& body : bodies) {
    body.velocity_m_s -= body.begin_m_s;
    body.spin_rad_s -= body.begin_rad_s;
  }
  return work_J;
}

// Newton's restitution gives energy where friction turns the motion during the impact (Kane and Levinson 1985). Then the bodies bounce less:
// true, and the iterations go on.
bool ContactSolver::bounce_less(std::span<SolverBody> bodies, Work& work) noexcept {
  constexpr float kLess = 0.8F;
  if (bounce_rounds_ == kMaxBounceRounds) return false;
  work.charge(static_cast<std::uint32_t>(bodies.size() / 4 + found_.points() + 2 * found_.patches().size() +
                                         grips_.count()));
  if (!(work_twice_J(bodies) > 0.0F)) return false;
  ++bounce_rounds_;
  for (Patch& patch : found_.patches()) {
    for (std::size_t i = 0; i < patch.count; ++i) {
      PatchPoint& p = found_.point(patch, i);
      if (p.bounces) p.target_m_s *= kLess;
    }
  }
  return true;
}

}  // namespace thimble::control
