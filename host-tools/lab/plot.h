// Plots of a force against time and depth, and of its spectrum, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "board/sim/simulation.h"
#include "host-tools/lab/spectrum.h"

namespace thimble::host {

struct PlotChoices {
  bool time = true;
  bool depth = true;
  bool spectrum = true;
  std::string title;
};

struct PlotResult {
  double rate_Hz = 0;
  double seconds = 0;
  double peak_force_N = 0;
  double deepest_m = 0;
  double peak_Hz = 0;  // of the spectrum's greatest amplitude, and that amplitude; 0 without a spectrum
  double peak_amplitude_N = 0;
};

// rows: of one arm, evenly spaced. output: *.svg or *.png. Depth is the distance from tip to god object. The spectrum is that of the force:
// the root of the squares of its three components' amplitudes.
// Errors: kUsage `bad-output` (another extension), kNotFound `no-gnuplot`, kRefused `plot-failed` (with gnuplot's message), kBadInput
// `too-short`; those of OutputFile.
PlotResult plot(std::span<const board::LogRow> rows, const PlotChoices& choices,
                const std::filesystem::path& output);

}  // namespace thimble::host
