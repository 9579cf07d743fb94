#include "host-tools/commission/estimate.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace thimble::host {
namespace {

using std::numbers::pi;
using Complex = std::complex<double>;

constexpr std::size_t kParameters =
    5;  // logarithms of inertia, locked, free by locked, damping; and the delay in ticks
using Parameters = std::array<double, kParameters>;

TwoMass mass_of(const Parameters& p, double hold_s) {
  TwoMass mass;
  const double inertia = std::exp(p[0]), ratio = 1 + std::exp(p[2]);  // free by locked, above 1
  mass.locked_Hz = std::exp(p[1]);
  mass.free_Hz = mass.locked_Hz * ratio;
  mass.rotor_kg_m2 = inertia / (ratio * ratio);
  mass.link_kg_m2 = inertia - mass.rotor_kg_m2;
  const double omega = 2 * pi * mass.locked_Hz;
  mass.stiffness_N_m_rad = mass.link_kg_m2 * omega * omega;
  mass.damping_ratio = std::exp(p[3]);
  mass.delay_s = p[4] * hold_s;
  return mass;
}

double mismatch(const Parameters& p, std::span<const Response> responses, const FrictionFit& friction,
                double hold_s) {
  const TwoMass mass = mass_of(p, hold_s);
  double sum = 0;
  for (const Response& seen : responses) {
    const double omega = 2 * pi * seen.Hz;
    const double viscous =
        friction.viscous_N_m_s_rad + 4 * friction.coulomb_N_m / (pi * omega * std::max(seen.amplitude, 1e-9));
    const Complex off = std::log(seen.angle_per_torque / answer(mass, viscous, hold_s, seen.Hz));
    sum += std::norm(off);
  }
  return sum;
}

}  // namespace

double mean(std::span<const double> values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double spread(std::span<const double> values) {
  if (values.size() < 2) return 0;
  const double middle = mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - middle) * (value - middle);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  std::ranges::sort(values);
  const std::size_t n = values.size();
  return n % 2 == 1 ? values[n / 2] : .5 * (values[n / 2 - 1] + values[n / 2]);
}

FrictionFit fit_friction(std::span<const Sweep> sweeps) {
  FrictionFit fit;
  const auto n = static_cast<double>(sweeps.size());
  double s = 0, t = 0, ss = 0, st = 0;
  for (const Sweep& sweep : sweeps) {
    const double friction = .5 * (sweep.up_N_m - sweep.down_N_m);
    s += sweep.speed;
    t += friction;
    ss += sweep.speed * sweep.speed;
    st += sweep.speed * friction;
  }
  const double det = n * ss - s * s;
  if (sweeps.size() < 3 || !(det > 1e-9 * n * ss)) return fit;
  fit.viscous_N_m_s_rad = (n * st - s * t) / det;
  fit.coulomb_N_m = (t - fit.viscous_N_m_s_rad * s) / n;
  double error = 0;
  for (const Sweep& sweep : sweeps)
    error += std::pow(
        .5 * (sweep.up_N_m - sweep.down_N_m) - fit.coulomb_N_m - fit.viscous_N_m_s_rad * sweep.speed, 2);
  fit.accepted = fit.coulomb_N_m > 0 && fit.viscous_N_m_s_rad > -.05 * fit.coulomb_N_m;
  fit.viscous_N_m_s_rad = std::max(0.0, fit.viscous_N_m_s_rad);
  fit.residual = fit.accepted ? std::sqrt(error / n) / fit.coulomb_N_m : 0;
  return fit;
}

ScaleFit fit_scale(std::span<const double> measured, std::span<const double> expected) {
  ScaleFit fit;
  double product = 0, square = 0, largest = 0;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    product += measured[i] * expected[i];
    square += expected[i] * expected[i];
    largest = std::max(largest, std::abs(expected[i]));
  }
  if (measured.empty() || !(square > 0)) return fit;
  fit.scale = product / square;
  double error = 0;
  for (std::size_t i = 0; i < measured.size(); ++i)
    error += std::pow(measured[i] - fit.scale * expected[i], 2);
  fit.residual = std::sqrt(error / static_cast<double>(measured.size())) / largest;
  fit.accepted = fit.scale > 0;
  return fit;
}

