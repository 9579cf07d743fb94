// compile_mesh: welding, repair, winding, adjacency, normals, tree, flags; and independence of the
// unit.
#include "host-tools/compiler/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "control/scene/limits.h"
#include "control/scene/mesh_triangle.h"
#include "control/scene/octahedral.h"
#include "host-tools/compiler/mesh_cross.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/unit/compiler/sound_mesh.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;
using host::compile_mesh;
using host::CompiledMesh;
using host::MeshOptions;
using host::MeshSide;
using host::TriangleSoup;
using scene::TriangleFlag;

TriangleSoup tetrahedron(const Vector3d& at, double size) {
  TriangleSoup soup;
  soup.vertices_m = {at, at + Vector3d(size, 0, 0), at + Vector3d(0, size, 0), at + Vector3d(0, 0, size)};
  soup.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  return soup;
}

TriangleSoup joined(TriangleSoup a, const TriangleSoup& b) {
  const auto base = static_cast<std::uint32_t>(a.vertices_m.size());
  a.vertices_m.insert(a.vertices_m.end(), b.vertices_m.begin(), b.vertices_m.end());
  for (const auto& t : b.triangles) {
    a.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
  }
  return a;
}

TriangleSoup reversed(TriangleSoup soup) {
  for (auto& t : soup.triangles) {
    std::swap(t[0], t[1]);
  }
  return soup;
}

TriangleSoup moved(const TriangleSoup& soup, const Vector3d& by) {
  return transformed(soup, Eigen::Matrix3d::Identity(), by);
}

// No two triangles share an index, as in an STL file.
TriangleSoup unshared(const TriangleSoup& soup) {
  TriangleSoup apart;
  for (const auto& t : soup.triangles) {
    const auto base = static_cast<std::uint32_t>(apart.vertices_m.size());
    for (const std::uint32_t v : t) {
      apart.vertices_m.push_back(soup.vertices_m[v]);
    }
    apart.triangles.push_back({base, base + 1, base + 2});
  }
  return apart;
}

MeshOptions creased(double degrees) {
  MeshOptions options;
  options.crease_deg = degrees;
  return options;
}

std::string refusal(const TriangleSoup& soup) {
  try {
    static_cast<void>(compile_mesh(soup, {}, "soup"));
  } catch (const host::Error& error) {
    EXPECT_EQ(error.code, host::ExitCode::kBadInput);
    EXPECT_THAT(error.cause, testing::StartsWith("soup: "));
    EXPECT_FALSE(error.remedy.empty());
    return error.name;
  }
  return "";
}

Vector3d decoded(std::uint32_t bits) { return control::decode_octahedral(bits).cast<double>(); }

double angle_deg(const Vector3d& a, const Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

TEST(Octahedral, RoundTripErrsByLessThanAFiveThousandthOfADegree) {
  Random random(1);
  double worst = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    Vector3d n = random.direction();
    if (i % 4 == 0) {  // the folds
      n[i / 4 % 3] = 0;
      n.normalize();
    }
    const Vector3d back = decoded(control::encode_octahedral(n.cast<float>()));
    ASSERT_NEAR(back.norm(), 1.0, 1.0e-6);
    worst = std::max(worst, angle_deg(n, back));
  }
  EXPECT_LT(figure("octahedral round trip, worst error, degrees", worst, "< 0.005"), 0.005);
  for (const Vector3d& axis :
       {Vector3d(0, 0, 1), Vector3d(0, 0, -1), Vector3d(-1, 0, 0), Vector3d(0, 1, 0)}) {
    EXPECT_EQ(angle_deg(axis, decoded(control::encode_octahedral(axis.cast<float>()))), 0.0);
  }
}

TEST(CompileMesh, IcospheresFrom80To327680TrianglesFitIn64BytesEach) {
  constexpr int kFinest = kUnderSanitizers ? 5 : 7;
  for (int subdivisions = 1; subdivisions <= kFinest; ++subdivisions) {
    const TriangleSoup soup = icosphere(subdivisions, 0.05);
    const auto start = std::chrono::steady_clock::now();
    const CompiledMesh mesh = compile_mesh(soup, creased(40), "icosphere");
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::string what = std::to_string(mesh.triangles.size()) + " triangles: ";
    EXPECT_EQ(unsound(mesh), "") << what;
    EXPECT_EQ(mesh.triangles.size(), soup.triangles.size());
    EXPECT_EQ(mesh.vertices.size(), soup.vertices_m.size());
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_EQ(mesh.report.components, 1U);
    EXPECT_EQ(mesh.report.flipped_components, 0U);
    EXPECT_EQ(mesh.report.pierced_triangles, 0U);
    EXPECT_EQ(count_flag(mesh, TriangleFlag::TwoSided), 0U);
    const double bytes = static_cast<double>(mesh.report.bytes) / static_cast<double>(mesh.triangles.size());
    EXPECT_LE(figure(what + "bytes a triangle, mesh and tree, shaded", bytes, "<= 64"), 64.0);
    figure(what + "depth of the tree", mesh.depth, "<= 48");
    EXPECT_LT(figure(what + "seconds to compile", seconds, "< 60; < 5 in a release build"), 60.0);
    double worst = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint16_t c = 0; c < 3; ++c) {
        const Vector3d radial = position(mesh, control::vertex_of(mesh.triangles[t], c)).normalized();
        worst = std::max(worst, angle_deg(radial, decoded(mesh.corner_normals[3 * t + c])));
      }
    }
    // Angle weighting is exact at the 12 vertices of five faces, first order elsewhere.
    figure(what + "corner normal against the sphere's, worst, degrees", worst, "falls with the edge length");
    EXPECT_LT(worst, 8.0 / std::pow(2.0, subdivisions));
  }
}

