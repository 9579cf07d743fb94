// Pictures of a force: against time, against depth, its spectrum. Drawn by gnuplot, which is found when it is needed.
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

// rows: of one arm, evenly spaced. output: *.svg or *.png. Depth is the way from tip to god object. The spectrum is that of the force:
// the root of the squares of its three components' amplitudes.
// Errors: kUsage `bad-output` (neither of both), kNotFound `no-gnuplot`, kRefused `plot-failed` (with gnuplot's words), kBadInput
// `too-short`; those of OutputFile.
PlotResult plot(std::span<const board::LogRow> rows, const PlotChoices& choices,
                const std::filesystem::path& output);

}  // namespace thimble::host
