// Shared by the tests of surfaces: a scene with one object from scene-file text, a free mass as the hand, and
// a spectrum.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/ideal_run.h"
#include "tests/support/scene.h"

namespace thimble::test {

using Eigen::Vector3d;

inline constexpr const char* kFloor = R"("plane": {"normal": [0, 0, 1]})";

// One object named "it" at the origin; `material` and `shape` are the members of the JSON objects of those
// names. Files are looked for in `folder`.
[[nodiscard]] SceneImage surface_scene(const std::string& material, const std::string& shape = kFloor,
                                       const std::filesystem::path& folder = {});

// A point mass that the renderer pushes: force held for a tick, so that the steps are exact.
struct Mass {
  double mass_kg;
  Vector3d position_m;
  Vector3d velocity_m_s;

  // One period under `other_N` and the force that was felt at its start.
  const Felt& step(IdealRun& run, const Vector3d& other_N = Vector3d::Zero());
};

// Amplitude of the signal at a frequency, its mean taken away (a Hann window, one bin of a Fourier
// transform).
[[nodiscard]] double amplitude(const std::vector<double>& signal, double rate, double frequency);

// Where the amplitude is largest between two frequencies, in `steps` steps.
[[nodiscard]] double peak_frequency(const std::vector<double>& signal, double rate, double from, double to,
                                    int steps = 2000);

}  // namespace thimble::test