TEST(CompileMesh, TheSameSoupGivesTheSameBytes) {
  const TriangleSoup soup = joined(torus(0.03, 0.012, 60, 30), icosphere(3, 0.02));
  EXPECT_TRUE(same_bytes(compile_mesh(soup, creased(30), "a"), compile_mesh(soup, creased(30), "b")));
}

TEST(CompileMesh, NothingDependsOnTheFilesUnit) {
  Random random(7);
  for (const TriangleSoup& soup :
       {unshared(icosphere(4, 0.05)), box_mesh({0.1, 0.08, 0.0001}, 12), torus(0.03, 0.012, 60, 30),
        hostile_terrain(24, 0.004, 0.004, 3), sheet(0.1, 20)}) {
    const CompiledMesh metres = compile_mesh(soup, creased(40), "m");
    EXPECT_EQ(unsound(metres), "");
    for (const double units_per_m : {10.0, 1000.0, 39.37007874015748, 3.0e5}) {
      TriangleSoup other = soup;
      for (Vector3d& p : other.vertices_m) {  // as a file in that unit and the scene's scale would give it
        p = p * units_per_m * (1.0 / units_per_m);
      }
      const CompiledMesh mesh = compile_mesh(other, creased(40), "unit");
      ASSERT_EQ(mesh.triangles.size(), metres.triangles.size()) << units_per_m;
      EXPECT_EQ(mesh.flags, metres.flags) << units_per_m;
      double worst = 0;
      bool same_topology = mesh.nodes.size() == metres.nodes.size();
      for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
        for (std::uint16_t c = 0; c < 3; ++c) {
          same_topology =
              same_topology &&
              control::vertex_of(mesh.triangles[t], c) == control::vertex_of(metres.triangles[t], c) &&
              control::edge_beyond(mesh.triangles[t], c) == control::edge_beyond(metres.triangles[t], c);
        }
      }
      EXPECT_TRUE(same_topology) << units_per_m;
      for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
        worst = std::max(worst, (position(mesh, v) - position(metres, v)).norm());
      }
      EXPECT_LT(figure("other unit: worst vertex difference, m", worst, "< 1e-8"), 1.0e-8);
    }
  }
}

TEST(CompileMesh, WeldsWhatAnStlFileTearsApart) {
  const TriangleSoup whole = icosphere(4, 0.05);
  TriangleSoup torn = unshared(whole);
  Random random(3);
  for (Vector3d& p : torn.vertices_m) {  // half the welding tolerance
    p += random.direction() * 2.0e-8;
  }
  const CompiledMesh mesh = compile_mesh(torn, {}, "torn");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.vertices.size(), whole.vertices_m.size());
  EXPECT_EQ(mesh.report.open_edges, 0U);
}

TEST(CompileMesh, WindsClosedComponentsOutwards) {
  const TriangleSoup sphere = icosphere(3, 0.05);
  const double expected = volume_m3(compile_mesh(sphere, {}, "sphere"));
  EXPECT_NEAR(expected, 4.0 / 3.0 * std::numbers::pi * std::pow(0.05, 3), 0.02 * expected);
  const CompiledMesh inverted = compile_mesh(reversed(sphere), {}, "inverted");
  EXPECT_EQ(unsound(inverted), "");
  EXPECT_DOUBLE_EQ(volume_m3(inverted), expected);
  EXPECT_EQ(inverted.report.flipped_components, 1U);
  Random random(5);
  TriangleSoup mixed = sphere;
  for (auto& t : mixed.triangles) {
    if (random.below(2) == 0) {
      std::swap(t[0], t[2]);
    }
  }
  const CompiledMesh sorted = compile_mesh(mixed, {}, "mixed");
  EXPECT_EQ(unsound(sorted), "");
  EXPECT_NEAR(volume_m3(sorted), expected, 1e-9 * expected);
}

