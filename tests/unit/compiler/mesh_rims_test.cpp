// Where a tip with a size touches nothing but the face that it lies on (host-tools/compiler/mesh_rims.h), against distances that share no
// code with it. Also the distance of two triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "control/scene/mesh_triangle.h"
#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/triangle_distance.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using Weights = std::array<double, 3>;

struct RimCase {
  std::string name;
  host::TriangleSoup soup;
  double radius_m;
  double least_share;  // of the faces' area, where it touches nothing else
  host::MeshSide side = host::MeshSide::kOutside;
};

std::vector<RimCase> cases() {
  return {{"icosphere 80, 6 mm", icosphere(1, 0.03), 0.006, 0.99},
          {"icosphere 5120, 0.2 mm", icosphere(4, 0.03), 0.0002, 0.99},
          {"icosphere 5120, 10 mm", icosphere(4, 0.03), 0.01, 0.99},
          {"torus, 1 mm", torus(0.02, 0.006, 40, 20), 0.001, 0.8},
          {"torus, 5 mm", torus(0.02, 0.006, 40, 20), 0.005, 0.5},
          {"plate of 0.1 mm, 2 mm", box_mesh({0.03, 0.03, 1e-4}, 5), 0.002, 0.99},
          {"groove of 40 degrees, 3 mm", v_groove(40.0, 0.01, 0.05, 7), 0.003, 0.2},
          {"terrain, 0.3 mm", hostile_terrain(40, 0.001, 0.002, 7), 0.0003, 0.2},
          {"terrain, 2 mm", hostile_terrain(40, 0.001, 0.002, 7), 0.002, 0.5},
          {"cube room, 3 mm", box_mesh({0.04, 0.04, 0.04}, 6), 0.003, 0.4, host::MeshSide::kInside},
          {"HUMAN, 0.5 mm", test_model("BLEND/HUMAN.blend", 0.2), 0.0005, 0.2},
          {"Wuson, 1 mm", test_model("OFF/Wuson.off", 0.1), 0.001, 0.5},
          {"spider, 1 mm", test_model("OBJ/spider.obj", 0.1), 0.001, 0.5}};
}

class Rims {
 public:
  Rims(const host::CompiledMesh& mesh, const MeshOracle& oracle) : mesh_(mesh), oracle_(oracle) {}

  [[nodiscard]] bool within(std::uint32_t triangle, const Weights& at) const {
    for (std::uint32_t edge = 0; edge < 3; ++edge)
      if (255.0 * at[(edge + 2) % 3] < mesh_.rims[3 * triangle + edge] - 1e-9) return false;
    return true;
  }
  [[nodiscard]] Vector3d place(std::uint32_t triangle, const Weights& at) const {
    return at[0] * oracle_.corner(triangle, 0) + at[1] * oracle_.corner(triangle, 1) +
           at[2] * oracle_.corner(triangle, 2);
  }

 private:
  const host::CompiledMesh& mesh_;
  const MeshOracle& oracle_;
};

TEST(MeshRims, NothingElseIsTouched) {
  const int places = kUnderSanitizers ? 2000 : 40000;
  for (const RimCase& test : cases()) {
    const host::CompiledMesh mesh = host::compile_mesh(
        test.soup, {.side = test.side, .crease_deg = {}, .tip_radius_m = test.radius_m}, test.name);
    ASSERT_EQ(mesh.rims.size(), 3 * mesh.triangles.size());
    const MeshOracle oracle(as_soup(mesh));
    const Rims rims(mesh, oracle);
    Random random(5);
    double nearest_m = 1.0;
    double round_m = 1.0;
    double free = 0.0;
    double area = 0.0;
    long rounds = 0;
    for (int i = 0; i < places; ++i) {
      const auto t = static_cast<std::uint32_t>(random.below(mesh.triangles.size()));
      Weights at{random.uniform(0.0, 1.0), random.uniform(0.0, 1.0), 0.0};
      if (at[0] + at[1] > 1.0) at = {1.0 - at[0], 1.0 - at[1], 0.0};
      at[2] = 1.0 - at[0] - at[1];
      const double weight =
          (oracle.corner(t, 1) - oracle.corner(t, 0)).cross(oracle.corner(t, 2) - oracle.corner(t, 0)).norm();
      area += weight;
      if (rims.within(t, at)) {
        free += weight;
        const Vector3d centre = rims.place(t, at) + test.radius_m * oracle.normal(t);
        nearest_m = std::min(nearest_m, oracle.nearest(centre).distance_m - test.radius_m);
      }
      // Over an edge that it may roll over.
      const auto edge = static_cast<std::uint32_t>(random.below(3));
      if (mesh.rims[3 * t] == 255 || mesh.rims[3 * t + edge] != 0) continue;
      const std::uint32_t beyond = control::edge_beyond(mesh.triangles[t], edge);
      const std::uint32_t other = beyond / 3;
      ASSERT_EQ(mesh.rims[3 * other + beyond % 3], 0) << test.name;
      const double part = random.uniform(0.0, 1.0);
      Weights on_edge{};
      on_edge[edge] = 1.0 - part;
      on_edge[(edge + 1) % 3] = part;
      Weights there{};
      there[beyond % 3] = part;
      there[(beyond % 3 + 1) % 3] = 1.0 - part;
      const Vector3d foot = rims.place(t, on_edge);
      ASSERT_LT((foot - rims.place(other, there)).norm(), 1e-9) << test.name;
      if (!rims.within(t, on_edge) || !rims.within(other, there)) continue;
      const double turn = random.uniform(0.0, 1.0);
      const Vector3d normal = ((1.0 - turn) * oracle.normal(t) + turn * oracle.normal(other)).normalized();
      round_m = std::min(round_m, oracle.nearest(foot + test.radius_m * normal).distance_m - test.radius_m);
      ++rounds;
    }
    const std::string what = "rims, " + test.name + ": ";
    figure(what + "part of the area", free / area, "");
    figure(what + "nearest to anything, um from the radius", 1e6 * nearest_m, ">= -0.3");
    if (rounds > 0) figure(what + "round an edge, um", 1e6 * round_m, ">= -0.3");
    EXPECT_GE(free / area, test.least_share) << test.name;
    EXPECT_GE(nearest_m, -3e-7) << test.name;
    EXPECT_GE(round_m, -3e-7) << test.name;
  }
}

