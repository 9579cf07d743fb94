#include "tests/support/adversary.h"

#include <cmath>

#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kTick_s = 1.0 / 4000.0;
constexpr double kSwing_m = 0.94 * kTick_s, kPress_m = 0.15 * kTick_s, kFast_m = 5.0e-4, kSlow_m = 2.0e-5;
constexpr std::size_t kStay = 20, kPressed = 2000;

}  // namespace

std::vector<Vector3d> attack_path(Attack attack, double radius_m, std::size_t ticks, std::uint64_t seed) {
  Random random(seed);
  const double outside_m = 1.2 * radius_m;
  std::vector<Vector3d> path;
  path.reserve(ticks);
  Vector3d tip = outside_m * random.direction(), goal = -tip;
  Vector3d out = tip.normalized(), along = out.unitOrthogonal();
  for (std::size_t i = 0; i < ticks; ++i) {
    const double left_m = (goal - tip).norm();
    switch (attack) {
      case Attack::kSwing:
        if (left_m < kSwing_m) {
          tip = outside_m * random.direction();  // on the way back through the middle from another side
          goal = -tip;
        } else {
          tip += kSwing_m / left_m * (goal - tip);
        }
        break;
      case Attack::kTeleport:
        if (i % kStay == 0) tip = outside_m * std::cbrt(random.uniform(0.0, 1.0)) * random.direction();
        break;
      case Attack::kPress: {
        if (i % kPressed == 0) {
          out = random.direction();
          along = out.unitOrthogonal();
        }
        const double deep_m =
            std::max(0.5 * radius_m, outside_m - kSwing_m * static_cast<double>(i % kPressed));
        const double turn = kPress_m / deep_m * static_cast<double>(i % kPressed);
        tip = deep_m * (std::cos(turn) * out + std::sin(turn) * along);
        break;
      }
      case Attack::kDart:
        if (left_m < kFast_m || random.below(200) == 0) goal = outside_m * random.direction();
        tip += (random.below(3) == 0 ? kSlow_m : kFast_m) * (goal - tip).normalized();
        break;
    }
    path.push_back(tip);
  }
  return path;
}

}  // namespace thimble::test
