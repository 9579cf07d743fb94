#include "host-tools/lab/friction_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace thimble::host {
namespace {

// What the arm's friction in contact differs from that in free motion, where some joints stick: by scan_test, on three simulated arms.
constexpr double kArmMissed_N = 0.015;
// Parts of a fast stroke in which the tip slides steadily, out and back.
constexpr double kWindowFrom = 0.5, kWindowTo = 0.8;
constexpr double kAPeak = 1.0;         // above what the joints make
constexpr std::ptrdiff_t kRise = 3;    // samples before the breakaway that tell how fast the force rises
constexpr double kRoseOn = 0.75;       // samples
constexpr std::ptrdiff_t kStart = 4;   // samples in which the arm sets off: a tip at rest rises on after them
constexpr std::size_t kLeastHalf = 2;  // samples
constexpr double kSteadyPart = 0.3, kSteady_N = 0.03;  // of what the halves of the window may differ by

// The forces of a part of a stroke, in its two halves.
class StrokeWindow {
 public:
  void add(double along, double force_N) {
    const std::size_t half = along < (kWindowFrom + kWindowTo) / 2 ? 0 : 1;
    sum_N_.at(half) += force_N;
    ++count_.at(half);
  }
  [[nodiscard]] double count() const { return static_cast<double>(count_[0] + count_[1]); }
  [[nodiscard]] double mean_N() const { return (sum_N_[0] + sum_N_[1]) / count(); }
  // A tip that still sticks is drawn harder and harder.
  [[nodiscard]] bool steady() const {
    if (std::min(count_[0], count_[1]) < kLeastHalf) return false;
    const double first_N = sum_N_[0] / static_cast<double>(count_[0]);
    const double second_N = sum_N_[1] / static_cast<double>(count_[1]);
    return std::abs(second_N - first_N) < std::max(kSteadyPart * std::abs(mean_N()), kSteady_N);
  }

 private:
  std::array<double, 2> sum_N_{};
  std::array<std::size_t, 2> count_{};
};

}  // namespace

DampingFit fit_damping(std::span<const StiffnessFit> presses) {
  DampingFit fit;
  double n = 0, vv = 0, vh = 0, hh = 0;
  for (const StiffnessFit& press : presses) {
    if (!(press.tip_speed_m_s > 0)) continue;
    const double speed = press.tip_speed_m_s, force_N = press.hysteresis_N - press.free_hysteresis_N;
    n += 1;
    vv += speed * speed;
    vh += speed * force_N;
    hh += force_N * force_N;
  }
  fit.presses = static_cast<std::size_t>(n);
  if (n < 1) return fit;
  fit.damping_N_s_m = vh / vv;
  const double rest = std::max(hh - fit.damping_N_s_m * vh, 0.0);
  fit.residual_N = std::sqrt(rest / n);
  fit.uncertainty_N_s_m = kArmMissed_N / std::sqrt(vv / n);
  return fit;
}

std::optional<CoefficientFit> fit_coefficient(std::span<const StrokeForce> strokes) {
  struct Sums {
    double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  };
  std::map<std::size_t, Sums> sites;
  for (const StrokeForce& stroke : strokes) {
    Sums& s = sites[stroke.site];
    s.n += 1;
    s.x += stroke.normal_N;
    s.y += stroke.along_N;
    s.xx += stroke.normal_N * stroke.normal_N;
    s.xy += stroke.normal_N * stroke.along_N;
    s.yy += stroke.along_N * stroke.along_N;
  }
  CoefficientFit fit;
  double xx = 0, xy = 0, yy = 0;
  std::vector<double> each;
  for (const auto& [site, s] : sites) {
    const double spread = s.xx - s.x * s.x / s.n;
    if (s.n < 2 || !(spread > 1e-6)) continue;
    xx += spread;
    xy += s.xy - s.x * s.y / s.n;
    yy += s.yy - s.y * s.y / s.n;
    each.push_back((s.xy - s.x * s.y / s.n) / spread);
    fit.strokes += static_cast<std::size_t>(s.n);
  }
  if (each.empty()) return std::nullopt;
  fit.coefficient = xy / xx;
  fit.residual_N = std::sqrt(std::max(yy - fit.coefficient * xy, 0.0) / static_cast<double>(fit.strokes));
  double off2 = 0;
  for (const double value : each) off2 += (value - fit.coefficient) * (value - fit.coefficient);
  if (each.size() > 1) fit.spread = std::sqrt(off2 / static_cast<double>(each.size() - 1));
  return fit;
}

namespace {

// What the strokes of a site are measured against.
struct Site {
  std::size_t number;
  const StiffnessFit& fit;
  const ScannedShape& shape;
  double zero_m;  // of the surface felt here, below the shape between the points

