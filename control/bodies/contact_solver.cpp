#include "control/bodies/contact_solver.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/bodies/pair_motion.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::control {
namespace {

constexpr int kSolverIterations = 10;
constexpr int kRelaxIterations = 4;
// The iterations end when no impulse changes the velocity of its contact by more than this.
constexpr float kConverged_m_s = 1.0e-5F;
// The same for springs, as a length: about the rounding of a coordinate of 1 m.
constexpr float kRounding_m = 1.0e-7F;
// A contact that closes more slowly than this does not bounce. Gravity alone gives 10 mm/s in one tick at 1
// kHz.
constexpr float kBounce_m_s = 0.02F;
// Bodies of which neither can move along the normal touch below this gap.
constexpr float kRest_m = 2.0e-5F;
// The spring and damper of a contact (Catto 2024): a quarter of the tick rate, overdamped.
constexpr float kTurnsPerTick = 0.25F;
constexpr float kDampingRatio = 10.0F;
constexpr float kMaxPush_m_s = 1.0F;  // of the velocity that removes penetration
// What a patch takes, besides its points (control/work.h).
constexpr std::uint32_t kPrepareWork = 9;
constexpr std::uint32_t kStickingWork = 3;
constexpr std::uint32_t kSlidingWork = 8;

ContactSolver::Softness softness(float period_s) {
  constexpr float kAngle = 2.0F * std::numbers::pi_v<float> * kTurnsPerTick;  // in a tick
  constexpr float kA1 = 2.0F * kDampingRatio + kAngle;
  constexpr float kA2 = kAngle * kA1;
  constexpr float kA3 = 1.0F / (1.0F + kA2);
  const float bias_per_s = kAngle / (kA1 * period_s);
  return {bias_per_s, kA2 * kA3, kA3, bias_per_s * kRounding_m};
}

float least_mass(const Patch& patch) { return patch.mass.diagonal().minCoeff(); }

// It moves, and the friction is opposite to the motion: of all impulses at the limit the one that leaves the least energy. The response to
// the turn can be far from that along the surface: steps along the slip would not come to it (More and Sorensen 1983).
Vec3 sliding_impulse(Patch& patch, const Vec3& sticking_N_s, float limit_N_s) {
  constexpr int kMaxRounds = 3;
  constexpr float kNear = 0.01F;
  constexpr float kAlone = 1.0e4F;          // a drag beside which the response does not count
  constexpr float kNothing_N_s = 1.0e-10F;  // a 10000th of what 1 g weighs in 0.1 ms; its square is not yet 0
  if (limit_N_s <= kNothing_N_s) return Vec3::Zero();
  Vec3 impulse = Vec3::Zero();
  float length = 0.0F;
  for (int round = 0; round < kMaxRounds; ++round) {
    const Mat3 part = (Mat3::Identity() + patch.drag_per_kg * patch.mass).inverse();
    impulse = part * sticking_N_s;
    length = impulse.norm();
    const float over = length - limit_N_s;
    if (std::abs(over) <= kNear * limit_N_s) break;
    const Vec3 along = impulse / length;
    const float gain = over / (limit_N_s * along.dot(patch.mass * (part * along)));
    patch.drag_per_kg = std::clamp(patch.drag_per_kg + gain, 0.0F, kAlone / least_mass(patch));
  }
  return limit_N_s / length * impulse;
}

}  // namespace

ContactSolver::ContactSolver() noexcept = default;

void ContactSolver::reset() noexcept {
  found_.clear();
  grips_.clear();
  stored_count_ = stored_point_count_ = recalled_ = 0;
}

float ContactSolver::friction_limit_N_s(const Patch& patch) noexcept {
  float normal_N_s = patch.held_N_s;
  for (std::size_t i = 0; i < patch.count; ++i) normal_N_s += found_.point(patch, i).impulse_N_s;
  return (patch.sliding ? patch.dynamic_friction : patch.static_friction) * normal_N_s;
}

