#include "control/bodies/contact_patches.h"

#include <algorithm>

namespace thimble::control {
namespace {

// Points whose normals differ by less than 25 degrees form one patch.
constexpr float kSameNormal = 0.906F;
// One choice is better than another only by this share: rounding does not change the choice from tick to tick.
constexpr float kClearly = 1.0F + 1.0e-3F;
// A point that is less deep than the deepest by this counts as half as far.
constexpr float kLessDeep_m = 1.0e-5F;

// Points that differ in depth by less are level.
constexpr float kLevelDepth_m = 1.0e-6F;

// A lambda: algorithms call it directly, not through a pointer.
constexpr auto is_less_deep = [](const ContactPoint* a, const ContactPoint* b) {
  return a->depth_m < b->depth_m;
};

constexpr std::uint32_t kLookWork = 3;  // at all patches

using Candidates = std::array<const ContactPoint*, kMaxManifold>;

// Moves the candidate with the highest score to place `to`.
template <typename Score>
void choose(Candidates& from, std::size_t count, std::size_t to, Score score) {
  std::size_t best = to;
  float highest = score(*from[to]);
  for (std::size_t i = to + 1; i < count; ++i) {
    const float now = score(*from[i]);
    if (now > kClearly * std::max(highest, 0.0F)) {
      highest = now;
      best = i;
    }
  }
  std::swap(from[to], from[best]);
}

// The deepest point, of level ones the outermost, so that rounding does not choose it; the one farthest from it, the one that spans the largest triangle with both, and the one
// that lies farthest outside this triangle. A point that is less deep counts as nearer: on rough ground an open point
// farther out would take the place of one that bears, and the body would rock on the points that are left.
[[gnu::cold]] std::size_t reduce(Candidates& points, std::size_t count) {
  if (count <= kMaxPatchPoints) return count;
  const auto end = points.begin() + static_cast<std::ptrdiff_t>(count);
  const float deepest_m = (*std::max_element(points.begin(), end, is_less_deep))->depth_m;
  Vec3 middle = Vec3::Zero();
  for (std::size_t i = 0; i < count; ++i) middle += points[i]->point_m / static_cast<float>(count);
  choose(points, count, 0, [&](const ContactPoint& p) {
    return p.depth_m < deepest_m - kLevelDepth_m ? 0.0F : (p.point_m - middle).squaredNorm();
  });
  const Vec3& p0 = points[0]->point_m;
  const auto share = [&](const ContactPoint& p) {
    return kLessDeep_m / (kLessDeep_m + deepest_m - p.depth_m);
  };
  const auto share2 = [&](const ContactPoint& p) { return share(p) * share(p); };
  choose(points, count, 1, [&](const ContactPoint& p) { return share2(p) * (p.point_m - p0).squaredNorm(); });
  const Vec3& p1 = points[1]->point_m;
  choose(points, count, 2,
         [&](const ContactPoint& p) { return share2(p) * (p.point_m - p0).cross(p1 - p0).squaredNorm(); });
  const Vec3& p2 = points[2]->point_m;
  const Vec3 turn = (p1 - p0).cross(p2 - p0);
  choose(points, count, 3, [&](const ContactPoint& p) {
    const auto outside = [&](const Vec3& from, const Vec3& to) {
      return (p.point_m - from).cross(to - from).dot(turn);
    };
    return share(p) * std::max({outside(p0, p1), outside(p1, p2), outside(p2, p0)});
  });
  return kMaxPatchPoints;
}

}  // namespace

void ContactPatches::clear() noexcept {
  patch_count_ = 0;
  used_ = 0;
  if (in_order_) return;
  for (std::size_t i = 0; i < free_.size(); ++i) free_[i] = static_cast<std::uint8_t>(i);
  in_order_ = true;
}

// Takes the least deep point from a patch.
void ContactPatches::drop_point(Patch& patch) noexcept {
  std::size_t least = 0;
  for (std::size_t i = 1; i < patch.count; ++i) {
    if (point(patch, i).depth_m < point(patch, least).depth_m) least = i;
  }
  in_order_ = false;
  free_[--used_] = patch.points[least];
  patch.points[least] = patch.points[--patch.count];
}

// How many of the chosen points a new patch gets: the first ones. The patches with the most points lose one first;
// of equal ones the least deep.
std::size_t ContactPatches::make_room(Chosen& chosen, std::size_t count, float deepest_m,
                                      Effort& effort) noexcept {
  while (used_ + count > points_.size()) {
    Patch* most = nullptr;
    for (Patch& patch : patches()) {
      const bool more = most == nullptr || patch.count > most->count ||
                        (patch.count == most->count && patch.deepest_m < most->deepest_m);
      if (more) most = &patch;
    }
    const bool own =
        most == nullptr || count > most->count || (count == most->count && deepest_m <= most->deepest_m);
    ++effort.counters.contact_bound;
    effort.work.charge(kLookWork);
    if (!own) {
      drop_point(*most);
      continue;
    }
    const auto end = chosen.begin() + static_cast<std::ptrdiff_t>(count);
    std::iter_swap(std::min_element(chosen.begin(), end, is_less_deep), end - 1);
    --count;
  }
  return count;
}

Patch* ContactPatches::place_for(float deepest_m, Effort& effort) noexcept {
  if (patch_count_ < patches_.size()) return &patches_[patch_count_++];
  ++effort.counters.contact_bound;
  effort.work.charge(kLookWork);
  Patch* least = nullptr;
  for (Patch& patch : patches()) {
    if (patch.count != 0 && (least == nullptr || patch.deepest_m < least->deepest_m)) least = &patch;
  }
  if (least == nullptr || least->deepest_m >= deepest_m) return nullptr;
  while (least->count != 0) drop_point(*least);
  return least;
}

void ContactPatches::add(const PatchPair& pair, const Manifold& manifold, Effort& effort) noexcept {
  std::array<bool, kMaxManifold> taken{};
  for (std::size_t i = 0; i < manifold.count; ++i) {
    if (taken[i]) continue;
    Candidates of_patch;
    std::size_t count = 0;
    for (std::size_t j = i; j < manifold.count; ++j) {
      if (taken[j] || manifold.points[i].normal.dot(manifold.points[j].normal) < kSameNormal) continue;
      taken[j] = true;
      of_patch[count++] = &manifold.points[j];
    }
    effort.work.charge(2U + static_cast<std::uint32_t>(count));
    count = reduce(of_patch, count);
    Chosen chosen;
    std::copy_n(of_patch.begin(), count, chosen.begin());
    const float deepest_m =
        (*std::max_element(chosen.begin(), chosen.begin() + static_cast<std::ptrdiff_t>(count), is_less_deep))
            ->depth_m;
    Patch* patch = place_for(deepest_m, effort);
    if (patch == nullptr) continue;
    static_cast<PatchPair&>(*patch) = pair;
    patch->count = 0;
    patch->sliding = false;
    patch->held_N_s = patch->drag_per_kg = 0.0F;
    patch->impulse_N_s = patch->slip_m = Vec3::Zero();
    patch->deepest_m = deepest_m;
    patch->normal = chosen[0]->normal;
    count = make_room(chosen, count, deepest_m, effort);
    for (std::size_t j = 0; j < count; ++j) {
      const std::uint8_t index = free_[used_++];
      patch->points[patch->count++] = index;
      PatchPoint& point = points_[index];
      point.point_m = chosen[j]->point_m;
      point.depth_m = chosen[j]->depth_m;
      point.impulse_N_s = 0.0F;
      point.target_m_s = 0.0F;
      point.bounces = false;
      point.row.normal = chosen[j]->normal;
    }
  }
}

}  // namespace thimble::control
