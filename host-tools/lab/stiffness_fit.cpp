#include "host-tools/lab/stiffness_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "firmware/link/services.h"

namespace thimble::host {
namespace {

constexpr double kBegin = 0.1;                        // part of the way, in free motion
constexpr double kFirstLow = 0.4, kFirstHigh = 0.95;  // parts of the peak force, for the first line
constexpr double kLow = 0.15, kHigh = 0.95;           // parts of the depth, for the lines
constexpr double kFreeBefore = 0.1, kLeastFree_m = 2e-4;
constexpr double kSpeedingUp = 0.2;  // part of the free way in which the arm speeds up or brakes
constexpr double kSteady = 0.4;      // the same, for its speed
constexpr double kMiddleFrom = 0.2,
                 kMiddleTo =
                     0.6;  // parts of the depth, away from touch and turn, for what the ways differ by
// The search for the boundary of two layers.
constexpr double kLayerLow = 0.08, kFirstBoundary = 0.2, kLastBoundary = 0.8;  // parts of the depth
constexpr double kUnlike = 0.15;  // least difference of the slopes
constexpr int kBoundaries = 25, kLayerRounds = 6;
constexpr double kFinest_m = 2e-6;  // of the boundary
constexpr std::size_t kLeastLayerSamples = 16;
constexpr int kDepths = 64;
constexpr int kContactRounds = 30;

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

// Time of a move from its start to s_m further on, with the acceleration of guarded moves.
double time_to(double s_m, double speed_m_s) {
  constexpr auto kAcceleration = static_cast<double>(firmware::link::kMoveAcceleration_m_s2);
  const double reached_m = speed_m_s * speed_m_s / (2 * kAcceleration);
  if (s_m < reached_m) return std::sqrt(2 * std::max(s_m, 0.0) / kAcceleration);
  return speed_m_s / kAcceleration + (s_m - reached_m) / speed_m_s;
}

// The mean speed of the tip between two places in contact. Samples are taken at equal times, and the speed in free motion is known. 0: too
// few samples.
double speed_within(std::span<const ProbeSample> samples, bool pressing, double start_m, double free_m,
                    double from_m, double to_m, double speed_m_s) {
  struct Span {
    double first = 0, last = 0;
    int count = 0;
    void add(double along_m) {
      if (count++ == 0) first = along_m;
      last = along_m;
    }
  };
  Span steady, contact;
  for (const ProbeSample& sample : samples) {
    if (sample.pressing != pressing) continue;
    if (sample.along_m < free_m && sample.along_m > start_m + kSteady * (free_m - start_m))
      steady.add(sample.along_m);
    if (sample.along_m >= from_m && sample.along_m <= to_m) contact.add(sample.along_m);
  }
  if (steady.count < 2 || contact.count < 2) return 0;
  const double time_s =
      std::abs(time_to(steady.last - start_m, speed_m_s) - time_to(steady.first - start_m, speed_m_s));
  const double each_s = time_s / (steady.count - 1);
  return each_s > 0 ? std::abs(contact.last - contact.first) / (contact.count - 1) / each_s : 0;
}

// Least squares of F = c(way) + K s + dK max(0, s - boundary).
struct TwoSlopes {
  double boundary_m = 0, residual2 = std::numeric_limits<double>::infinity();
  std::array<double, 2> at_zero_N{};
  double upper_N_m = 0, more_N_m = 0;
  std::size_t samples = 0;
};
TwoSlopes two_slopes(std::span<const ProbeSample> samples, double from_m, double to_m, double boundary_m) {
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d b = Eigen::Vector4d::Zero();
  double ff = 0;
  TwoSlopes fit;
  for (const ProbeSample& sample : samples) {
    if (sample.along_m < from_m || sample.along_m > to_m) continue;
    const double s = sample.along_m - boundary_m;
    const Eigen::Vector4d row(sample.pressing ? 1 : 0, sample.pressing ? 0 : 1, s, std::max(s, 0.0));
    A += row * row.transpose();
    b += row * sample.force_N;
    ff += sample.force_N * sample.force_N;
    ++fit.samples;
  }
  if (fit.samples < kLeastLayerSamples) return fit;
  const Eigen::Vector4d x = A.ldlt().solve(b);
  if (!x.allFinite()) return fit;
  fit.boundary_m = boundary_m;
  fit.residual2 = std::max(ff - x.dot(b), 0.0) / static_cast<double>(fit.samples);
  fit.upper_N_m = x[2];
  fit.more_N_m = x[3];
  fit.at_zero_N = {x[0] - x[2] * boundary_m, x[1] - x[2] * boundary_m};
  return fit;
}

// Free motion ends before this contact; the forces there.
std::array<double, 2> free_forces_N(std::span<const ProbeSample> samples, double contact_m, double deepest_m,
                                    StiffnessFit& fit) {
  fit.free_to_m = contact_m - std::max(kFreeBefore * (deepest_m - contact_m), kLeastFree_m);
  fit.free_from_m = fit.start_m + kSpeedingUp * (fit.free_to_m - fit.start_m);
  std::array<Line, 2> free;
  for (const ProbeSample& sample : samples) {
    if (sample.along_m < fit.free_to_m && sample.along_m > fit.free_from_m)
      free.at(sample.pressing ? 0 : 1).add(sample);
  }
  return {free[0].f, free[1].f};
}

// Replaces one slope by two where these describe the forces much better.
void try_layers(std::span<const ProbeSample> samples, double deepest_m, StiffnessFit& fit) {
  // The lower layer bends the line: its contact is too deep. Start from the first force.
  StiffnessFit tried_fit = fit;
  std::array<double, 2> free_N = free_forces_N(samples, fit.contact_m, deepest_m, tried_fit);
  double surface_m = fit.contact_m;
  double peak_N = 0;
  for (const ProbeSample& sample : samples) peak_N = std::max(peak_N, sample.force_N);
  for (const ProbeSample& sample : samples) {
    if (!sample.pressing || sample.force_N < free_N[0] + kLayerLow * (peak_N - free_N[0])) continue;
    surface_m = std::min(surface_m, sample.along_m);
    break;
  }
  TwoSlopes best;
  double one2 = 0;  // residual of one slope over the same samples
  double contact_m = surface_m;
  for (int round = 0; round < kLayerRounds; ++round) {
    const double depth_m = deepest_m - contact_m;
    const double from_m = contact_m + kLayerLow * depth_m, to_m = contact_m + kHigh * depth_m;
    best = {};
    for (int i = 0; i <= kBoundaries; ++i) {
      const double part = kFirstBoundary + (kLastBoundary - kFirstBoundary) * i / kBoundaries;
      const TwoSlopes tried = two_slopes(samples, from_m, to_m, contact_m + part * depth_m);
      if (tried.residual2 < best.residual2) best = tried;
    }
    for (double step_m = (kLastBoundary - kFirstBoundary) / kBoundaries * depth_m / 2; step_m > kFinest_m;
         step_m /= 2) {
      const double middle_m = best.boundary_m;
      for (const double boundary_m : {middle_m - step_m, middle_m + step_m}) {
        const TwoSlopes tried = two_slopes(samples, from_m, to_m, boundary_m);
        if (tried.residual2 < best.residual2) best = tried;
      }
    }
    one2 = two_slopes(samples, from_m, to_m, to_m).residual2;  // no sample is beyond the boundary
    if (!(best.upper_N_m > 0)) return;
    free_N = free_forces_N(samples, contact_m, deepest_m, tried_fit);
    contact_m = 0;
    for (std::size_t way = 0; way < 2; ++way)
      contact_m += (free_N.at(way) - best.at_zero_N.at(way)) / best.upper_N_m / 2;
    if (!(contact_m < best.boundary_m)) return;
  }
  const double residual_N = std::sqrt(best.residual2);
  const double part = residual_N / std::max(std::sqrt(one2), 1e-12);
  if (!(part < kLayered) || !(std::abs(best.more_N_m) > kUnlike * best.upper_N_m)) return;
  fit.free_from_m = tried_fit.free_from_m;
  fit.free_to_m = tried_fit.free_to_m;
  fit.free_hysteresis_N = (free_N[0] - free_N[1]) / 2;
  fit.layer = LayerFit{best.upper_N_m + best.more_N_m, best.boundary_m - contact_m, part};
  fit.stiffness_N_m = best.upper_N_m;
  fit.contact_m = contact_m;
  fit.residual_N = residual_N;
  fit.samples = best.samples;
}

// Depth, speed, and the force between the ways, of a fit whose lines are found.
void finish(std::span<const ProbeSample> samples, double speed_m_s, double deepest_m, StiffnessFit& fit) {
  fit.depth_m = deepest_m - fit.contact_m;
  const double from_m = fit.contact_m + kMiddleFrom * fit.depth_m,
               to_m = fit.contact_m + kMiddleTo * fit.depth_m;
  std::array<double, 2> off_N{}, count{};
  for (const ProbeSample& sample : samples) {
    if (sample.along_m < from_m || sample.along_m > to_m) continue;
    const std::size_t way = sample.pressing ? 0 : 1;
    off_N.at(way) += sample.force_N - fit.force_N(sample.along_m - fit.contact_m);
    count.at(way) += 1;
  }
  if (count[0] > 0 && count[1] > 0) fit.hysteresis_N = (off_N[0] / count[0] - off_N[1] / count[1]) / 2;
  fit.tip_speed_m_s = 0;
  if (!(speed_m_s > 0)) return;
  for (const bool pressing : {true, false})
    fit.tip_speed_m_s +=
        speed_within(samples, pressing, fit.start_m, fit.free_to_m, from_m, to_m, speed_m_s) / 2;
}

double deepest_of(std::span<const ProbeSample> samples) {
  double peak_N = 0, deepest_m = 0;
  for (const ProbeSample& sample : samples) {
    if (!sample.pressing || sample.force_N <= peak_N) continue;
    peak_N = sample.force_N;
    deepest_m = sample.along_m;
  }
  return deepest_m;
}

}  // namespace

double StiffnessFit::force_N(double at_m) const {
  if (at_m <= 0) return 0;
  double force_N = stiffness_N_m * at_m;
  if (layer) force_N += (layer->below_N_m - stiffness_N_m) * std::max(at_m - layer->boundary_m, 0.0);
  return force_N;
}

StiffnessFit::Single StiffnessFit::single(double down_to_m) const {
  if (!layer) return {stiffness_N_m, 0};
  double fd = 0, dd = 0;
  for (int i = 1; i <= kDepths; ++i) {
    const double d = down_to_m * i / kDepths;
    fd += force_N(d) * d;
    dd += d * d;
  }
  Single single{fd / dd, 0};
  for (int i = 1; i <= kDepths; ++i) {
    const double d = down_to_m * i / kDepths;
    single.off_N = std::max(single.off_N, std::abs(single.stiffness_N_m * d - force_N(d)));
  }
  return single;
}

std::optional<StiffnessFit> fit_one_slope(std::span<const ProbeSample> samples, double speed_m_s) {
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
  fit.start_m = start_m;
  fit.free_from_m = steady_m;
  fit.free_to_m = free_m;
  std::array<double, 2> at_zero_N{};
  for (std::size_t way = 0; way < 2; ++way) {
    at_zero_N.at(way) = line.at(way).f - fit.stiffness_N_m * line.at(way).s;
    fit.contact_m += (free.at(way).f - at_zero_N.at(way)) / fit.stiffness_N_m / 2;
  }
  fit.free_hysteresis_N = (free[0].f - free[1].f) / 2;
  finish(samples, speed_m_s, deepest_m, fit);
  return fit;
}

std::optional<StiffnessFit> fit_stiffness(std::span<const ProbeSample> samples, double speed_m_s) {
  std::optional<StiffnessFit> fit = fit_one_slope(samples, speed_m_s);
  if (!fit) return fit;
  const double deepest_m = deepest_of(samples);
  try_layers(samples, deepest_m, *fit);
  if (fit->layer) finish(samples, speed_m_s, deepest_m, *fit);
  return fit;
}

// Least squares of F = c(way) + K g(s - contact), g the layered depth; the contact is where the springs' force begins.
void refit_layers(std::span<const ProbeSample> samples, const Layers& layers, double speed_m_s,
                  StiffnessFit& fit) {
  const double deepest_m = deepest_of(samples);
  StiffnessFit tried = fit;
  std::array<double, 2> free_N{};
  double contact_m = fit.contact_m, stiffness = 0, residual2 = 0, used = 0;
  for (int round = 0; round < kContactRounds; ++round) {
    const double depth_m = deepest_m - contact_m;
    std::array<Line, 2> line;  // over the layered depth
    for (const ProbeSample& sample : samples) {
      const double s = sample.along_m - contact_m;
      if (s < kLayerLow * depth_m || s > kHigh * depth_m) continue;
      const double g = s + (layers.ratio - 1) * std::max(s - layers.boundary_m, 0.0);
      line.at(sample.pressing ? 0 : 1).add({sample.pressing, g, sample.force_N});
    }
    const double ss = line[0].ss + line[1].ss, sf = line[0].sf + line[1].sf, ff = line[0].ff + line[1].ff;
    if (std::min(line[0].count, line[1].count) < static_cast<double>(kLeastSamples) || !(sf > 0)) return;
    stiffness = sf / ss;
    used = line[0].count + line[1].count;
    residual2 = std::max(ff - stiffness * sf, 0.0) / used;
    free_N = free_forces_N(samples, contact_m, deepest_m, tried);
    for (std::size_t way = 0; way < 2; ++way)
      contact_m += (free_N.at(way) - (line.at(way).f - stiffness * line.at(way).s)) / stiffness / 2;
  }
  fit = tried;
  fit.free_hysteresis_N = (free_N[0] - free_N[1]) / 2;
  fit.contact_m = contact_m;
  fit.stiffness_N_m = stiffness;
  fit.residual_N = std::sqrt(residual2);
  fit.samples = static_cast<std::size_t>(used);
  fit.layer = LayerFit{layers.ratio * stiffness, layers.boundary_m, 1};
  finish(samples, speed_m_s, deepest_m, fit);
}

}  // namespace thimble::host