// Returns the change of velocity.
float ContactSolver::solve_friction(std::span<SolverBody> bodies, Patch& patch,
                                    const Softness& softness) noexcept {
  const float limit = friction_limit_N_s(patch);
  const Vec3 speed = slip_speed(bodies, patch) + softness.bias_per_s * patch.slip_m;
  Vec3 impulse = patch.impulse_N_s - patch.mass * speed;
  if (impulse.squaredNorm() > limit * limit) impulse = sliding_impulse(patch, impulse, limit);
  const Vec3 change = impulse - patch.impulse_N_s;
  const float mass = least_mass(patch);
  const float change_m_s = mass > 0.0F ? change.cwiseAbs().maxCoeff() / mass : 0.0F;
  if (is_rounding(change_m_s, softness)) return 0.0F;
  patch.impulse_N_s = impulse;
  apply_friction_impulse(bodies, patch, change);
  return change_m_s;
}

// Each iteration begins with another point: what is left of an iteration presses on the points that come first, and would tilt every body
// of a stack the same way. A contact is soft as soon as it is closed: where it becomes so, a body at rest would chatter.
float ContactSolver::solve_normals(std::span<SolverBody> bodies, Patch& patch,
                                   const Softness& softness) noexcept {
  float most = 0.0F;
  PairMotion motion(bodies, patch);
  std::size_t next = patch.count == 0 ? 0 : static_cast<std::size_t>(iteration_) % patch.count;
  for (std::size_t i = 0; i < patch.count; ++i) {
    PatchPoint& p = found_.point(patch, next);
    next = next + 1 == patch.count ? 0 : next + 1;
    if (p.row.mass <= 0.0F) continue;
    const bool soft = p.depth_m > 0.0F && !p.bounces;
    const float push_m_s = soft ? std::min(softness.bias_per_s * p.depth_m, kMaxPush_m_s) : p.target_m_s;
    const float missing_m_s = push_m_s - motion.separation_speed(p.row);
    const float mass = soft ? softness.mass_scale * p.row.mass : p.row.mass;
    const float kept = soft ? 1.0F - softness.impulse_scale : 1.0F;
    const float impulse = std::max(kept * p.impulse_N_s + mass * missing_m_s, 0.0F);
    const float change = impulse - p.impulse_N_s;
    const float change_m_s = std::abs(change) / p.row.mass;
    if (change == 0.0F || is_rounding(change_m_s, softness)) continue;
    motion.add(p.row, change);
    p.impulse_N_s = impulse;
    most = std::max(most, change_m_s);
  }
  if (most > 0.0F) motion.store(bodies, patch);
  return most;
}

// The centre of pressure and the mean distance from it, by the impulses of the previous tick, or else with all points
// alike; the effective mass there.
void ContactSolver::prepare_friction(std::span<const SolverBody> bodies, Patch& patch) noexcept {
  float sum = 0.0F;
  for (std::size_t i = 0; i < patch.count; ++i) sum += found_.point(patch, i).impulse_N_s;
  constexpr float kNothing_N_s = 1.0e-20F;  // one over it is still a number
  const bool bears = sum > kNothing_N_s;
  const float share = 1.0F / (bears ? sum : static_cast<float>(patch.count));
  const auto weight = [&](const PatchPoint& p) { return bears ? p.impulse_N_s * share : share; };
  patch.centre_m = Vec3::Zero();
  for (std::size_t i = 0; i < patch.count; ++i) {
    const PatchPoint& p = found_.point(patch, i);
    patch.centre_m += weight(p) * p.point_m;
  }
  patch.radius_m = 0.0F;
  for (std::size_t i = 0; patch.count > 1 && i < patch.count; ++i) {
    const PatchPoint& p = found_.point(patch, i);
    patch.radius_m += weight(p) * (p.point_m - patch.centre_m).norm();
  }
  patch.impulse_N_s[2] *= patch.radius_m > 0.0F ? 1.0F / patch.radius_m : 0.0F;
  patch.slip_m[2] *= patch.radius_m;
  Mat3 response = response_of(bodies[patch.a], patch);
  if (patch.b != kNoBody) response += response_of(bodies[patch.b], patch);
  const float trace = response.trace();
  if (trace <= kNoResponse) {
    patch.mass = Mat3::Zero();
    patch.impulse_N_s = Vec3::Zero();
    return;
  }
  // A direction in which neither body can move has no friction, and the matrix stays regular.
  constexpr float kRegular = 1.0e-4F;
  for (int i = 0; i < 3; ++i) {
    if (response(i, i) < kRegular * trace) patch.impulse_N_s[i] = 0.0F;
    response(i, i) += kRegular * trace;
  }
  patch.mass = response.inverse();
}