TEST(CompileMesh, KeepsACavityInwardsAndOnlyACavity) {
  const TriangleSoup shell = icosphere(3, 0.05);
  const TriangleSoup core = icosphere(3, 0.02);
  const TriangleSoup seed = icosphere(2, 0.005);
  const double shell_m3 = volume_m3(compile_mesh(shell, {}, "shell"));
  const double core_m3 = volume_m3(compile_mesh(core, {}, "core"));
  const double seed_m3 = volume_m3(compile_mesh(seed, {}, "seed"));
  const double slack = 1.0e-4 * seed_m3;
  struct Case {
    const char* what;
    TriangleSoup soup;
    double volume_m3;
  };
  const TriangleSoup beside = moved(core, {0.2, 0, 0});
  for (const Case& c :
       {Case{"hollow", joined(shell, reversed(core)), shell_m3 - core_m3},
        Case{"hollow, all reversed", joined(reversed(shell), core), shell_m3 - core_m3},
        Case{"nested, wound alike", joined(shell, core), shell_m3 + core_m3},
        Case{"hollow with a body inside", joined(joined(shell, reversed(core)), seed),
             shell_m3 - core_m3 + seed_m3},
        Case{"side by side, wound differently", joined(shell, reversed(beside)), shell_m3 + core_m3},
        Case{"inner part first", joined(reversed(core), shell), shell_m3 - core_m3}}) {
    const CompiledMesh mesh = compile_mesh(c.soup, {}, c.what);
    EXPECT_EQ(unsound(mesh), "") << c.what;
    EXPECT_NEAR(volume_m3(mesh), c.volume_m3, slack) << c.what;
    EXPECT_EQ(mesh.report.open_edges, 0U) << c.what;
    MeshOptions inside;
    inside.side = MeshSide::kInside;
    const CompiledMesh inner = compile_mesh(c.soup, inside, c.what);
    EXPECT_EQ(unsound(inner), "") << c.what;
    EXPECT_NEAR(volume_m3(inner), -c.volume_m3, slack) << c.what;
  }
}

TEST(CompileMesh, OpenSheetsAndSideBothAreTwoSided) {
  const CompiledMesh flat = compile_mesh(sheet(0.1, 10), {}, "sheet");
  EXPECT_EQ(unsound(flat), "");
  EXPECT_EQ(flat.report.open_edges, 40U);
  EXPECT_EQ(count_flag(flat, TriangleFlag::TwoSided), flat.triangles.size());
  const CompiledMesh mixed =
      compile_mesh(joined(sheet(0.1, 10), moved(icosphere(2, 0.02), {0, 0, 0.1})), {}, "mixed");
  EXPECT_EQ(count_flag(mixed, TriangleFlag::TwoSided), 200U);
  EXPECT_EQ(mixed.report.components, 2U);
  MeshOptions both;
  both.side = MeshSide::kBoth;
  const CompiledMesh ball = compile_mesh(icosphere(2, 0.02), both, "both");
  EXPECT_EQ(count_flag(ball, TriangleFlag::TwoSided), ball.triangles.size());
}

TEST(CompileMesh, AMoebiusStripIsCutWhereItComesBackReversed) {
  TriangleSoup strip;
  constexpr std::uint32_t kAround = 40;
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const double a = 2.0 * std::numbers::pi * i / kAround;
    const Vector3d middle(0.04 * std::cos(a), 0.04 * std::sin(a), 0);
    const Vector3d across =
        0.01 * (std::cos(a / 2) * middle.normalized() + std::sin(a / 2) * Vector3d::UnitZ());
    strip.vertices_m.push_back(middle - across);
    strip.vertices_m.push_back(middle + across);
  }
  for (std::uint32_t i = 0; i < kAround; ++i) {
    const std::uint32_t a = 2 * i;
    const std::uint32_t b = 2 * i + 1;
    const bool last = i + 1 == kAround;
    const std::uint32_t c = last ? 1 : a + 2;
    const std::uint32_t d = last ? 0 : b + 2;
    strip.triangles.push_back({a, b, c});
    strip.triangles.push_back({b, d, c});
  }
  const CompiledMesh mesh = compile_mesh(strip, {}, "strip");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.report.components, 1U);
  EXPECT_EQ(mesh.report.open_edges, 2U * kAround + 2U);  // both rims and the two sides of the cut
  EXPECT_EQ(count_flag(mesh, TriangleFlag::TwoSided), mesh.triangles.size());
}

