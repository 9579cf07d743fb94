// The bodies of the benchmarks by name, each of 100 mm, with the path of tests/support/peer_path.h.
//
//   sphere, box, icosphere-N (N triangles), rough (icosphere-20480 with a rough surface), lumpy (81 920 triangles, smooth bumps and hollows),
//   knot (a tube of 16 384 triangles along a trefoil knot), or a file of assimp-testmodels
//   BODY+shaded    a mesh with force shading       BODY+textured  a mesh with a height texture of 0.2 mm
//   BODY+plane     over a plane half a metre below BODY+far       the path 8 mm farther out, in free space
//   BODY+arms      two tips on the same path       BODY@RADIUS    a tip of this radius in mm, whose path is one radius farther out
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/support/meshes.h"
#include "tests/support/peer_path.h"
#include "tests/support/scene.h"

namespace thimble::test {

struct BenchBody {
  std::string name;
  host::TriangleSoup soup;  // as the controller has it; empty: no mesh
  std::optional<SceneImage> image;
  std::vector<Vector3d> path;  // of the tip
  std::size_t arms = 1;
  double bytes_per_triangle = 0;
};

// Throws where there is no such body.
[[nodiscard]] BenchBody bench_body(const std::string& name, const PeerPathOptions& path = {});

}  // namespace thimble::test
