#include "tests/bench/bodies.h"

#include <cmath>
#include <numbers>
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

// A closed body with bumps and hollows, of the triangles of icosphere-81920: as a scan of a figure has them.
host::TriangleSoup lumpy_ball() {
  host::TriangleSoup soup = icosphere(6, kRadius_m);
  for (Vector3d& vertex : soup.vertices_m) {
    const Vector3d u = vertex.normalized();
    vertex *= 1.0 + 0.15 * std::sin(4.0 * u.x() + 1.0) * std::sin(5.0 * u.y()) * std::sin(3.0 * u.z() + 2.0) +
              0.05 * std::sin(11.0 * u.x()) * std::sin(13.0 * u.y() + 1.0);
  }
  return soup;
}

// A tube along a trefoil knot, 16 384 triangles: closed, and far from convex.
host::TriangleSoup knot() {
  constexpr int kAlong = 512, kAround = 16;
  const auto middle = [](double t) {
    return Vector3d(std::sin(t) + 2.0 * std::sin(2.0 * t), std::cos(t) - 2.0 * std::cos(2.0 * t),
                    -std::sin(3.0 * t));
  };
  constexpr double kScale = kRadius_m / 3.6, kTube = 0.6;  // 3 and the tube: the largest radius
  host::TriangleSoup soup;
  for (int i = 0; i < kAlong; ++i) {
    const double t = 2.0 * std::numbers::pi * i / kAlong;
    const Vector3d along = (middle(t + 1e-4) - middle(t - 1e-4)).normalized();
    const Vector3d side = along.cross(Vector3d::UnitZ()).normalized();  // the knot is nowhere upright
    const Vector3d up = side.cross(along);
    for (int j = 0; j < kAround; ++j) {
      const double a = 2.0 * std::numbers::pi * j / kAround;
      soup.vertices_m.push_back(kScale * (middle(t) + kTube * (std::cos(a) * side + std::sin(a) * up)));
    }
  }
  const auto vertex = [](int i, int j) {
    return static_cast<std::uint32_t>(i % kAlong * kAround + j % kAround);
  };
  for (int i = 0; i < kAlong; ++i)
    for (int j = 0; j < kAround; ++j) {
      soup.triangles.push_back({vertex(i, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
      soup.triangles.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1)});
    }
  return soup;
}

host::TriangleSoup soup_of(const std::string& body) {
  if (body == "rough") return rough_ball();
  if (body == "lumpy") return lumpy_ball();
  if (body == "knot") return knot();
  return body.find('/') != body.npos ? test_model(body, 0.1) : icosphere_of(body);
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
  const host::TriangleSoup soup = soup_of(body);
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