TEST(CompileMesh, CubesThatShareAnEdgeAreJoinedOnTheFreeSide) {
  // Below and above the shared edge (the y axis): free to the left and to the right.
  const TriangleSoup low = moved(box_mesh({0.02, 0.02, 0.02}, 1), {-0.01, 0, -0.01});
  const TriangleSoup high = moved(box_mesh({0.02, 0.02, 0.02}, 1), {0.01, 0, 0.01});
  for (const TriangleSoup& soup :
       {joined(low, high), joined(reversed(low), high), joined(reversed(high), reversed(low))}) {
    const CompiledMesh mesh = compile_mesh(soup, {}, "cubes");
    EXPECT_EQ(unsound(mesh), "");
    EXPECT_EQ(mesh.triangles.size(), 24U);
    EXPECT_EQ(mesh.report.non_manifold_edges, 1U);
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_NEAR(volume_m3(mesh), 2 * 8e-6, 1e-11);
    std::size_t across = 0;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      for (std::uint16_t e = 0; e < 3; ++e) {
        const Vector3d a = position(mesh, control::vertex_of(mesh.triangles[t], e));
        const Vector3d b = position(mesh, control::vertex_of(mesh.triangles[t], (e + 1U) % 3U));
        if (Vector3d(a.x(), 0, a.z()).norm() < 1e-9 && Vector3d(b.x(), 0, b.z()).norm() < 1e-9) {
          EXPECT_NE(mesh.flags[t] & static_cast<unsigned>(TriangleFlag::Pierced), 0U);
          const std::uint32_t other = control::edge_beyond(mesh.triangles[t], e) / 3;
          const auto centre = [&](std::uint32_t triangle) {
            Vector3d sum = Vector3d::Zero();
            for (std::uint16_t c = 0; c < 3; ++c)
              sum += position(mesh, control::vertex_of(mesh.triangles[triangle], c)) / 3.0;
            return sum;
          };
          // The next face on the free side belongs to the other cube: one is above z = 0, one below.
          EXPECT_LT(centre(t).x() * centre(other).x(), 1e-12);
          EXPECT_LT(centre(t).z() * centre(other).z(), 1e-12);
          EXPECT_GT((centre(t) - centre(other)).norm(), 1e-3);
          ++across;
        }
      }
    }
    EXPECT_EQ(across, 4U);
  }
}

TEST(CompileMesh, ThreeSheetsAtOneEdgeKeepASoundAdjacency) {
  TriangleSoup soup;
  soup.vertices_m = {{0, 0, 0}, {0, 0.1, 0}, {0.1, 0, 0}, {-0.1, 0, 0.05}, {-0.1, 0, -0.05}};
  soup.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  const CompiledMesh mesh = compile_mesh(soup, {}, "book");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.report.non_manifold_edges, 1U);
  EXPECT_EQ(count_flag(mesh, TriangleFlag::Pierced), 3U);
  EXPECT_EQ(count_flag(mesh, TriangleFlag::TwoSided), 3U);
}

TEST(CompileMesh, PartsThatTouchAtOnePointGetAVertexEach) {
  const TriangleSoup soup = joined(tetrahedron({0, 0, 0}, 0.05), tetrahedron({0, 0, 0}, -0.05));
  const CompiledMesh mesh = compile_mesh(soup, {}, "bow tie");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.vertices.size(), 8U);
  EXPECT_EQ(mesh.report.components, 2U);
  EXPECT_EQ(mesh.report.open_edges, 0U);
  EXPECT_EQ(count_flag(mesh, TriangleFlag::Pierced), 0U);
}

TEST(CompileMesh, ACapIsFlippedAwayWithoutAHole) {
  // A tetrahedron whose edge 1-2 is doubled by a vertex in its middle, which only one side's faces use: the
  // cap 1-4-2.
  TriangleSoup soup = tetrahedron({0, 0, 0}, 0.05);
  for (const double off : {0.0, 1.0e-8, -1.0e-8}) {
    soup.vertices_m.resize(4);
    soup.vertices_m.push_back((soup.vertices_m[1] + soup.vertices_m[2]) / 2.0 + Vector3d(off, off, off));
    soup.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 4, 3}, {4, 2, 3}, {1, 2, 4}};
    const CompiledMesh mesh = compile_mesh(soup, {}, "cap");
    EXPECT_EQ(unsound(mesh), "");
    EXPECT_EQ(mesh.triangles.size(), 6U);  // 0-2-1 became two
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_EQ(mesh.report.non_manifold_edges, 0U);
    EXPECT_EQ(mesh.report.degenerate_dropped, 1U);
    EXPECT_EQ(mesh.report.pierced_triangles, 0U);
    EXPECT_NEAR(volume_m3(mesh), std::pow(0.05, 3) / 6.0, 1e-10);
  }
}

