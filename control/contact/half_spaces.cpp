#include "control/contact/half_spaces.h"

#include <cmath>

namespace thimble::control {
namespace {

constexpr int kMaxRounds = 32;
// Planes that are parallel but for a thousandth of a radian hold a point one at a time: behind the other one by this, a
// millimetre from where they cross.
constexpr float kParallel_m = 1.0e-6F;

using Set = std::array<std::size_t, kMaxHolding>;

// The point that all planes of the set hold: on the first plane, then along it to the second, then along both to the third.
// The Gram matrix of nearly parallel planes would lose what tells them apart. False when one would have to pull, or when
// they are too nearly parallel.
bool solve(std::span<const HalfSpace> planes, const Vec3& target, NearestInside& out) {
  constexpr float kLeastSine = 1.0e-4F;
  const HalfSpace& first = planes[out.holding[0]];
  out.lambda_m = Vec3(-first.height_m(target), 0.0F, 0.0F);
  out.point_m = target + out.lambda_m[0] * first.normal;
  if (out.count == 1) return out.lambda_m[0] >= 0.0F;

  const HalfSpace& second = planes[out.holding[1]];
  const float cosine = first.normal.dot(second.normal);
  const Vec3 along = second.normal - cosine * first.normal;
  const float sine2 = along.squaredNorm();
  if (sine2 < kLeastSine * kLeastSine) return false;
  const float to_second = -second.height_m(out.point_m) / sine2;
  out.point_m += to_second * along;
  if (out.count == 2) {
    out.lambda_m = Vec3(out.lambda_m[0] - to_second * cosine, to_second, 0.0F);
    return out.lambda_m[0] >= 0.0F && to_second >= 0.0F;
  }

  const HalfSpace& third = planes[out.holding[2]];
  const Vec3 edge = first.normal.cross(second.normal);
  const float determinant = third.normal.dot(edge);
  if (std::abs(determinant) < kLeastSine) return false;
  out.point_m += (-third.height_m(out.point_m) / determinant) * edge;
  const Vec3 pull = out.point_m - target;
  out.lambda_m = Vec3(pull.dot(second.normal.cross(third.normal)), pull.dot(third.normal.cross(first.normal)),
                      pull.dot(edge)) /
                 determinant;
  return out.lambda_m.minCoeff() >= 0.0F;
}

// The nearest point for the plane `added` and those that held the point before. `added` is among those that hold it now.
NearestInside take_in(std::span<const HalfSpace> planes, const Vec3& target, float slack_m,
                      const NearestInside& before, std::size_t added) {
  const auto try_set = [&](std::size_t count, const Set& set, float behind_m, NearestInside& out) {
    out.count = count;
    out.holding = set;
    if (!solve(planes, target, out)) return false;
    for (std::size_t i = 0; i < before.count; ++i)
      if (planes[before.holding[i]].height_m(out.point_m) < -behind_m) return false;
    return true;
  };
  NearestInside out;
  if (try_set(1, {added}, slack_m, out)) return out;
  for (std::size_t i = 0; i < before.count; ++i)
    if (try_set(2, {added, before.holding[i]}, slack_m, out)) return out;
  for (std::size_t i = 0; i < before.count; ++i)
    for (std::size_t j = i + 1; j < before.count; ++j)
      if (try_set(3, {added, before.holding[i], before.holding[j]}, slack_m, out)) return out;
  out.found = try_set(1, {added}, kParallel_m, out);
  return out;
}

}  // namespace

NearestInside nearest_inside(std::span<const HalfSpace> planes, const Vec3& target, Work& work) noexcept {
  constexpr float kSlack = 2.0e-6F;
  const float slack_m = kSlack * target.norm() + kSettled_m;
  NearestInside out;
  out.point_m = target;
  float worst_m = 0.0F;
  for (int round = 0; round < kMaxRounds; ++round) {
    worst_m = -slack_m;
    std::size_t added = planes.size();
    for (std::size_t i = 0; i < planes.size(); ++i) {
      const float height_m = planes[i].height_m(out.point_m);
      if (height_m < worst_m) {
        worst_m = height_m;
        added = i;
      }
    }
    if (added == planes.size()) return out;
    if (!work.spend(kRoundWork + static_cast<std::uint32_t>(planes.size()) / kPlanesAUnit)) break;
    out = take_in(planes, target, slack_m, out, added);
    if (!out.found) return out;
  }
  out.found = worst_m >= -kParallel_m;
  return out;
}

}  // namespace thimble::control
