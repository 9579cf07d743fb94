#include "host-tools/lab/spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <unsupported/Eigen/FFT>

namespace thimble::host {

Spectrum amplitude_spectrum(std::span<const double> samples, double rate_Hz) {
  Spectrum spectrum;
  constexpr std::size_t kFewest = 4;
  if (samples.size() < kFewest) return spectrum;
  const std::size_t size = std::min(samples.size() / 2 * 2, Spectrum::kSegment);
  std::vector<double> window(size);
  double gain = 0;
  for (std::size_t i = 0; i < size; ++i) {
    window[i] =
        0.5 - 0.5 * std::cos(2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(size));
    gain += window[i];
  }
  const std::size_t bins = size / 2 + 1;
  std::vector<double> power(bins, 0.0);
  Eigen::FFT<double> fft;
  std::vector<double> segment(size);
  std::vector<std::complex<double>> transformed;
  for (std::size_t from = 0; from + size <= samples.size(); from += size / 2) {
    const std::span<const double> part = samples.subspan(from, size);
    const double mean = std::accumulate(part.begin(), part.end(), 0.0) / static_cast<double>(size);
    for (std::size_t i = 0; i < size; ++i) segment[i] = (part[i] - mean) * window[i];
    fft.fwd(transformed, segment);
    for (std::size_t i = 0; i < bins; ++i) power[i] += std::norm(transformed[i]);
    ++spectrum.segments;
  }
  spectrum.bin_Hz = rate_Hz / static_cast<double>(size);
  spectrum.amplitude.resize(bins);
  for (std::size_t i = 0; i < bins; ++i) {
    const double sides = i == 0 || i + 1 == bins ? 1.0 : 2.0;
    spectrum.amplitude[i] = sides * std::sqrt(power[i] / static_cast<double>(spectrum.segments)) / gain;
  }
  return spectrum;
}

}  // namespace thimble::host