TEST(CompileMesh, ChainsOfCapsCloseToo) {
  // A box whose top and front are cut into strips that do not match along their common edge, sewn by a fan of
  // caps.
  TriangleSoup soup;
  constexpr std::uint32_t kCuts = 7;
  for (std::uint32_t i = 0; i <= kCuts; ++i) {  // the sewn edge, on the x axis
    soup.vertices_m.emplace_back(0.1 * i / kCuts, 0, 0);
  }
  const std::uint32_t back = kCuts + 1;
  soup.vertices_m.emplace_back(0.05, 0.1, 0.02);
  soup.vertices_m.emplace_back(0.05, 0.02, -0.1);
  for (std::uint32_t i = 0; i < kCuts; ++i) {
    soup.triangles.push_back({i, i + 1, back});  // many on one side
  }
  soup.triangles.push_back({kCuts, 0, back + 1});  // one on the other
  for (std::uint32_t i = 1; i < kCuts; ++i) {
    soup.triangles.push_back({0, i + 1, i});  // caps between
  }
  soup.triangles.push_back({0, back, back + 1});
  soup.triangles.push_back({kCuts, back + 1, back});
  const CompiledMesh mesh = compile_mesh(soup, {}, "caps");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.report.degenerate_dropped, kCuts - 1);
  EXPECT_EQ(mesh.report.open_edges, 0U);
  EXPECT_EQ(mesh.triangles.size(), 2 * kCuts + 2U);
}

TEST(CompileMesh, RepeatedFacesAreOne) {
  const TriangleSoup flat = sheet(0.1, 4);
  TriangleSoup holed = box_mesh({0.05, 0.05, 0.05}, 2);
  const std::size_t faces = holed.triangles.size();
  const TriangleSoup closed = holed;
  holed.triangles.pop_back();
  // Drawn from both sides, and one side twice; a body whose file has each face from both sides, but for one.
  const std::pair<TriangleSoup, std::size_t> cases[] = {
      {joined(flat, reversed(flat)), flat.triangles.size()},
      {joined(joined(flat, reversed(flat)), flat), flat.triangles.size()},
      {joined(closed, reversed(holed)), faces},
  };
  for (const auto& [soup, count] : cases) {
    const CompiledMesh mesh = compile_mesh(soup, {}, "repeated");
    EXPECT_EQ(unsound(mesh), "");
    EXPECT_EQ(mesh.triangles.size(), count);
    EXPECT_EQ(mesh.report.pierced_triangles, 0U);
    EXPECT_EQ(mesh.report.fins_cancelled, 0U);
  }
  // Once more in each winding, and again in the right one: the majority decides.
  TriangleSoup soup = closed;
  soup.triangles.insert(soup.triangles.begin(), reversed(closed).triangles[0]);
  soup.triangles.push_back(closed.triangles[0]);
  const CompiledMesh mesh = compile_mesh(soup, {}, "majority");
  EXPECT_EQ(mesh.triangles.size(), faces);
  EXPECT_EQ(mesh.report.open_edges, 0U);
  EXPECT_EQ(mesh.report.flipped_components, 0U);
}

// How often the soup goes round a point (van Oosterom and Strackee 1983): a face and its reverse add nothing.
double winding_number(const TriangleSoup& soup, const Vector3d& at) {
  double sum = 0;
  for (const auto& t : soup.triangles) {
    const Vector3d a = soup.vertices_m[t[0]] - at, b = soup.vertices_m[t[1]] - at,
                   c = soup.vertices_m[t[2]] - at;
    sum += std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                             b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return sum / (2.0 * std::numbers::pi);
}

TriangleSoup soup_of(const CompiledMesh& mesh) {
  TriangleSoup soup;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) soup.vertices_m.push_back(position(mesh, v));
  for (const auto& t : mesh.triangles)
    soup.triangles.push_back({control::vertex_of(t, 0), control::vertex_of(t, 1), control::vertex_of(t, 2)});
  return soup;
}

// Fins of one or more faces, in and out of a closed body, cancel, and the body stays closed: what is inside stays inside.
TEST(CompileMesh, FinsOfAClosedBodyCancel) {
  Random random(12);
  const TriangleSoup body = icosphere(1, 0.05);
  std::size_t fins = 0;
  for (int run = 0; run < 200; ++run) {
    TriangleSoup soup = body;
    std::vector<std::array<std::uint32_t, 2>> edges;
    for (const auto& t : body.triangles) edges.push_back({t[0], t[1]});
    const std::size_t count = 1 + random.below(12);
    for (std::size_t i = 0; i < count; ++i) {
      const auto [from, to] = edges[random.below(edges.size())];
      const auto tip = static_cast<std::uint32_t>(soup.vertices_m.size());
      const double out = 0.3 + 0.1 * static_cast<double>(random.below(12));
      soup.vertices_m.emplace_back(out * (soup.vertices_m[from] + soup.vertices_m[to]) / 2.0 +
                                   1e-4 * static_cast<double>(i + 1) * Vector3d(0.3, 0.5, 0.8));
      soup.triangles.push_back({from, to, tip});
      soup.triangles.push_back({to, from, tip});
      edges.push_back({to, tip});  // a fin may have fins
    }
    for (std::size_t i = soup.triangles.size(); i > 1; --i)
      std::swap(soup.triangles[i - 1], soup.triangles[random.below(i)]);
    const CompiledMesh mesh = compile_mesh(soup, {}, "fins");
    ASSERT_EQ(unsound(mesh), "");
    EXPECT_EQ(mesh.report.fins_cancelled, count);
    EXPECT_EQ(mesh.report.open_edges, 0U);
    EXPECT_EQ(mesh.report.non_manifold_edges, 0U);
    EXPECT_EQ(mesh.triangles.size(), body.triangles.size());
    const TriangleSoup compiled = soup_of(mesh);
    for (const double share : {0.1, 0.5, 0.9, 1.1, 1.5}) {
      const Vector3d at = share * 0.05 * Vector3d(0.36, 0.48, 0.8);
      EXPECT_NEAR(winding_number(compiled, at), winding_number(soup, at), 1e-5);
    }
    fins += count;
  }
  figure("fins cancelled, each body closed afterwards", static_cast<double>(fins), "all of them");
}

