#include "tests/support/peer_path.h"

#include <cmath>
#include <numbers>

#include "tests/support/ideal_run.h"
#include "tests/support/random.h"

namespace thimble::test {

namespace {

template <typename Surface>
std::vector<Vector3d> path(const PeerPathOptions& options, const Surface& surface_m) {
  Random random(options.seed);
  std::vector<Vector3d> tips;
  tips.reserve(static_cast<std::size_t>(options.ticks));
  for (int tick = 0; tick < options.ticks; ++tick) {
    const double t_s = tick / kRate_Hz;
    const Vector3d out = peer_direction(t_s);
    Vector3d tip = (surface_m(out) - peer_depth_m(t_s, options.lifts)) * out;
    for (int axis = 0; axis < 3; ++axis) tip[axis] += options.noise_m * random.gaussian();
    tips.push_back(tip);
  }
  return tips;
}

}  // namespace

Vector3d peer_direction(double t_s) {
  const double lon = 2.0 * std::numbers::pi * 0.3 * t_s;
  const double lat = std::sin(2.0 * std::numbers::pi * 0.37 * t_s);
  return {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
}

double peer_depth_m(double t_s, bool lifts) {
  constexpr double kAbove_m = 6e-3;
  constexpr double kLift_s = 0.3;
  const double depth = 2e-3 + 1e-3 * std::sin(2.0 * std::numbers::pi * 1.3 * t_s);
  const double from_top_s = std::abs(std::remainder(t_s, 5.0));  // the tip is highest at 0, 5, 10 ... s
  if (!lifts || from_top_s >= kLift_s) return depth;
  const double share = std::pow(std::cos(0.5 * std::numbers::pi * from_top_s / kLift_s), 2);
  return depth + share * (-kAbove_m - depth);
}

std::vector<Vector3d> peer_path(const MeshOracle& mesh, const PeerPathOptions& options) {
  return path(options, [&](const Vector3d& out) {
    constexpr double kFar_m = 1.0;
    const std::vector<Crossing> met = mesh.crossings(kFar_m * out, Vector3d::Zero());
    return met.empty() ? 0.0 : kFar_m * (1.0 - met.front().t);
  });
}

std::vector<Vector3d> peer_path_on_sphere(double radius_m, const PeerPathOptions& options) {
  return path(options, [&](const Vector3d&) { return radius_m; });
}

}  // namespace thimble::test
