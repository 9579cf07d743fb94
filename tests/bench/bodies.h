// The bodies of the benchmark: icospheres and files of assimp-testmodels, each of 100 mm.
#pragma once

#include <string>
#include <vector>

#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/peer_path.h"
#include "tests/support/scene.h"

namespace thimble::test {

// mu_s 0.6, mu_d 0.4, K 1000 N/m, as on the peers' path.
inline constexpr Material kPeerMaterial = {
    .stiffness_N_m = 1000.0F, .damping_N_s_m = 0.0F, .static_friction = 0.6F, .dynamic_friction = 0.4F};

struct MeshBody {
  std::string name;
  host::TriangleSoup soup;  // as the controller has it
  SceneImage image;
  std::vector<Vector3d> path;
  double bytes_per_triangle = 0;
};

[[nodiscard]] inline MeshBody make_body(const std::string& name, const host::TriangleSoup& soup,
                                        const host::MeshOptions& options = {},
                                        const PeerPathOptions& path = {}) {
  const host::CompiledMesh mesh = host::compile_mesh(soup, options, name);
  host::TriangleSoup compiled = as_soup(mesh);
  std::vector<Vector3d> tips = peer_path(MeshOracle(compiled), path);
  const double bytes = static_cast<double>(mesh.report.bytes) / static_cast<double>(mesh.triangles.size());
  return {name, std::move(compiled), SceneBuilder().mesh(mesh, kPeerMaterial).image(), std::move(tips),
          bytes};
}

}  // namespace thimble::test
