// The amplitude spectrum of a signal with evenly spaced samples: a sine of amplitude A in the middle of a bin is A there.
//
// Hann window over segments of at most kSegment samples that overlap by half, the mean taken off each, powers averaged (Welch 1967).
// Divided by the window's coherent gain, the amplitudes are in the signal's own unit. One-sided.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace thimble::host {

struct Spectrum {
  static constexpr std::size_t kSegment = 8192;

  double bin_Hz = 0;
  std::size_t segments = 0;
  std::vector<double> amplitude;  // [i] at i * bin_Hz, up to half the rate
};

// Fewer than 4 samples: empty.
[[nodiscard]] Spectrum amplitude_spectrum(std::span<const double> samples, double rate_Hz);

}  // namespace thimble::host