// What is attached to an open edge goes on from it: it is kept, as one layer.
TEST(CompileMesh, ASheetGoesOnWhereItsFileDrawsItFromBothSides) {
  TriangleSoup soup = sheet(0.1, 2);
  const std::size_t faces = soup.triangles.size();
  const auto tip = static_cast<std::uint32_t>(soup.vertices_m.size());
  soup.vertices_m.emplace_back(0.0, -0.08, 0.02);  // over the edge from the first vertex to the second
  soup.triangles.push_back({0, 1, tip});
  soup.triangles.push_back({1, 0, tip});
  const CompiledMesh mesh = compile_mesh(soup, {}, "flap");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_EQ(mesh.triangles.size(), faces + 1);
  EXPECT_EQ(mesh.report.fins_cancelled, 0U);
}

TEST(CompileMesh, CreasesStaySharpAndTheRestIsSmooth) {
  const CompiledMesh cube = compile_mesh(box_mesh({0.05, 0.05, 0.05}, 4), creased(40), "cube");
  for (std::uint32_t t = 0; t < cube.triangles.size(); ++t) {
    const auto corner = [&](std::uint16_t c) {
      return position(cube, control::vertex_of(cube.triangles[t], c));
    };
    const Vector3d normal = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    for (std::uint32_t c = 0; c < 3; ++c) {
      EXPECT_LT(angle_deg(normal, decoded(cube.corner_normals[3 * t + c])), 0.005);
    }
  }
  // 90 degrees is not sharper than 90: everything is rounded then, and a cube's corner looks along its
  // diagonal.
  const CompiledMesh round = compile_mesh(box_mesh({0.05, 0.05, 0.05}, 1), creased(90), "cube");
  for (std::uint32_t t = 0; t < round.triangles.size(); ++t) {
    for (std::uint16_t c = 0; c < 3; ++c) {
      const Vector3d p = position(round, control::vertex_of(round.triangles[t], c));
      EXPECT_LT(angle_deg(p, decoded(round.corner_normals[3 * t + c])), 0.005);
    }
  }
  EXPECT_TRUE(compile_mesh(box_mesh({0.05, 0.05, 0.05}, 1), {}, "faceted").corner_normals.empty());
}

TEST(CompileMesh, PseudonormalsTellInsideFromOutside) {
  // Baerentzen and Aanaes: the sign of (p - vertex) . pseudonormal is right wherever the vertex is the
  // nearest point.
  const CompiledMesh mesh = compile_mesh(tetrahedron({0, 0, 0}, 0.05), {}, "tetrahedron");
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const Vector3d normal = decoded(mesh.vertices[v].pseudonormal());
    EXPECT_GT(normal.dot(position(mesh, v) - Vector3d(0.01, 0.01, 0.01)), 0.0);
    if (position(mesh, v).norm() < 1e-9) {                // three right angles: weighted alike
      EXPECT_LT(angle_deg(normal, {-1, -1, -1}), 0.005);  // of octahedral.h
    }
  }
}

// An independent answer, in generic position: some edge of one passes through the other.
bool crosses_plainly(const std::array<Vector3d, 3>& a, const std::array<Vector3d, 3>& b) {
  const auto volume = [](const Vector3d& p, const Vector3d& q, const Vector3d& r, const Vector3d& s) {
    return (q - p).cross(r - p).dot(s - p);
  };
  const auto pierces = [&](const Vector3d& p, const Vector3d& q, const std::array<Vector3d, 3>& t) {
    if (volume(t[0], t[1], t[2], p) * volume(t[0], t[1], t[2], q) >= 0) return false;
    const double u = volume(p, q, t[0], t[1]);
    const double v = volume(p, q, t[1], t[2]);
    const double w = volume(p, q, t[2], t[0]);
    return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    if (pierces(a[i], a[(i + 1) % 3], b) || pierces(b[i], b[(i + 1) % 3], a)) return true;
  }
  return false;
}