void ContactSolver::prepare(std::span<const SolverBody> bodies, Patch& patch, float period_s) noexcept {
  const float restitution =
      std::max(bodies[patch.a].restitution, patch.b == kNoBody ? 0.0F : bodies[patch.b].restitution);
  patch.across[0] = patch.normal.unitOrthogonal();
  patch.across[1] = patch.normal.cross(patch.across[0]);
  bool moves = false;
  bool touches = false;
  const NormalRow* before = nullptr;
  const PairMotion motion(bodies, patch);
  for (std::size_t i = 0; i < patch.count; ++i) {
    PatchPoint& p = found_.point(patch, i);
    set_row(bodies, patch, p.point_m, before, p.row);
    before = &p.row;
    touches = touches || p.depth_m >= -kRest_m;
    if (p.row.mass <= 0.0F) continue;
    moves = true;
    p.target_m_s = -std::max(-p.depth_m, 0.0F) / period_s;
    if (restitution <= 0.0F) continue;
    const float approach = motion.separation_speed(p.row);
    if (approach < -kBounce_m_s && approach < p.target_m_s) {
      // It bounces with the speed with which the tick began: that of the whole tick's fall would add m g T v to the energy of each bounce.
      float gained_m_s = p.row.normal.dot(bodies[patch.a].gained_m_s);
      if (patch.b != kNoBody) gained_m_s -= p.row.normal.dot(bodies[patch.b].gained_m_s);
      p.target_m_s = restitution * std::max(gained_m_s - approach, 0.0F);
      p.bounces = bounces_ = true;
    }
  }
  if (!moves && touches) {
    // Neither body can move along the normal: the constraint force sets the friction limit.
    float held = -bodies[patch.a].constrained_N_s.dot(patch.normal);
    if (patch.b != kNoBody) held = std::min(held, bodies[patch.b].constrained_N_s.dot(patch.normal));
    patch.held_N_s = std::max(held, 0.0F);
  }
}

void ContactSolver::warm_start(std::span<SolverBody> bodies, Patch& patch) noexcept {
  PairMotion motion(bodies, patch);
  for (std::size_t i = 0; i < patch.count; ++i) {
    const PatchPoint& p = found_.point(patch, i);
    motion.add(p.row, p.impulse_N_s);
  }
  motion.store(bodies, patch);
  apply_friction_impulse(bodies, patch, patch.impulse_N_s);
}

// After the soft iterations: the velocities are those that the bodies move with.
void ContactSolver::add_slip(std::span<const SolverBody> bodies, float period_s) noexcept {
  grips_.add_twist(bodies, period_s);
  for (Patch& patch : found_.patches()) {
    if (!patch.sliding) patch.slip_m += period_s * slip_speed(bodies, patch);
  }
}

void ContactSolver::decide_sliding() noexcept {
  grips_.decide_sliding();
  for (Patch& patch : found_.patches()) {
    const float limit = friction_limit_N_s(patch);
    const float at_limit = kAtLimit * limit;
    if (limit <= 0.0F) {
      patch.slip_m = Vec3::Zero();
      patch.sliding = false;
    } else if (patch.impulse_N_s.squaredNorm() < at_limit * at_limit) {
      patch.sliding = false;
    } else if (patch.slip_m.squaredNorm() > kSlipped_m * kSlipped_m) {
      patch.sliding = true;
      patch.slip_m = Vec3::Zero();
    }
  }
}

// False: it goes on with the next patch.
bool ContactSolver::iterate(std::span<SolverBody> bodies, const Softness& softness, int most,
                            Work& work) noexcept {
  const std::span<Patch> patches = found_.patches();
  while (iteration_ < most) {
    if (at_ == 0 && grips_.count() != 0) {
      change_m_s_ = grips_.solve(bodies, softness.bias_per_s, iteration_ == 0 ? softness.least_m_s : 0.0F);
      work.charge(static_cast<std::uint32_t>(grips_.count()));
    }
    while (at_ < patches.size()) {
      Patch& patch = patches[at_++];
      change_m_s_ = std::max(change_m_s_, solve_friction(bodies, patch, softness));
      change_m_s_ = std::max(change_m_s_, solve_normals(bodies, patch, softness));
      work.charge((patch.sliding ? kSlidingWork : kStickingWork) + patch.count);
      if (work.left() == 0) return false;
    }
    at_ = 0;
    ++iteration_;
    if (change_m_s_ < std::max(kConverged_m_s, softness.least_m_s)) break;
    change_m_s_ = 0.0F;
  }
  iteration_ = 0;
  change_m_s_ = 0.0F;
  return true;
}