Response response_at(double Hz, double tick_s, std::span<const double> torque_N_m,
                     std::span<const double> angle) {
  // Whole periods of the end, without what the beginning excited.
  const double period = 1 / (Hz * tick_s);
  const std::size_t n = angle.size();
  const double periods = std::floor(.7 * static_cast<double>(n) / period);
  Response response;
  response.Hz = Hz;
  if (periods < 1) return response;
  const auto used = static_cast<std::size_t>(std::lround(periods * period));
  const std::size_t from = n - used;
  double t = 0, x = 0, tt = 0, tx = 0;
  for (std::size_t k = from; k < n; ++k) {
    const auto time = static_cast<double>(k);
    t += time;
    x += angle[k];
    tt += time * time;
    tx += time * angle[k];
  }
  const auto count = static_cast<double>(used);
  const double slope = (count * tx - t * x) / (count * tt - t * t), offset = (x - slope * t) / count;
  Complex in = 0, out = 0;
  for (std::size_t k = from; k < n; ++k) {
    const Complex turn = std::polar(1.0, -2 * pi * Hz * tick_s * static_cast<double>(k));
    in += torque_N_m[k] * turn;
    out += (angle[k] - offset - slope * static_cast<double>(k)) * turn;
  }
  response.angle_per_torque = out / in;
  response.amplitude = 2 * std::abs(out) / count;
  return response;
}

std::complex<double> answer(const TwoMass& mass, double viscous_N_m_s_rad, double hold_s, double Hz) {
  const double omega = 2 * pi * Hz;
  const Complex s(0, omega);
  const double link_omega = std::sqrt(mass.stiffness_N_m_rad / mass.link_kg_m2);
  const Complex spring = mass.stiffness_N_m_rad + s * (2 * mass.damping_ratio * mass.link_kg_m2 * link_omega);
  const Complex link = s * s * mass.link_kg_m2 + spring;
  const Complex rotor = s * s * mass.rotor_kg_m2 + s * viscous_N_m_s_rad + spring;
  // The torque of a tick is seen in the counts at the end of it: half a tick is the hold, and it leads by the whole.
  const double half = .5 * omega * hold_s;
  const double hold = std::sin(half) / half;
  return link / (rotor * link - spring * spring) * hold *
         std::polar(1.0, omega * (.5 * hold_s - mass.delay_s));
}

TwoMass fit_two_mass(std::span<const Response> responses, double inertia_kg_m2, const FrictionFit& friction,
                     double hold_s) {
  TwoMass none;
  if (responses.size() < 2 * kParameters || !(inertia_kg_m2 > 0)) return none;
  // Starts over a grid of the two resonances, then a search along each parameter with steps that shrink.
  Parameters best{};
  double least = -1;
  const double low = responses.front().Hz, high = responses.back().Hz;
  for (double locked = 1.3 * low; locked < .9 * high; locked *= 1.12) {
    for (double ratio = 1.1; ratio * locked < 2 * high; ratio *= 1.12) {
      const Parameters p{std::log(inertia_kg_m2), std::log(locked), std::log(ratio - 1), std::log(.05), .5};
      const double off = mismatch(p, responses, friction, hold_s);
      if (least < 0 || off < least) {
        least = off;
        best = p;
      }
    }
  }
  Parameters step{.1, .05, .1, .3, .3};
  for (int round = 0; round < 400; ++round) {
    bool better = false;
    for (std::size_t i = 0; i < kParameters; ++i) {
      for (const double sign : {1.0, -1.0}) {
        Parameters p = best;
        p[i] += sign * step[i];
        const double off = mismatch(p, responses, friction, hold_s);
        if (off >= least) continue;
        least = off;
        best = p;
        better = true;
        break;
      }
    }
    if (better) continue;
    for (double& size : step) size *= .7;
    if (step[1] < 1e-5) break;
  }
  TwoMass mass = mass_of(best, hold_s);
  mass.residual = std::sqrt(least / static_cast<double>(responses.size()));
  const bool inside = mass.locked_Hz > low && mass.locked_Hz < high;
  mass.accepted = inside && mass.rotor_kg_m2 > 0 && mass.link_kg_m2 > 0 && mass.residual < .3;
  return mass;
}

}  // namespace thimble::host
