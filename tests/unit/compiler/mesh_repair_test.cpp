// The repair of meshes: what is mutilated comes back closed, with the volume that it had.
#include "host-tools/compiler/mesh_repair.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "tests/support/figure.h"
#include "tests/support/meshes.h"

namespace thimble::test {
namespace {

using host::TriangleSoup;

// Judges by position, not by the compiler's indices: each directed edge against its reverse.
std::size_t unpaired_edges(const TriangleSoup& soup) {
  using Point = std::array<double, 3>;
  std::map<std::pair<Point, Point>, int> sum;
  const auto at = [&soup](std::uint32_t v) {
    const Eigen::Vector3d& p = soup.vertices_m[v];
    return Point{p.x(), p.y(), p.z()};
  };
  for (const auto& t : soup.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const Point a = at(t[e]);
      const Point b = at(t[(e + 1) % 3]);
      sum[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  return static_cast<std::size_t>(
      std::count_if(sum.begin(), sum.end(), [](const auto& s) { return s.second != 0; }));
}

double soup_volume_m3(const TriangleSoup& soup) {
  double sum = 0;
  for (const auto& t : soup.triangles) {
    sum += soup.vertices_m[t[0]].dot(soup.vertices_m[t[1]].cross(soup.vertices_m[t[2]])) / 6.0;
  }
  return sum;
}

bool same_soup(const TriangleSoup& a, const TriangleSoup& b) {
  return a.triangles == b.triangles && a.vertices_m == b.vertices_m;
}

// The generalized winding number (van Oosterom and Strackee 1983), in double.
double winding(const TriangleSoup& soup, const Eigen::Vector3d& p) {
  double sum = 0;
  for (const auto& t : soup.triangles) {
    const Eigen::Vector3d a = soup.vertices_m[t[0]] - p;
    const Eigen::Vector3d b = soup.vertices_m[t[1]] - p;
    const Eigen::Vector3d c = soup.vertices_m[t[2]] - p;
    sum += 2.0 * std::atan2(a.dot(b.cross(c)), a.norm() * b.norm() * c.norm() + a.dot(b) * c.norm() +
                                                   b.dot(c) * a.norm() + c.dot(a) * b.norm());
  }
  return sum / (4.0 * M_PI);
}

void add(TriangleSoup& soup, const TriangleSoup& given, const Eigen::Vector3d& at_m) {
  const TriangleSoup part = given;  // it may be the same
  const auto base = static_cast<std::uint32_t>(soup.vertices_m.size());
  for (const Eigen::Vector3d& p : part.vertices_m) soup.vertices_m.emplace_back(p + at_m);
  for (const auto& t : part.triangles) soup.triangles.push_back({t[0] + base, t[1] + base, t[2] + base});
}

TriangleSoup mutilated(const TriangleSoup& whole, std::mt19937_64& random, bool holes) {
  TriangleSoup soup;
  const auto chance = [&random](unsigned one_in) { return random() % one_in == 0; };
  for (const auto& t : whole.triangles) {
    const auto base = static_cast<std::uint32_t>(soup.vertices_m.size());
    for (const std::uint32_t v : t) soup.vertices_m.push_back(whole.vertices_m[v]);  // unwelded
    std::array<std::uint32_t, 3> face{base, base + 1, base + 2};
    if (chance(4)) std::swap(face[0], face[1]);
    soup.triangles.push_back(face);
    if (chance(20)) soup.triangles.push_back(face);
    if (chance(20)) soup.triangles.push_back({face[0], face[0], face[1]});
  }
  if (holes) {
    for (int i = 0; i < 5; ++i) {
      soup.triangles.erase(soup.triangles.begin() +
                           static_cast<std::ptrdiff_t>(random() % soup.triangles.size()));
    }
  }
  std::shuffle(soup.triangles.begin(), soup.triangles.end(), random);
  return soup;
}

TEST(MeshRepair, MutilatedBodiesComeBackWhole) {
  std::mt19937_64 random(1);
  const std::array<TriangleSoup, 3> wholes{icosphere(3, 0.05), box_mesh({0.1, 0.06, 0.04}, 6),
                                           torus(0.05, 0.02, 24, 12)};
  double worst_volume = 0;
  double worst_winding = 0;
  std::size_t holes = 0;
  for (int run = 0; run < 60; ++run) {
    const TriangleSoup& whole = wholes.at(static_cast<std::size_t>(run) % wholes.size());
    const TriangleSoup broken = mutilated(whole, random, run % 2 == 1);
    const host::RepairedMesh repaired = host::repair_mesh(broken, {0.05}, "broken");
    holes += repaired.report.holes_closed;
    EXPECT_EQ(unpaired_edges(repaired.soup), 0U) << run;
    EXPECT_EQ(repaired.report.after.open_edges, 0U) << run;
    worst_volume =
        std::max(worst_volume, std::abs(soup_volume_m3(repaired.soup) / soup_volume_m3(whole) - 1.0));
    std::uniform_real_distribution<double> place(-0.08, 0.08);
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d p(place(random), place(random), place(random));
      const double change = std::abs(winding(repaired.soup, p) - winding(whole, p));
      worst_winding = std::max(worst_winding, change < 0.5 ? change : 1.0);
    }
    EXPECT_TRUE(same_soup(host::repair_mesh(repaired.soup, {0.05}, "again").soup, repaired.soup)) << run;
  }
  EXPECT_GT(figure("holes closed", static_cast<double>(holes), "> 0"), 0.0);
  EXPECT_LT(figure("relative change of volume, worst", worst_volume, "< 0.001"), 0.001);
  EXPECT_LT(figure("change of the winding number at 1200 points, worst", worst_winding, "< 1e-5"), 1e-5);
}

TEST(MeshRepair, SaysWhatItLeaves) {
  TriangleSoup open = box_mesh({0.1, 0.1, 0.1}, 4);
  std::erase_if(open.triangles, [&](const auto& t) {
    return std::all_of(t.begin(), t.end(), [&](auto v) { return open.vertices_m[v].z() > 0.0499; });
  });
  const host::RepairReport left = host::repair_mesh(open, {0.14}, "open").report;
  EXPECT_EQ(left.holes_too_large, 1U);
  EXPECT_EQ(left.after.open_edges, 16U);
  const host::RepairedMesh closed = host::repair_mesh(open, {0.15}, "open");
  EXPECT_EQ(closed.report.holes_closed, 1U);
  EXPECT_EQ(closed.report.after.open_edges, 0U);
  EXPECT_NEAR(soup_volume_m3(closed.soup), 0.001, 1e-9);

  const host::RepairReport flat = host::repair_mesh(sheet(0.1, 4), {1.0}, "sheet").report;
  EXPECT_EQ(flat.outlines, 1U);
  EXPECT_EQ(flat.after.open_edges, 16U);

  TriangleSoup crossing = box_mesh({0.1, 0.1, 0.1}, 1);
  add(crossing, crossing, {0.03, 0.04, 0.02});
  const host::RepairedMesh kept = host::repair_mesh(crossing, {0.0, false}, "crossing");
  EXPECT_GT(kept.report.after.pierced_triangles, 0U);
  EXPECT_NEAR(soup_volume_m3(kept.soup), 0.002, 1e-9);
}

struct Resolution {
  std::string name;
  TriangleSoup soup;
  double volume_m3;
  std::size_t parts;
};

// The volume of the outer surface in closed form, no face that still touches another, and where the parts wind around a point
// at least once, the result winds around it once.
TEST(MeshRepair, CrossingPartsBecomeTheirOuterSurface) {
  const auto box = [](int cells) { return box_mesh({0.1, 0.1, 0.1}, cells); };
  const auto pair = [](TriangleSoup a, const TriangleSoup& b, const Eigen::Vector3d& at_m) {
    add(a, b, at_m);
    return a;
  };
  TriangleSoup cavity = icosphere(2, 0.02);
  for (auto& t : cavity.triangles) std::swap(t[0], t[1]);
  const double ball = soup_volume_m3(icosphere(3, 0.05));
  const double hollow = soup_volume_m3(icosphere(2, 0.02));
  TriangleSoup grid;  // 27 boxes, each flush with or through its neighbours
  for (int i = 0; i < 27; ++i) add(grid, box(1 + i % 2), {0.1 * (i % 3), 0.07 * (i / 3 % 3), 0.05 * (i / 9)});
  const Resolution cases[] = {
      {"overlapping", pair(box(1), box(1), {0.03, 0.04, 0.02}), 0.002 - 0.07 * 0.06 * 0.08, 1},
      {"flush, unlike faces", pair(box(3), box(2), {0.1, 0.03, 0.0}), 0.002, 1},
      {"level tops", pair(box(3), box(2), {0.05, 0.0, 0.0}), 0.0015, 1},
      {"one in another, flush at the bottom", pair(box(3), box_mesh({0.05, 0.05, 0.05}, 2), {0, 0, -0.025}),
       0.001, 1},
      {"one inside another", pair(icosphere(3, 0.05), icosphere(2, 0.02), {0.01, 0.01, 0.01}), ball, 1},
      {"a cavity", pair(icosphere(3, 0.05), cavity, {0.01, 0.01, 0.01}), ball - hollow, 2},
      {"a grid of boxes", grid, 0.3 * 0.24 * 0.2, 1},
      // Where the tube passes the axis it winds around nothing: a cavity.
      {"a tube through itself", torus(0.03, 0.031, 24, 13), -1.0, 2},
  };
  std::mt19937_64 random(2);
  std::size_t wrong = 0;
  std::size_t tried = 0;
  for (const Resolution& c : cases) {
    const host::RepairedMesh resolved = host::repair_mesh(c.soup, {}, c.name);
    if (c.volume_m3 > 0) {
      EXPECT_NEAR(figure(c.name + ": volume, m^3", soup_volume_m3(resolved.soup), "closed form, 1e-6 of it"),
                  c.volume_m3, 1e-6 * c.volume_m3);
    }
    EXPECT_EQ(unpaired_edges(resolved.soup), 0U) << c.name;
    EXPECT_EQ(resolved.report.after.pierced_triangles, 0U) << c.name;
    EXPECT_EQ(resolved.report.after.components, c.parts) << c.name;
    EXPECT_TRUE(same_soup(host::repair_mesh(resolved.soup, {}, "again").soup, resolved.soup)) << c.name;
    const TriangleSoup given = host::repair_mesh(c.soup, {0.0, false}, c.name).soup;
    std::uniform_real_distribution<double> place(-0.08, 0.28);
    for (int i = 0; i < 400; ++i, ++tried) {
      const Eigen::Vector3d p(place(random), place(random), place(random));
      wrong += (winding(given, p) > 0.5) != (winding(resolved.soup, p) > 0.5) ? 1U : 0U;
      EXPECT_LT(std::abs(winding(resolved.soup, p) - 0.5), 0.5 + 1e-5) << c.name;
    }
  }
  EXPECT_EQ(figure("points on the wrong side, of " + std::to_string(tried), static_cast<double>(wrong), "0"),
            0.0);
}

// Many balls through each other, on no grid: what is left to touch is counted.
TEST(MeshRepair, AHeapOfBallsBecomesItsOuterSurface) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-0.03, 0.03);
  TriangleSoup heap;
  for (int i = 0; i < 8; ++i) add(heap, icosphere(2, 0.02), {place(random), place(random), place(random)});
  const host::RepairedMesh resolved = host::repair_mesh(heap, {}, "heap");
  EXPECT_EQ(unpaired_edges(resolved.soup), 0U);
  EXPECT_LE(figure("heap of balls: faces that still touch",
                   static_cast<double>(resolved.report.after.pierced_triangles), "< 1 % of those before"),
            0.01 * static_cast<double>(resolved.report.before.pierced_triangles));
  std::size_t wrong = 0;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(place(random), place(random), place(random));
    wrong += (winding(heap, p) > 0.5) != (winding(resolved.soup, p) > 0.5) ? 1U : 0U;
  }
  EXPECT_EQ(figure("heap of balls: points of 2000 on the wrong side", static_cast<double>(wrong), "0"), 0.0);
}

}  // namespace
}  // namespace thimble::test