// The least distance over the points of one triangle is found by halving it: |p - nearest(p)| changes by no more than p.
double by_halving(const host::Triangle3& a, const MeshOracle& b, double within_m) {
  struct Part {
    host::Triangle3 at_m;
    double least_m;
  };
  const auto part = [&](const host::Triangle3& at) {
    const Vector3d middle = (at[0] + at[1] + at[2]) / 3.0;
    const double reach =
        std::max({(at[0] - middle).norm(), (at[1] - middle).norm(), (at[2] - middle).norm()});
    return Part{at, b.nearest(middle).distance_m - reach};
  };
  const auto farther = [](const Part& x, const Part& y) { return x.least_m > y.least_m; };
  std::vector<Part> parts{part(a)};
  double most_m = 1e9;
  while (parts.front().least_m < most_m - within_m) {
    std::pop_heap(parts.begin(), parts.end(), farther);
    const host::Triangle3 t = parts.back().at_m;
    parts.pop_back();
    const Vector3d ab = 0.5 * (t[0] + t[1]);
    const Vector3d bc = 0.5 * (t[1] + t[2]);
    const Vector3d ca = 0.5 * (t[2] + t[0]);
    for (const host::Triangle3& one :
         std::array<host::Triangle3, 4>{{{t[0], ab, ca}, {ab, t[1], bc}, {ca, bc, t[2]}, {ab, bc, ca}}}) {
      most_m = std::min(most_m, b.nearest(one[0]).distance_m);
      parts.push_back(part(one));
      std::push_heap(parts.begin(), parts.end(), farther);
    }
  }
  return most_m;
}

TEST(TriangleDistance, AgreesWithHalving) {
  Random random(3);
  double worst = 0.0;
  int apart = 0;
  const int pairs = kUnderSanitizers ? 40 : 400;
  constexpr double kWithin = 1e-3;
  for (int i = 0; i < pairs; ++i) {
    host::Triangle3 a;
    host::Triangle3 b;
    const Vector3d between = random.in_box(Vector3d::Constant(1.2));
    for (int corner = 0; corner < 3; ++corner) {
      a[static_cast<std::size_t>(corner)] = random.in_box(Vector3d::Constant(1.0));
      b[static_cast<std::size_t>(corner)] =
          between + random.in_box(Vector3d(1.0, 1.0, i % 3 == 0 ? 0.0 : 1.0));
      if (i % 4 == 0)
        a[static_cast<std::size_t>(corner)].z() = 0.0;  // level, and in every fourth case parallel
    }
    const double distance = host::triangle_distance(a, b);
    EXPECT_NEAR(host::triangle_distance(b, a), distance, 1e-12);
    const MeshOracle oracle({{b[0], b[1], b[2]}, {{0, 1, 2}}, {}});
    EXPECT_NEAR(host::point_distance(a[0], b), oracle.nearest(a[0]).distance_m, 1e-9);
    worst = std::max(worst, std::abs(distance - by_halving(a, oracle, kWithin)));
    if (distance > 0.0) ++apart;
  }
  figure("distance of two triangles, against halving", worst, "< 0.001");
  figure("distance of two triangles: pairs that are apart, %", 100.0 * apart / pairs, "");
  EXPECT_LT(worst, kWithin);
  EXPECT_GT(apart, pairs / 4);
  EXPECT_LT(apart, pairs);
  // A segment and a point.
  const Vector3d p(0.0, 0.0, 2.0);
  EXPECT_DOUBLE_EQ(
      host::triangle_distance({p, p, p}, {Vector3d(-1, -1, 0), Vector3d(1, -1, 0), Vector3d(0, 1, 0)}), 2.0);
  EXPECT_DOUBLE_EQ(
      host::triangle_distance({p, p, p}, {Vector3d(-1, 0, 0), Vector3d(1, 0, 0), Vector3d(1, 0, 0)}), 2.0);
}

}  // namespace
}  // namespace thimble::test
