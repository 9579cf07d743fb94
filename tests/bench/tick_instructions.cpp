// Instructions per tick of the whole renderer, counted by callgrind: `tests/bench/instructions` runs this
// program under it. Only the ticks are instrumented, so everything before them runs fast.
//
//   tick_instructions BODY TICKS     BODY: sphere, box, icosphere-80, icosphere-1280, icosphere-20480,
//   icosphere-327680, or a file of assimp-testmodels; the path is that of tests/support/peer_path.h. Or a
//   NAME.scene.json with NAME.stroke.csv or stroke.csv in its folder, repeated. BODY@RADIUS is a body under a tip of
//   that radius in mm, whose path is one radius farther out: icosphere-20480@1.9. BODY+plane is a mesh over a plane half a metre below
//   it; BODY+shaded a mesh with force shading; BODY+far a path 8 mm farther out, in free space; BODY+arms two tips on the same
//   path. Also rough: a rough ball of 20 480 triangles. Or a layout of bodies_bench, "3 at rest", awake: at most 1000 ticks, after 400
#include <valgrind/callgrind.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
#include "tests/bench/bodies.h"
#include "tests/bench/box_layouts.h"
#include "tests/bench/scene_path.h"
#include "tests/support/ideal_run.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

std::optional<int> subdivisions(const std::string& body) {
  int result = 1;
  for (const char* name : {"icosphere-80", "icosphere-320", "icosphere-1280", "icosphere-5120",
                           "icosphere-20480", "icosphere-81920", "icosphere-327680"}) {
    if (body == name) return result;
    ++result;
  }
  return {};
}

int run_scene(const std::string& file, int ticks) {
  const ScenePath scene = scene_path(file);
  control::Renderer renderer;
  renderer.bind(scene.image.view());
  std::array<control::Touch, control::kMaxArms> touches;
  CALLGRIND_START_INSTRUMENTATION;
  for (int i = 0; i < ticks; ++i) {
    renderer.tick(std::span(scene.tips[static_cast<std::size_t>(i) % scene.tips.size()].data(), scene.arms),
                  1.0F / static_cast<float>(kRate_Hz), std::span(touches.data(), scene.arms));
  }
  CALLGRIND_STOP_INSTRUMENTATION;
  return 0;
}

int run_boxes(const Layout& layout, int ticks) {
  constexpr int kSettles = 400;
  constexpr float kPeriod_s = 1.0F / 4000.0F;
  const SceneImage image(host::compile_scene_text(box_scene(layout), "bench.scene.json", ".").image);
  control::Renderer renderer;
  renderer.bind(image.view());
  for (int i = 0; i < kSettles; ++i) renderer.tick({}, kPeriod_s, {});
  CALLGRIND_START_INSTRUMENTATION;
  for (int i = 0; i < ticks; ++i) renderer.tick({}, kPeriod_s, {});
  CALLGRIND_STOP_INSTRUMENTATION;
  return 0;
}

// A ball of the size of icosphere-20480, whose vertices are displaced by up to a tenth of an edge.
host::TriangleSoup rough_ball() {
  host::TriangleSoup soup = icosphere(5, 0.05);
  Random random(1);
  for (Vector3d& vertex : soup.vertices_m) vertex += 2e-4 * random.in_box(Vector3d::Ones());
  return soup;
}

// Outwards by one radius, from places near the surface.
void move_out(std::vector<Vector3d>& path, const host::TriangleSoup& soup, double radius_m) {
  const MeshOracle oracle(soup);
  for (Vector3d& p : path) {
    const Vector3d normal = oracle.normal(oracle.nearest(p).triangle);
    p += radius_m * normal;
  }
}

int run(const std::string& what, int ticks) {
  const std::string body = what.substr(0, what.find_first_of("@+"));
  const bool over_plane = what.ends_with("+plane");
  const bool two_arms = what.ends_with("+arms");
  const double radius_m =
      what.find('@') == std::string::npos ? 0.0 : 1e-3 * std::stod(what.substr(body.size() + 1));
  const PeerPathOptions options = {.ticks = ticks, .noise_m = 2e-6, .seed = 1, .lifts = true};
  std::optional<SceneImage> image;
  std::vector<Vector3d> path;
  if (body == "sphere") {
    image = SceneBuilder().sphere(0.05, kPeerMaterial).image();
    path = peer_path_on_sphere(0.05, options);
  } else if (body == "box") {
    image = SceneBuilder().box({0.1, 0.1, 0.1}, kPeerMaterial).image();
    path = peer_path(MeshOracle(box_mesh({0.1, 0.1, 0.1}, 1)), options);
  } else {
    const std::optional<int> level = subdivisions(body);
    const host::TriangleSoup soup = level             ? icosphere(*level, 0.05)
                                    : body == "rough" ? rough_ball()
                                                      : test_model(body, 0.1);
    host::MeshOptions mesh_options;
    if (what.ends_with("+shaded")) mesh_options.crease_deg = 50.0;
    MeshBody mesh = make_body(body, soup, mesh_options, options);
    image =
        radius_m > 0.0 ? SceneBuilder()
                             .mesh(soup, kPeerMaterial, {.crease_deg = {}, .tip_radius_m = radius_m})
                             .tip_radius(radius_m)
                             .image()
        : over_plane
            ? SceneBuilder().mesh(soup, kPeerMaterial).plane(Vector3d::UnitZ(), -0.5, kPeerMaterial).image()
            : std::move(mesh.image);
    path = std::move(mesh.path);
    if (radius_m > 0.0) move_out(path, soup, radius_m);
  }
  if (what.ends_with("+far"))
    for (Vector3d& p : path) p += 0.008 * p.normalized();
  control::Renderer renderer;
  renderer.bind(image->view());
  const std::size_t arms = two_arms ? 2 : 1;
  float sum_N = 0.0F;
  CALLGRIND_START_INSTRUMENTATION;
  for (const Vector3d& p : path) {
    std::array<control::Tip, 2> tips;
    tips.fill({.position_m = p.cast<float>(), .velocity_m_s = Vec3::Zero()});
    std::array<control::Touch, 2> touches;
    renderer.tick(std::span(tips).first(arms), 1.0F / static_cast<float>(kRate_Hz),
                  std::span(touches).first(arms));
    sum_N += touches[0].force_N.norm();
  }
  CALLGRIND_STOP_INSTRUMENTATION;
  std::printf("%s: %zu ticks, mean force %.3f N\n", body.c_str(), path.size(),
              static_cast<double>(sum_N) / static_cast<double>(path.size()));
  return 0;
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: tick_instructions BODY TICKS\n");
    return 2;
  }
  const std::string body = argv[1];
  for (const thimble::test::Layout& layout : thimble::test::box_layouts())
    if (body == layout.name) return thimble::test::run_boxes(layout, std::stoi(argv[2]));
  if (body.ends_with(".json")) return thimble::test::run_scene(body, std::stoi(argv[2]));
  return thimble::test::run(body, std::stoi(argv[2]));
}
