// Straight pokes into closed meshes whose parts cross. The tip never comes through, and while it is inside it is held
// in every tick: also where it is dragged along a seam between two parts, over many faces a tick. The judges are
// closed forms for random heaps of balls, and the winding number for models as people have them.
// THIMBLE_POKES sets the number of pokes, THIMBLE_POKE_SEED the seed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/pokes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kDefaultPokes = kUnderSanitizers ? 100 : 1e4;

double from_environment(const char* name, double otherwise) {
  const char* text = std::getenv(name);  // NOLINT(concurrency-mt-unsafe): before any thread
  return text == nullptr ? otherwise : std::strtod(text, nullptr);
}
double pokes() { return from_environment("THIMBLE_POKES", kDefaultPokes); }
std::uint64_t seed() { return static_cast<std::uint64_t>(from_environment("THIMBLE_POKE_SEED", 1.0)); }

void add(host::TriangleSoup& soup, const host::TriangleSoup& part, const Eigen::Quaterniond& turn,
         const Vector3d& at_m) {
  const auto first = static_cast<std::uint32_t>(soup.vertices_m.size());
  for (const Vector3d& v : part.vertices_m) soup.vertices_m.push_back(at_m + turn * v);
  for (const auto& t : part.triangles) soup.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

struct Tally {
  long pokes = 0;
  long in_contact = 0;
  long fallen = 0;  // pokes in which the god object was inside
  long silent = 0;  // ticks in which the tip was inside and nothing pushed

  void report(const std::string& what) const {
    figure(what + ": pokes", static_cast<double>(pokes), "");
    figure(what + ": ticks in contact", static_cast<double>(in_contact), "> 0");
    figure(what + ": pokes that fell through", static_cast<double>(fallen), "0");
    figure(what + ": ticks inside without a contact", static_cast<double>(silent), "0");
    EXPECT_GT(in_contact, 0);
    EXPECT_EQ(fallen, 0);
    EXPECT_EQ(silent, 0);
  }
};

// From one place straight to another. inside: whether a place is inside by more than rounding and facets.
void poke(IdealRun& run, const Vector3d& from, const Vector3d& to, double step_m,
          const std::function<bool(const Vector3d&)>& inside, Tally& tally) {
  run.restart(from);
  ++tally.pokes;
  bool fell = false;
  const auto ticks = static_cast<int>((to - from).norm() / step_m);
  for (int tick = 1; tick <= ticks; ++tick) {
    const Felt& felt = run.step(from + (to - from) * tick / ticks);
    if (felt.contacts > 0) {
      ++tally.in_contact;
      fell = fell || inside(felt.god_object_m);
    } else if (inside(felt.tip_m)) {
      ++tally.silent;
    }
  }
  if (fell) ++tally.fallen;
}

struct Ball {
  Vector3d centre_m;
  double radius_m = 0.0;
};

TEST(Pokes, IntoHeapsOfBalls) {
  constexpr int kHeaps = 20;
  constexpr double kFacet_m = 6e-5;  // a face of these balls is up to 40 um inside
  Tally tally;
  for (int heap = 0; heap < kHeaps; ++heap) {
    Random random(seed() * 1000 + static_cast<std::uint64_t>(heap));
    std::vector<Ball> balls(2 + random.below(5));
    host::TriangleSoup soup;
    for (Ball& ball : balls) {
      ball = {random.in_box(Vector3d::Constant(0.02)), random.uniform(0.01, 0.03)};
      add(soup, icosphere(4, ball.radius_m), random_turn(random), ball.centre_m);
    }
    const auto inside = [&](const Vector3d& p) {
      return std::any_of(balls.begin(), balls.end(), [&](const Ball& ball) {
        return (p - ball.centre_m).norm() < ball.radius_m - kFacet_m;
      });
    };
    const SceneImage image =
        SceneBuilder().mesh(host::compile_mesh(soup, {}, "heap"), random_material(random)).image();
    IdealRun run(image);
    const auto count = static_cast<long>(0.5 * pokes() / kHeaps);
    for (long i = 0; i < count; ++i) {
      const Ball& ball = balls[random.below(balls.size())];
      const double step_m = i % 10 == 0 ? 2e-6 : 1e-4;
      const Vector3d to = ball.centre_m + 0.6 * ball.radius_m * random.direction();
      const Vector3d from =
          i % 10 == 0 ? Vector3d(to + 0.003 * random.direction()) : Vector3d(0.08 * random.direction());
      if (inside(from)) continue;
      poke(run, from, to, step_m, inside, tally);
    }
  }
  tally.report("pokes into heaps of balls");
}

constexpr int kRays = 3;

Vector3d far_along(const MeshOracle& oracle, const Vector3d& p, int ray) {
  const std::array<Vector3d, kRays> ways = {Vector3d(0.532, 0.217, 0.818), Vector3d(-0.331, 0.917, 0.223),
                                            Vector3d(0.147, -0.412, -0.899)};
  return p + 2.0 * oracle.bounds().diagonal().norm() * ways[static_cast<std::size_t>(ray)];
}

// Whether a closed mesh winds round p, from the faces that a ray meets. An unlucky ray, through an edge, is outvoted.
bool winds_round(const MeshOracle& oracle, const Vector3d& p) {
  int votes = 0;
  for (int ray = 0; ray < kRays; ++ray) {
    int winding = 0;
    for (const Crossing& crossing : oracle.crossings(p, far_along(oracle, p, ray)))
      winding += crossing.inwards ? -1 : 1;
    if (winding > 0) ++votes;
  }
  return 2 * votes > kRays;
}

// Whether a ray from p meets nothing. Where a solid crosses a cavity the mesh does not wind round p either, and p is not
// free.
bool in_the_open(const MeshOracle& oracle, const Vector3d& p) {
  for (int ray = 0; ray < kRays; ++ray)
    if (!oracle.crosses(p, far_along(oracle, p, ray))) return true;
  return false;
}

// A model in itself, and heaps of two or three closed models through each other.
TEST(Pokes, IntoModelsThatCross) {
  constexpr double kSize_m = 0.1;
  constexpr double kInside_m = 2e-6;
  constexpr int kHeaps = 12;
  const std::vector<std::string> files = {"COB/molecule.cob",
                                          "3DS/fels.3ds",
                                          "Collada/sphere.dae",
                                          "FBX/animation_with_skeleton.fbx",
                                          "BLEND/TorusLightsCams_250_compressed.blend",
                                          "BLEND/HUMAN.blend",
                                          "AC/SphereWithLight.ac"};
  std::vector<host::TriangleSoup> models;
  models.reserve(files.size());
  for (const std::string& file : files) models.push_back(test_model(file, kSize_m));
  Tally tally;
  for (int heap = 0; heap < kHeaps; ++heap) {
    Random random(seed() * 1000 + 500 + static_cast<std::uint64_t>(heap));
    host::TriangleSoup crossing = heap == 0 ? models.front() : host::TriangleSoup{};
    const std::size_t parts = heap == 0 ? 0 : 2 + random.below(2);
    for (std::size_t part = 0; part < parts; ++part)
      add(crossing, models[random.below(models.size())], random_turn(random),
          random.in_box(Vector3d::Constant(0.3 * kSize_m)));
    const host::CompiledMesh mesh = host::compile_mesh(crossing, {}, "heap");
    const host::TriangleSoup soup = as_soup(mesh);
    const MeshOracle oracle(soup);
    const auto inside = [&](const Vector3d& p) {
      return winds_round(oracle, p) && oracle.nearest(p, kInside_m).triangle == 0xFFFFFFFF;
    };
    const SceneImage image = SceneBuilder().mesh(mesh, random_material(random)).image();
    IdealRun run(image);
    const auto count = static_cast<long>(0.5 * pokes() / kHeaps);
    for (long i = 0; i < count; ++i) {
      const auto& triangle = soup.triangles[random.below(soup.triangles.size())];
      const Vector3d on =
          (soup.vertices_m[triangle[0]] + soup.vertices_m[triangle[1]] + soup.vertices_m[triangle[2]]) / 3.0;
      const Vector3d from = on + 0.05 * kSize_m * random.direction();
      const Vector3d to = on + 0.05 * kSize_m * random.direction();
      if (!in_the_open(oracle, from)) continue;
      poke(run, from, to, i % 10 == 0 ? 2e-6 : 1e-4, inside, tally);
    }
  }
  tally.report("pokes into models that cross");
}

}  // namespace
}  // namespace thimble::test