TEST(CompileMesh, FlagsExactlyTheTrianglesThatCross) {
  Random random(11);
  std::size_t crossed = 0;
  for (int round = 0; round < 40; ++round) {
    TriangleSoup soup;
    for (std::uint32_t i = 0; i < 60; ++i) {
      const Vector3d at = random.in_box({0.05, 0.05, 0.05});
      for (int c = 0; c < 3; ++c) soup.vertices_m.push_back(at + random.in_box({0.02, 0.02, 0.02}));
      soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    const CompiledMesh mesh = compile_mesh(soup, {}, "soup");
    ASSERT_EQ(unsound(mesh), "");
    std::vector<std::array<Vector3d, 3>> corners;
    for (const scene::Triangle& t : mesh.triangles) {
      corners.push_back({position(mesh, control::vertex_of(t, 0)), position(mesh, control::vertex_of(t, 1)),
                         position(mesh, control::vertex_of(t, 2))});
    }
    for (std::size_t a = 0; a < corners.size(); ++a) {
      bool expected = false;
      for (std::size_t b = 0; b < corners.size() && !expected; ++b) {
        expected = a != b && crosses_plainly(corners[a], corners[b]);
      }
      EXPECT_EQ((mesh.flags[a] & static_cast<unsigned>(TriangleFlag::Pierced)) != 0, expected)
          << round << " " << a;
      crossed += expected ? 1U : 0U;
    }
  }
  figure("random triangles that cross, of 2400", static_cast<double>(crossed),
         "> 200, and the rest not flagged");
  EXPECT_GT(crossed, 200U);
}

TEST(CompileMesh, TouchingAndFoldedFacesCountAsCrossing) {
  const std::array<Vector3d, 3> a{Vector3d(0, 0, 0), Vector3d(1, 0, 0), Vector3d(0, 1, 0)};
  const auto cross = [&](const std::array<std::uint32_t, 3>& index, const std::array<Vector3d, 3>& at) {
    const bool one = host::triangles_cross({{0, 1, 2}, a}, {index, at}, 1e-7);
    EXPECT_EQ(one, host::triangles_cross({index, at}, {{0, 1, 2}, a}, 1e-7));
    return one;
  };
  const Vector3d up(0, 0, 1);
  EXPECT_TRUE(cross({3, 4, 5}, {Vector3d(0.2, 0.2, 5e-8), Vector3d(0.2, 0.2, 1),
                                Vector3d(0.5, 0.2, 1)}));  // a corner on the face
  EXPECT_FALSE(cross(
      {3, 4, 5}, {Vector3d(0.2, 0.2, 5e-7), Vector3d(0.2, 0.2, 1), Vector3d(0.5, 0.2, 1)}));  // just above it
  EXPECT_TRUE(cross(
      {3, 4, 5}, {Vector3d(0.1, 0.1, 0), Vector3d(2, 0.1, 0), Vector3d(0.1, 2, 0)}));  // overlap in a plane
  EXPECT_FALSE(cross({3, 4, 5}, {Vector3d(0.6, 0.6, 0), Vector3d(2, 0.6, 0),
                                 Vector3d(0.6, 2, 0)}));                           // beside it in the plane
  EXPECT_FALSE(cross({0, 4, 5}, {a[0], Vector3d(-1, 0, 0), Vector3d(0, -1, 0)}));  // a shared corner only
  EXPECT_TRUE(
      cross({0, 4, 5}, {a[0], Vector3d(1, 1, 0.5), Vector3d(1, 1, -0.5)}));  // and a crossing from there
  EXPECT_FALSE(cross({0, 1, 5}, {a[0], a[1], up}));                          // a shared edge only
  EXPECT_FALSE(cross({0, 1, 5}, {a[0], a[1], Vector3d(0, -1, 0)}));          // flat continuation
  EXPECT_TRUE(cross({0, 1, 5}, {a[0], a[1], Vector3d(0.4, 0.5, 0)}));        // folded onto itself
  EXPECT_TRUE(cross({0, 4, 5},
                    {a[0], Vector3d(0.5, 0.1, 0), Vector3d(0.1, 0.5, 0)}));  // overlap from a shared corner
}

TEST(CompileMesh, ManyTrianglesThroughOnePlaceEndInTime) {
  TriangleSoup soup;  // a bundle: every box meets every other one
  Random random(13);
  for (std::uint32_t i = 0; i < 20000; ++i) {
    const Vector3d end = random.direction() * 0.05;
    soup.vertices_m.push_back(end);
    soup.vertices_m.emplace_back(-end);
    soup.vertices_m.emplace_back(end + random.direction() * 0.001);
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const auto start = std::chrono::steady_clock::now();
  const CompiledMesh mesh = compile_mesh(soup, {}, "bundle");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_LT(figure("20 000 triangles through one place: seconds", seconds, "< 120"), 120.0);
}

TEST(CompileMesh, TheTreeIsNeverTooDeep) {
  TriangleSoup
      soup;  // sizes fall by a third from one to the next: the surface heuristic peels them off one by one
  double size = 5.0;
  for (std::uint32_t i = 0; i < 3000; ++i) {
    const Vector3d at(size, size, size);
    soup.vertices_m.push_back(at);
    soup.vertices_m.emplace_back(at + Vector3d(0.3 * size, 0, 0));
    soup.vertices_m.emplace_back(at + Vector3d(0, 0.3 * size, 0));
    soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    size = size > 2e-4 ? size / 1.05 : 5.0 - 1e-3 * i;
  }
  const CompiledMesh mesh = compile_mesh(soup, {}, "peel");
  EXPECT_EQ(unsound(mesh), "");
  EXPECT_LE(figure("a tree made to be deep: depth", mesh.depth, "<= 48"),
            static_cast<double>(control::kMaxBvhDepth));
}

TEST(CompileMesh, RefusesWhatCannotBeTouched) {
  TriangleSoup soup = tetrahedron({0, 0, 0}, 0.05);
  EXPECT_EQ(refusal({}), "empty-mesh");
  TriangleSoup bad = soup;
  bad.triangles[1][2] = 4;
  EXPECT_EQ(refusal(bad), "bad-vertex-index");
  bad = soup;
  bad.vertices_m[2].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal(bad), "bad-vertex");
  bad.vertices_m[2].y() = std::numeric_limits<double>::infinity();
  EXPECT_EQ(refusal(bad), "bad-vertex");
  bad.vertices_m[2].y() = 50.0;
  EXPECT_EQ(refusal(bad), "mesh-too-large");
  bad = soup;
  for (Vector3d& p : bad.vertices_m) p *= 1e-5;
  EXPECT_EQ(refusal(bad), "mesh-too-small");
  bad = soup;
  for (Vector3d& p : bad.vertices_m) p = Vector3d(p.x() + p.y() * 2 + p.z() * 3, 0, 0);
  EXPECT_EQ(refusal(bad), "empty-mesh");
  bad = soup;
  bad.triangles.assign(control::kMaxTriangles + 1, {0, 1, 2});
  EXPECT_EQ(refusal(bad), "too-many-triangles");
  bad = {};
  while (bad.vertices_m.size() <= control::kMaxVertices) {
    const auto at = static_cast<std::uint32_t>(bad.vertices_m.size());
    const std::uint32_t column = at / 3 % 600, row = at / 1800;
    const Vector3d from = 1e-4 * Vector3d(column, row, 0);
    for (const Vector3d& arm : {Vector3d(0, 0, 0), Vector3d(5e-5, 0, 0), Vector3d(0, 5e-5, 0)})
      bad.vertices_m.push_back(from + arm);
    bad.triangles.push_back({at, at + 1, at + 2});
  }
  EXPECT_EQ(refusal(bad), "too-many-vertices");
}

TEST(CompileMesh, AnySoupGivesASoundMeshOrAnError) {
  Random random(17);
  std::size_t compiled = 0;
  std::size_t refused = 0;
  constexpr int kRounds = 20000;
  for (int round = 0; round < kRounds; ++round) {
    TriangleSoup soup;
    const std::uint64_t vertices = 3 + random.below(12);
    const std::uint64_t grid =
        1 + random.below(4);  // few places: coincident, collinear and coplanar all the time
    for (std::uint64_t i = 0; i < vertices; ++i) {
      Vector3d p;
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        p[axis] = 0.01 * static_cast<double>(random.below(grid + 1)) +
                  (random.below(8) == 0 ? random.uniform(0, 4e-8) : 0.0);
      }
      soup.vertices_m.push_back(random.below(4) == 0 ? random.in_box({0.05, 0.05, 0.05}) : p);
    }
    const std::uint64_t triangles = random.below(30);
    for (std::uint64_t i = 0; i < triangles; ++i) {
      soup.triangles.push_back({static_cast<std::uint32_t>(random.below(vertices)),
                                static_cast<std::uint32_t>(random.below(vertices)),
                                static_cast<std::uint32_t>(random.below(vertices))});
    }
    MeshOptions options;
    options.side = static_cast<MeshSide>(random.below(3));
    if (random.below(2) == 0) options.crease_deg = random.uniform(0, 180);
    try {
      const CompiledMesh mesh = compile_mesh(soup, options, "soup");
      ASSERT_EQ(unsound(mesh), "") << "round " << round;
      ++compiled;
    } catch (const host::Error&) {
      ++refused;
    }
  }
  figure("random soups compiled to a sound mesh, of 20 000", static_cast<double>(compiled), "> 15 000");
  EXPECT_GT(compiled, 15000U);
  EXPECT_EQ(compiled + refused, static_cast<std::size_t>(kRounds));
}

}  // namespace
}  // namespace thimble::test
