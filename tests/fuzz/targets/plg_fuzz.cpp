// .plg meshes. What is read is triangles between the file's vertices.
#include <algorithm>

#include "host-tools/compiler/plg.h"
#include "host-tools/error.h"
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace thimble;
  try {
    const host::TriangleSoup soup = host::read_plg(fuzz::text_of({data, size}), "mesh.plg");
    fuzz::demand(!soup.triangles.empty(), "there is a triangle");
    for (const auto& triangle : soup.triangles)
      for (const auto corner : triangle)
        fuzz::demand(corner < soup.vertices_m.size(), "a corner is one of the vertices");
    for (const Eigen::Vector3d& vertex : soup.vertices_m)
      fuzz::demand(vertex.allFinite(), "a vertex is finite");
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput, "a bad mesh is bad input");
  }
  return 0;
}
