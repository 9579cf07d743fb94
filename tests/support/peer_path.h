// The path that is used to compare haptic engines, at 4 kHz: around the body with lon = 2 pi 0.3 t and lat =
// sin(2 pi 0.37 t) seen from its centre, up to 0.15 m/s; the tip is 2 + sin(2 pi 1.3 t) mm below the surface;
// every 5 s it moves to 6 mm above the surface and back, 0.3 s each way; plus 2 um of Gaussian noise. On a
// sphere of 100 mm the tip is in contact 92 % of the time.
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

// Direction of the tip from the centre, and its depth, at t.
[[nodiscard]] Vector3d peer_direction(double t_s);
[[nodiscard]] double peer_depth_m(double t_s, bool lifts);

// The surface is the first intersection of a ray from far outside to the origin.
[[nodiscard]] std::vector<Vector3d> peer_path(const MeshOracle& mesh, const PeerPathOptions& options = {});
[[nodiscard]] std::vector<Vector3d> peer_path_on_sphere(double radius_m, const PeerPathOptions& options = {});

}  // namespace thimble::test