void ContactSolver::begin(const World& world, std::span<const SolverBody> bodies, std::span<const Grip> grips,
                          float period_s) noexcept {
  found_.clear();
  bounces_ = false;
  grips_.begin(bodies, grips, period_s);
  search_.begin(world, bodies, period_s);
  stage_ = Stage::kPrepare;
  at_ = 0;
  iteration_ = bounce_rounds_ = 0;
  change_m_s_ = 0.0F;
}

bool ContactSolver::prepare_all(std::span<SolverBody> bodies, float period_s, Work& work) noexcept {
  const std::span<Patch> patches = found_.patches();
  if (at_ == 0 && grips_.count() != 0) {
    grips_.prepare(bodies);
    work.charge(static_cast<std::uint32_t>(grips_.count()));
  }
  while (at_ < patches.size()) {
    Patch& patch = patches[at_++];
    prepare(bodies, patch, period_s);
    recall(bodies, patch);
    prepare_friction(bodies, patch);
    work.charge(kPrepareWork + 3U * patch.count);
    if (work.left() == 0) return false;
  }
  at_ = 0;
  return true;
}

bool ContactSolver::warm_start_all(std::span<SolverBody> bodies, Work& work) noexcept {
  const std::span<Patch> patches = found_.patches();
  if (at_ == 0) grips_.warm_start(bodies);
  while (at_ < patches.size()) {
    Patch& patch = patches[at_++];
    warm_start(bodies, patch);
    work.charge(2U + patch.count);
    if (work.left() == 0) return false;
  }
  at_ = 0;
  return true;
}

// After the soft iterations the bodies' motion in this tick is known.
void ContactSolver::end_soft(std::span<SolverBody> bodies, float period_s, Work& work) noexcept {
  for (SolverBody& body : bodies) {
    body.correction_m = period_s * body.velocity_m_s;
    body.correction_rad = period_s * body.spin_rad_s;
  }
  add_slip(bodies, period_s);
  work.charge(static_cast<std::uint32_t>(bodies.size() / 4 + found_.patches().size()));
}

void ContactSolver::end_relax(std::span<SolverBody> bodies, float period_s, Work& work) noexcept {
  for (SolverBody& body : bodies) {
    body.correction_m -= period_s * body.velocity_m_s;
    body.correction_rad -= period_s * body.spin_rad_s;
  }
  decide_sliding();
  store_impulses(bodies);
  work.charge(static_cast<std::uint32_t>(bodies.size() / 4 + 2 * found_.patches().size()));
}

bool ContactSolver::solve(std::span<SolverBody> bodies, float period_s, Work& work) noexcept {
  for (;;) {
    switch (stage_) {
      case Stage::kPrepare:
        if (!prepare_all(bodies, period_s, work)) return false;
        stage_ = Stage::kWarmStart;
        break;
      case Stage::kWarmStart:
        if (!warm_start_all(bodies, work)) return false;
        if (found_.patches().empty() && grips_.count() == 0) {
          grips_.store();
          keep_of_sleepers(bodies);
          return true;
        }
        stage_ = Stage::kSoft;
        break;
      case Stage::kSoft:
        if (!iterate(bodies, softness(period_s), kSolverIterations, work)) return false;
        end_soft(bodies, period_s, work);
        stage_ = Stage::kRelax;
        break;
      case Stage::kRelax:  // with rigid contacts: what pushed penetration out adds no velocity
        if (!iterate(bodies, Softness{}, kRelaxIterations, work)) return false;
        if (bounces_ && bounce_less(bodies, work)) break;
        end_relax(bodies, period_s, work);
        return true;
    }
  }
}

}  // namespace thimble::control
