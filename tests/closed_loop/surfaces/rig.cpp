#include "tests/closed_loop/surfaces/rig.h"

#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>

#include "host-tools/compiler/compile.h"

namespace thimble::test {

SceneImage surface_scene(const std::string& material, const std::string& shape,
                         const std::filesystem::path& folder) {
  const std::string text = R"({"thimble_scene": 1, "name": "test", "objects": [{"name": "it", "shape": {)" +
                           shape + R"(}, "material": {)" + material + "}}]}";
  return SceneImage(host::compile_scene_text(text, "test.scene.json", folder).image);
}

const Felt& Mass::step(IdealRun& run, const Vector3d& other_N) {
  const double period_s = 1.0 / kRate_Hz;
  const Felt& felt = run.step(position_m);
  const Vector3d acceleration = (felt.force_N + other_N) / mass_kg;
  position_m += period_s * (velocity_m_s + 0.5 * period_s * acceleration);
  velocity_m_s += period_s * acceleration;
  return felt;
}

double amplitude(const std::vector<double>& signal, double rate, double frequency) {
  const auto count = static_cast<double>(signal.size());
  const double mean = std::accumulate(signal.begin(), signal.end(), 0.0) / count;
  std::complex<double> sum = 0.0;
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const auto at = static_cast<double>(i);
    const double window = 1.0 - std::cos(2.0 * std::numbers::pi * at / count);
    sum += window * (signal[i] - mean) * std::polar(1.0, -2.0 * std::numbers::pi * frequency * at / rate);
  }
  return 2.0 * std::abs(sum) / count;
}

double peak_frequency(const std::vector<double>& signal, double rate, double from, double to, int steps) {
  double best = from;
  double most = -1.0;
  for (int i = 0; i <= steps; ++i) {
    const double frequency = from + (to - from) * i / steps;
    const double here = amplitude(signal, rate, frequency);
    if (here > most) {
      most = here;
      best = frequency;
    }
  }
  return best;
}

}  // namespace thimble::test
