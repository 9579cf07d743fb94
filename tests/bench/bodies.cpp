#include "tests/bench/bodies.h"

#include <cmath>
#include <stdexcept>

#include "host-tools/compiler/compile.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

// mu_s 0.6, mu_d 0.4, K 1000 N/m, as on the peers' path.
constexpr Material kPeerMaterial = {
    .stiffness_N_m = 1000.0F, .damping_N_s_m = 0.0F, .static_friction = 0.6F, .dynamic_friction = 0.4F};
constexpr double kRadius_m = 0.05;

host::TriangleSoup icosphere_of(const std::string& body) {
  for (int subdivisions = 1; subdivisions <= 7; ++subdivisions)
    if (body == "icosphere-" + std::to_string(20 << (2 * subdivisions)))
      return icosphere(subdivisions, kRadius_m);
  throw std::invalid_argument(body + ": no such body (tests/bench/bodies.h)");
}

// A ball of the size of icosphere-20480, whose vertices are displaced by up to a tenth of an edge.
host::TriangleSoup rough_ball() {
  host::TriangleSoup soup = icosphere(5, kRadius_m);
  Random random(1);
  for (Vector3d& vertex : soup.vertices_m) vertex += 2e-4 * random.in_box(Vector3d::Ones());
  return soup;
}

SceneImage textured(const host::TriangleSoup& soup) {
  const TemporaryFolder folder;
  write_obj(soup, 1.0, folder.path() / "body.obj");
  return SceneImage(
      host::compile_scene_text(
          R"({"thimble_scene": 1, "name": "textured", "objects": [{"name": "body", "shape": {"mesh": {"file": "body.obj"}}, "material": {
                        "stiffness_N_m": 1000, "static_friction": 0.6, "dynamic_friction": 0.4, "texture": {
                        "kind": "height", "pattern": "cos_cos", "tile_m": [0.004, 0.004], "height_m": 0.0002}}}]})",
          "textured", folder.path())
          .image);
}

// Outwards by one radius, from places near the surface.
void move_out(std::vector<Vector3d>& path, const host::TriangleSoup& soup, double radius_m) {
  const MeshOracle oracle(soup);
  for (Vector3d& p : path) p += radius_m * oracle.normal(oracle.nearest(p).triangle);
}

}  // namespace

BenchBody bench_body(const std::string& name, const PeerPathOptions& path) {
  const std::string body = name.substr(0, name.find_first_of("@+"));
  const std::string variant = name.substr(body.size());
  const double tip_radius_m = variant.starts_with('@') ? 1e-3 * std::stod(variant.substr(1)) : 0.0;
  BenchBody made;
  made.name = name;
  if (body == "sphere") {
    made.image = SceneBuilder().sphere(kRadius_m, kPeerMaterial).image();
    made.path = peer_path_on_sphere(kRadius_m, path);
    return made;
  }
  if (body == "box") {
    made.image = SceneBuilder().box({0.1, 0.1, 0.1}, kPeerMaterial).image();
    made.path = peer_path(MeshOracle(box_mesh({0.1, 0.1, 0.1}, 1)), path);
    return made;
  }
  const host::TriangleSoup soup = body == "rough"               ? rough_ball()
                                  : body.find('/') != body.npos ? test_model(body, 0.1)
                                                                : icosphere_of(body);
  host::MeshOptions options;
  if (variant == "+shaded") options.crease_deg = 50.0;
  if (tip_radius_m > 0.0) options = {.crease_deg = {}, .tip_radius_m = tip_radius_m};
  const host::CompiledMesh mesh = host::compile_mesh(soup, options, name);
  made.soup = as_soup(mesh);
  made.bytes_per_triangle =
      static_cast<double>(mesh.report.bytes) / static_cast<double>(mesh.triangles.size());
  made.path = peer_path(MeshOracle(made.soup), path);
  made.arms = variant == "+arms" ? 2 : 1;
  SceneBuilder builder;
  builder.mesh(mesh, kPeerMaterial);
  if (variant == "+plane") builder.plane(Vector3d::UnitZ(), -0.5, kPeerMaterial);
  if (tip_radius_m > 0.0) builder.tip_radius(tip_radius_m);
  made.image = variant == "+textured" ? textured(made.soup) : builder.image();
  if (tip_radius_m > 0.0) move_out(made.path, made.soup, tip_radius_m);
  if (variant == "+far")
    for (Vector3d& p : made.path) p += 0.008 * p.normalized();
  return made;
}

}  // namespace thimble::test
