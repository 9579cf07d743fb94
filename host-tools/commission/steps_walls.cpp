// Step 10: the stiffest wall that the arm holds.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host-tools/commission/estimate.h"
#include "host-tools/commission/steps.h"
#include "host-tools/commission/wall_loop.h"

namespace thimble::host {
namespace {

constexpr std::array kDampings_N_s_m{0.0, 1.0, 2.0};
constexpr double kFirstWall_N_m = 100, kLastWall_N_m = 1e5;
constexpr int kWallParts = 5;         // of a rise
constexpr double kWallPart = 1.0845;  // near the limit
constexpr double kWallRise = 1.5;     // from wall to wall, until the first swings: as kWallParts of these
constexpr int kStillBelow = 2;        // walls in a row below the limit
constexpr double kNextDamping = .5;   // of the limit before, where the next damping begins
constexpr double kPressWall_m = .01;
constexpr double kPressMost_N = 4, kMostSpeed_m_s = .5;
constexpr double kWindow_s = .1;  // in which a swing is seen: it is faster, a hand that wanders is slower
constexpr double kHeld_s = 1;     // of the end of the recording

// Peak to peak about a straight line.
double swing_about_line(const std::vector<double>& heights) {
  const auto n = static_cast<double>(heights.size());
  double slope = 0, square = 0;
  const double middle = .5 * (n - 1), height = mean(heights);
  for (std::size_t k = 0; k < heights.size(); ++k) {
    slope += (static_cast<double>(k) - middle) * (heights[k] - height);
    square += (static_cast<double>(k) - middle) * (static_cast<double>(k) - middle);
  }
  slope /= square;
  double low = 0, high = 0;
  for (std::size_t k = 0; k < heights.size(); ++k) {
    const double off = heights[k] - height - slope * (static_cast<double>(k) - middle);
    low = std::min(low, off);
    high = std::max(high, off);
  }
  return high - low;
}

// Of the tip across the wall by the counts: what a quarter of the windows stay below. Where no line tells of a cut cable, the device probes its encoders at
// rest (encoder_probe.h), about three times a second, by two counts each: the median of the windows took that for a swing, and a five-bar that holds
// 100 kN/m had a limit of 5 (commission_link.whole_arms).
double swing_m(const StepContext& context, const BenchRecording& seen, const Eigen::Vector3d& normal) {
  const double tick_s = context.bench.facts().tick_s;
  const auto window = static_cast<std::size_t>(std::lround(kWindow_s / tick_s));
  const auto held = static_cast<std::size_t>(std::lround(kHeld_s / tick_s));
  std::vector<double> swings, heights;
  heights.reserve(window);
  const std::size_t all = seen.ticks.size();
  for (std::size_t k = all > held ? all - held : 0; k < all; ++k) {
    heights.push_back(context.arm.tip_m(angles(context, seen.ticks[k].counts)).dot(normal));
    if (heights.size() < window) continue;
    swings.push_back(swing_about_line(heights));
    heights.clear();
  }
  if (swings.empty()) return 0;
  const auto quarter = swings.begin() + static_cast<std::ptrdiff_t>(swings.size() / 4);
  std::nth_element(swings.begin(), quarter, swings.end());
  return *quarter;
}

// The builder presses one wall.
bool is_still(StepContext& context, double stiffness_N_m, double damping_N_s_m, StepResult& result) {
  const Expectation& arm = context.arm;
  TipProgram wall;
  wall.kind = TipProgram::Kind::kWall;
  wall.stiffness_N_m = stiffness_N_m;
  wall.damping_N_s_m = damping_N_s_m;
  wall.most_force_N = std::min(kPressMost_N, arm.arm().max_force_N);
  wall.most_speed_m_s = kMostSpeed_m_s;
  wall.wall_normal = wall_normal(arm);
  wall.wall_depth_m = kPressWall_m;
  if (hold(context, arm.home()) == Answer::kStop) {
    result.stopped = true;
    return false;
  }
  Prompt asked = prompt(
      Prompt::Kind::kPressWall, 0,
      fmt::format(
          "Push the tip {} until you feel a wall, press it with {:.2g} N (a hand presses a doorbell with 2), "
          "and hold for 2 seconds. The walls become harder; let go when one trembles.",
          towards(-wall.wall_normal), press_N(wall)));
  asked.direction = -wall.wall_normal;
  asked.wall_N_m = stiffness_N_m;
  asked.wall_m = wall.wall_depth_m;
  asked.press_N = press_N(wall);
  const BenchRecording seen = context.bench.feel(wall, asked);
  if (seen.ending == Ending::kSpeed) return false;
  return swing_m(context, seen, wall.wall_normal) <= counted_tolerance_m(arm);
}

// A wall that is too stiff may be still by chance. So the walls below `last`, which was still, are pressed until kStillBelow in a row are still; then
// those above it up to `high`, which swings. No more than `last` if none below swings.
double find_first_swing(StepContext& context, double last, double high, double damping_N_s_m,
                        StepResult& result) {
  double swings = high;
  int still = 0;
  for (double k = last / kWallPart; k >= kFirstWall_N_m && still < kStillBelow && !result.stopped;
       k /= kWallPart) {
    if (is_still(context, k, damping_N_s_m, result)) {
      ++still;
    } else {
      still = 0;
      swings = k;
    }
  }
  if (swings < last) return swings / kWallPart >= kFirstWall_N_m ? swings / kWallPart : 0;
  for (int part = 1; part < kWallParts && is_still(context, kWallPart * last, damping_N_s_m, result); ++part)
    last *= kWallPart;
  return last;
}

// The largest stiffness up to which every wall that was pressed is still; 0: even the softest swings.
double find_limit(StepContext& context, double begin_N_m, double damping_N_s_m, StepResult& result) {
  double last = 0, k = begin_N_m;
  while (k < kLastWall_N_m && is_still(context, k, damping_N_s_m, result)) {
    last = k;
    k *= kWallRise;
  }
  if (result.stopped) return 0;
  if (last == 0)
    return begin_N_m > kFirstWall_N_m ? find_limit(context, kFirstWall_N_m, damping_N_s_m, result) : 0;
  return k >= kLastWall_N_m ? kLastWall_N_m : find_first_swing(context, last, k, damping_N_s_m, result);
}

double given_wall(const ArmFile& file, double rate_Hz, double damping_N_s_m) {
  for (const ArmWall& wall : file.largest_walls)
    if (std::abs(wall.rate_Hz - rate_Hz) < .5 && std::abs(wall.damping_N_s_m - damping_N_s_m) < 1e-6)
      return wall.stiffness_N_m.value / kWallMargin;
  return std::nan("");
}

}  // namespace

StepResult find_walls(StepContext& context) {
  StepResult result;
  const double rate_Hz = 1 / context.bench.facts().tick_s;
  double begin_N_m = kFirstWall_N_m, best_N_m = 0;
  for (const double damping_N_s_m : kDampings_N_s_m) {
    const double limit_N_m = find_limit(context, begin_N_m, damping_N_s_m, result);
    if (result.stopped) return result;
    Measure measure;
    measure.name = "largest_wall_N_m";
    measure.given = given_wall(context.arm.arm(), rate_Hz, damping_N_s_m);
    measure.value = limit_N_m;
    measure.spread = (kWallPart - 1) * limit_N_m;
    measure.promise = .15;
    measure.rate_Hz = rate_Hz;
    measure.damping_N_s_m = damping_N_s_m;
    result.measures.push_back(measure);
    if (limit_N_m == 0)
      result.notes.push_back(
          fmt::format("With B = {:.2g} N s/m even a wall of {:.0f} N/m swings: this arm does not hold "
                      "such a damping at {:.0f} Hz.",
                      damping_N_s_m, kFirstWall_N_m, rate_Hz));
    if (limit_N_m == kLastWall_N_m)
      result.notes.push_back(
          fmt::format("With B = {:.2g} N s/m no wall swings up to {:.0f} N/m, the stiffest "
                      "that is tried.",
                      damping_N_s_m, kLastWall_N_m));
    best_N_m = std::max(best_N_m, limit_N_m);
    begin_N_m = std::max(kFirstWall_N_m, kNextDamping * limit_N_m);
  }
  result.passed = best_N_m > 0;
  return result;
}

}  // namespace thimble::host
