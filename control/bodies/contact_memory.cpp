// What the contact solver keeps of a step for the warm start of the next one (control/bodies/contact_solver.h).
#include <cstddef>
#include <cstdint>

#include "control/bodies/contact_solver.h"

namespace thimble::control {
namespace {

// A contact point of the previous tick within this distance is the same one.
constexpr float kSamePlace_m = 2.0e-3F;
// So near that no other one is nearer: place and normal.
constexpr float kSurelySame_m = 1.0e-5F;
constexpr float kUnchanged = 0.999F;

}  // namespace

// Takes over the impulses of the same patch in the previous tick.
void ContactSolver::recall(std::span<const SolverBody> bodies, Patch& patch) noexcept {
  const StoredPatch* best = nullptr;
  float alike = kSameDirection;
  // Patches are mostly found in the same order.
  for (std::size_t i = 0; i < stored_count_ && alike < kUnchanged; ++i) {
    if (++recalled_ >= stored_count_) recalled_ = 0;
    const StoredPatch& stored = stored_[recalled_];
    if (stored.object_a != patch.object_a || stored.object_b != patch.object_b) continue;
    if (const float cosine = stored.normal.dot(patch.normal); cosine > alike) {
      alike = cosine;
      best = &stored;
    }
  }
  if (best == nullptr) return;
  patch.sliding = best->sliding;
  // The third ones are for a radius of 1 m until prepare_friction.
  patch.slip_m = {best->slip_m.dot(patch.across[0]), best->slip_m.dot(patch.across[1]), best->twist_rad};
  patch.impulse_N_s = {best->along_N_s.dot(patch.across[0]), best->along_N_s.dot(patch.across[1]),
                       best->moment_N_m_s};
  std::array<bool, kMaxPatchPoints> taken{};
  std::array<PatchPoint*, kMaxPatchPoints> fresh{};
  std::size_t fresh_count = 0;
  for (std::size_t i = 0; i < patch.count; ++i) {
    PatchPoint& p = found_.point(patch, i);
    if (p.row.mass <= 0.0F) continue;
    const Vec3 place_m = p.point_m - bodies[patch.a].centre_m;
    float nearest = kSamePlace_m * kSamePlace_m;
    std::size_t same = best->count;
    for (std::size_t k = 0; k < best->count && nearest > kSurelySame_m * kSurelySame_m; ++k) {
      const std::size_t j = (i + k) % best->count;
      const float distance = (stored_points_[best->first + j].place_m - place_m).squaredNorm();
      if (!taken[j] && distance < nearest) {
        nearest = distance;
        same = j;
      }
    }
    if (same == best->count) {
      fresh[fresh_count++] = &p;
      continue;
    }
    taken[same] = true;
    p.impulse_N_s = stored_points_[best->first + same].normal_N_s;
  }
  // What the points that are gone have borne, the new ones bear: the limit of the friction stays.
  float gone_N_s = 0.0F;
  for (std::size_t j = 0; j < best->count; ++j)
    gone_N_s += taken[j] ? 0.0F : stored_points_[best->first + j].normal_N_s;
  for (std::size_t i = 0; i < fresh_count; ++i)
    fresh[i]->impulse_N_s = gone_N_s / static_cast<float>(fresh_count);
}

// Of what is stored, only the patches of those bodies: they go on when the bodies wake.
void ContactSolver::keep_of_sleepers(std::span<const SolverBody> bodies) noexcept {
  std::size_t kept = 0;
  std::size_t points = 0;
  for (std::size_t i = 0; i < stored_count_; ++i) {
    if (!bodies[stored_[i].a].asleep) continue;
    StoredPatch& to = stored_[kept];
    if (kept != i) to = stored_[i];
    for (std::size_t k = 0; k < to.count; ++k) stored_points_[points + k] = stored_points_[to.first + k];
    to.first = static_cast<std::uint8_t>(points);
    points += to.count;
    ++kept;
  }
  stored_count_ = kept;
  stored_point_count_ = points;
}

// An impact ends in its tick: nothing of it is stored.
void ContactSolver::store_impulses(std::span<const SolverBody> bodies) noexcept {
  grips_.store();
  keep_of_sleepers(bodies);
  if (stored_count_ + found_.patches().size() > stored_.size() ||
      stored_point_count_ + found_.points() > stored_points_.size())
    stored_count_ = stored_point_count_ = 0;
  for (const Patch& patch : found_.patches()) {
    StoredPatch& stored = stored_[stored_count_++];
    stored.a = patch.a;
    stored.first = static_cast<std::uint8_t>(stored_point_count_);
    stored.object_a = patch.object_a;
    stored.object_b = patch.object_b;
    stored.count = patch.count;
    stored.sliding = patch.sliding;
    stored.normal = patch.normal;
    stored.slip_m = patch.slip_m[0] * patch.across[0] + patch.slip_m[1] * patch.across[1];
    stored.twist_rad = patch.radius_m > 0.0F ? patch.slip_m[2] / patch.radius_m : 0.0F;
    bool bounces = false;
    for (std::size_t i = 0; i < patch.count; ++i) {
      const PatchPoint& p = found_.point(patch, i);
      bounces = bounces || p.bounces;
      stored_points_[stored_point_count_++] = {p.point_m - bodies[patch.a].centre_m,
                                               p.bounces ? 0.0F : p.impulse_N_s};
    }
    stored.along_N_s = Vec3::Zero();
    stored.moment_N_m_s = 0.0F;
    if (bounces) continue;
    stored.along_N_s = patch.impulse_N_s[0] * patch.across[0] + patch.impulse_N_s[1] * patch.across[1];
    stored.moment_N_m_s = patch.radius_m * patch.impulse_N_s[2];
  }
}

}  // namespace thimble::control
