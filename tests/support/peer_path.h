// The path on which haptic engines are compared, at 4 kHz: round the body with lon = 2 pi 0.3 t and lat =
// sin(2 pi 0.37 t) seen from its centre, up to 0.15 m/s; the tip 2 + sin(2 pi 1.3 t) mm under the surface;
// every 5 s 6 mm above it and back, 0.3 s each way; on top 2 um of Gaussian noise. A tip on a body of 100 mm
// is in contact 92 % of the time.
#pragma once

#include <vector>

#include "tests/support/oracle.h"

namespace thimble::test {

inline constexpr int kPeerTicks = 200'000;

struct PeerPathOptions {
  int ticks = kPeerTicks;
  double noise_m = 2e-6;
  std::uint64_t seed = 1;
  bool lifts = true;
};

// The tip's direction from the centre, and how deep it is, at t.
[[nodiscard]] Vector3d peer_direction(double t_s);
[[nodiscard]] double peer_depth_m(double t_s, bool lifts);

// The surface is what a ray from far outside to the origin meets first.
[[nodiscard]] std::vector<Vector3d> peer_path(const MeshOracle& mesh, const PeerPathOptions& options = {});
[[nodiscard]] std::vector<Vector3d> peer_path_on_sphere(double radius_m, const PeerPathOptions& options = {});

}  // namespace thimble::test
