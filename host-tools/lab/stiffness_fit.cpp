#include "host-tools/lab/stiffness_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace thimble::host {
namespace {

constexpr double kBegin = 0.1;                        // part of the way, in free motion
constexpr double kFirstLow = 0.4, kFirstHigh = 0.95;  // parts of the peak force, for the first line
constexpr double kLow = 0.15, kHigh = 0.95;           // parts of the depth, for the lines
constexpr double kFreeBefore = 0.1, kLeastFree_m = 2e-4;
constexpr double kSpeedingUp = 0.2;  // part of the free way in which the arm speeds up or brakes

// Sums of a line through points, about their mean.
struct Line {
  double count = 0, s = 0, f = 0, ss = 0, sf = 0, ff = 0;
  void add(const ProbeSample& sample) {
    // Running means: Welford's, so that millimetres a decimetre away lose nothing.
    ++count;
    const double ds = sample.along_m - s, df = sample.force_N - f;
    s += ds / count;
    f += df / count;
    ss += ds * (sample.along_m - s);
    sf += ds * (sample.force_N - f);
    ff += df * (sample.force_N - f);
  }
};

}  // namespace

std::optional<StiffnessFit> fit_stiffness(std::span<const ProbeSample> samples) {
  double peak_N = 0, deepest_m = 0;
  for (const ProbeSample& sample : samples) {
    if (sample.pressing && sample.force_N > peak_N) {
      peak_N = sample.force_N;
      deepest_m = sample.along_m;
    }
  }
  if (peak_N < kLeastPeak_N) return std::nullopt;
  const double start_m = std::ranges::min_element(samples, {}, &ProbeSample::along_m)->along_m;
  // A first idea of the force of free motion and of the surface; the lines below need it for their ranges only.
  Line begin, first;
  for (const ProbeSample& sample : samples) {
    if (sample.pressing && sample.along_m <= start_m + kBegin * (deepest_m - start_m)) begin.add(sample);
  }
  for (const ProbeSample& sample : samples) {
    if (sample.pressing && sample.force_N >= kFirstLow * peak_N && sample.force_N <= kFirstHigh * peak_N)
      first.add(sample);
  }
  if (first.count < 2 || !(first.sf > 0)) return std::nullopt;
  const double surface_m = first.s - (first.f - begin.f) * first.ss / first.sf;
  const double depth_m = deepest_m - surface_m;
  const double free_m = surface_m - std::max(kFreeBefore * depth_m, kLeastFree_m);
  const double steady_m = start_m + kSpeedingUp * (free_m - start_m);

  std::array<Line, 2> line, free;
  for (const ProbeSample& sample : samples) {
    const std::size_t way = sample.pressing ? 0 : 1;
    const double part = (sample.along_m - surface_m) / depth_m;
    if (part >= kLow && part <= kHigh) line.at(way).add(sample);
    if (sample.along_m < free_m && sample.along_m > steady_m) free.at(way).add(sample);
  }
  if (std::min(line[0].count, line[1].count) < static_cast<double>(kLeastSamples)) return std::nullopt;
  const double ss = line[0].ss + line[1].ss, sf = line[0].sf + line[1].sf, ff = line[0].ff + line[1].ff;
  if (!(sf > 0)) return std::nullopt;

  StiffnessFit fit;
  fit.stiffness_N_m = sf / ss;
  fit.samples = static_cast<std::size_t>(line[0].count + line[1].count);
  fit.residual_N = std::sqrt(std::max(ff - fit.stiffness_N_m * sf, 0.0) / (line[0].count + line[1].count));
  std::array<double, 2> at_zero_N{};
  for (std::size_t way = 0; way < 2; ++way) {
    at_zero_N.at(way) = line.at(way).f - fit.stiffness_N_m * line.at(way).s;
    fit.contact_m += (free.at(way).f - at_zero_N.at(way)) / fit.stiffness_N_m / 2;
  }
  fit.hysteresis_N = (at_zero_N[0] - at_zero_N[1]) / 2;
  return fit;
}

}  // namespace thimble::host