  [[nodiscard]] double normal_N(const Eigen::Vector3d& tip_m) const {
    return fit.force_N(shape.depth_m(tip_m) - zero_m);
  }
  // Where the surface slopes, the normal force has a part along the stroke.
  [[nodiscard]] double slope_N(const Eigen::Vector3d& tip_m, const Eigen::Vector3d& direction) const {
    return normal_N(tip_m) * shape.normal(shape.below(tip_m)).dot(direction);
  }
};

// Out and back over the same places, sliding. No value: it did not slide.
std::optional<StrokeForce> sliding_force(const Site& site, const ProbedMove& fast) {
  if (fast.force_limit || fast.samples.empty()) return std::nullopt;
  const Eigen::Vector3d from_m = fast.samples.front().tip_m;
  const Eigen::Vector3d way_m = fast.turn_m - from_m, direction = way_m.normalized();
  std::array<StrokeWindow, 2> window;  // out, back
  double load_N = 0;
  for (const PointSample& sample : fast.samples) {
    const double part = (sample.tip_m - from_m).dot(direction) / way_m.norm();
    const double along = sample.out ? part : 1 - part;
    if (along < kWindowFrom || along > kWindowTo) continue;
    window.at(sample.out ? 0 : 1).add(along, sample.force_N + site.slope_N(sample.tip_m, direction));
    load_N += site.normal_N(sample.tip_m);
  }
  if (!window[0].steady() || !window[1].steady()) return std::nullopt;
  return StrokeForce{site.number, load_N / (window[0].count() + window[1].count()),
                     (window[0].mean_N() - window[1].mean_N()) / 2};
}

// A slow stroke from rest.
struct SlowStroke {
  StrokeForce breakaway;
  double highest_N = 0;  // of its samples
  double sliding_N = 0;  // the mean of its second half
  [[nodiscard]] double peak_N() const { return highest_N - sliding_N; }
};
// The samples are means over some 16 ms: the most of a finer measure would be that of its noise. The force rose on until the tip broke
// away, half a sample to one and a half after the middle of the highest one, or in it.
std::optional<SlowStroke> slow_stroke(const Site& site, const ProbedMove& slow) {
  if (slow.force_limit || slow.samples.empty()) return std::nullopt;
  const Eigen::Vector3d direction = (slow.turn_m - slow.samples.front().tip_m).normalized();
  const auto force_N = [&](const PointSample& sample) {
    return sample.force_N + site.slope_N(sample.tip_m, direction);
  };
  const auto most = std::ranges::max_element(slow.samples, {}, force_N);
  const double rise_N = most - slow.samples.begin() <= kStart
                            ? 0
                            : (force_N(*most) - force_N(*(most - kRise))) / static_cast<double>(kRise);
  SlowStroke stroke{
      {site.number, site.normal_N(most->tip_m), force_N(*most) + kRoseOn * std::max(rise_N, 0.0)},
      force_N(*most)};
  const std::size_t half = slow.samples.size() / 2;
  for (std::size_t k = half; k < slow.samples.size(); ++k)
    stroke.sliding_N += force_N(slow.samples[k]) / static_cast<double>(slow.samples.size() - half);
  return stroke;
}

}  // namespace

SiteForces site_forces(const ProbedStep& step, std::size_t number, const StiffnessFit& fit,
                       const ScannedShape& shape, const Eigen::Vector3d& contact_m) {
  SiteForces forces;
  const Site site{number, fit, shape, shape.depth_m(contact_m)};
  const auto slides = [&](std::size_t move) {
    if (const auto force = sliding_force(site, step.moves[move])) forces.sliding.push_back(*force);
  };
  slides(kFreeFast);
  // Joints that break away make a peak too. A peak that is not above theirs is none: the tip slides at the force that holds it.
  double joints_N = 0;
  if (const auto free = slow_stroke(site, step.moves[kFreeSlow])) {
    forces.breakaway.push_back({site.number, 0, free->sliding_N});
    joints_N = free->peak_N();
  }
  for (std::size_t load = 0; load < kSiteLoads; ++load) {
    for (const Stroke stroke : {Stroke::kSlowOut, Stroke::kSlowBack}) {
      const auto slow = slow_stroke(site, step.moves[site_move(load, stroke)]);
      if (!slow) continue;
      forces.breakaway.push_back(slow->breakaway);
      if (slow->peak_N() < kAPeak * joints_N) forces.breakaway.back().along_N = slow->sliding_N;
    }
    slides(site_move(load, Stroke::kFast));
  }
  return forces;
}

}  // namespace thimble::host
