// Mesh files: the .plg reader with its dialects and refusals, and formats read by assimp.
#include "host-tools/compiler/mesh_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <clocale>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/compiler/plg.h"
#include "host-tools/compiler/polygon.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/random.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/compiler/refusal.h"
#include "tests/unit/compiler/sound_mesh.h"

namespace thimble::test {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using host::TriangleSoup;
using testing::HasSubstr;

constexpr const char* kTetrahedron =
    "pyramid 4 4\n"
    "0 0 0\n100 0 0\n0 100 0\n0 0 100\n"
    "1 3 0 1 2\n1 3 0 3 1\n1 3 0 2 3\n1 3 1 3 2\n";

Refusal plg_refusal(const std::string& text) {
  return refusal_of([&] { static_cast<void>(host::read_plg(text, "x.plg")); });
}

Refusal file_refusal(const fs::path& file) {
  return refusal_of([&] { static_cast<void>(host::read_mesh_file(file, 1.0, "the mesh")); });
}

TEST(Plg, ReadsAndMirrors) {
  const TriangleSoup soup = host::read_plg(kTetrahedron, "x.plg");
  ASSERT_EQ(soup.vertices_m.size(), 4U);
  ASSERT_EQ(soup.triangles.size(), 4U);
  EXPECT_EQ(soup.vertices_m[3], Vector3d(0, 0, -100));  // left-handed: z turns round
  EXPECT_EQ(soup.triangles[0], (std::array<std::uint32_t, 3>{0, 1, 2}));
}

TEST(Plg, UnderstandsEveryDialect) {
  const std::string text =
      "\xEF\xBB\xBF# made by hand\r\n"
      "; another comment\r\n"
      "* and a third\r\n"
      "\r\n"
      "house 5 8 ignored tokens 1 2 3\r\n"
      "0.0 0 0 0 1 0 # with a normal\r\n"
      "+1.5e2 0 0\r\n"
      "\t0,100,0\r\n"
      "   0 0 100 ; the top\r\n"
      "-.5 -5. 1E1\r\n"
      "0x11FF 3 0 1 2 extra tokens\r\n"
      "0X00ff 3 0 3 1\r\n"
      "indexed_12 3 0 2 3\r\n"
      "shaded_3_100 3 1 3 2\r\n"
      "metal_1_20 2 0 1\r\n"
      "glass_2_3 1 4\r\n"
      "-1 4 0 1 2 3\r\n"
      "16 3 0 1 4";
  const TriangleSoup soup = host::read_plg(text, "x.plg");
  EXPECT_EQ(soup.vertices_m.size(), 5U);
  EXPECT_EQ(soup.triangles.size(), 7U);  // the facets of one and two points are gone, the quad is two
  EXPECT_EQ(soup.vertices_m[1], Vector3d(150, 0, 0));
  EXPECT_EQ(soup.vertices_m[4], Vector3d(-0.5, -5, -10));
}

TEST(Plg, MergesObjectsAndTakesTheFinestLevelOfDetail) {
  const std::string coarse = "one 3 1\n0 0 0\n1 0 0\n0 1 0\n5 3 0 1 2\n";
  EXPECT_EQ(host::read_plg(coarse + kTetrahedron, "x.plg").triangles.size(), 5U);
  EXPECT_EQ(host::read_plg(coarse + kTetrahedron, "x.plg").triangles[1][0], 3U);
  for (const char* mark : {"#MULTI\n", "##MULTI\n"}) {
    EXPECT_EQ(host::read_plg(mark + coarse + kTetrahedron, "x.plg").triangles.size(), 4U);
    EXPECT_EQ(host::read_plg(mark + std::string(kTetrahedron) + coarse, "x.plg").triangles.size(), 4U);
  }
}

TEST(Plg, NumbersAreTheSameInEveryLocale) {
  const TriangleSoup before = host::read_plg("a 3 1\n1.5 0 0\n0 2.25 0\n0 0 1e-3\n1 3 0 1 2\n", "x.plg");
  bool changed = false;
  for (const char* locale : {"de_DE.UTF-8", "de_DE.utf8", "fr_FR.UTF-8", "C.UTF-8"}) {
    changed = changed || std::setlocale(LC_ALL, locale) != nullptr;
  }
  const TriangleSoup after = host::read_plg("a 3 1\n1.5 0 0\n0 2.25 0\n0 0 1e-3\n1 3 0 1 2\n", "x.plg");
  std::setlocale(LC_ALL, "C");
  EXPECT_TRUE(changed);
  EXPECT_EQ(before.vertices_m, after.vertices_m);
}

TEST(Plg, RefusesOtherProgramsFilesClearly) {
  for (const char* text : {"<html>\n<body>\n<pre>\n<h1>Build Log</h1>\n", "<?xml version=\"1.0\"?>\n<plg/>\n",
                           "\n  <HTML>", "\xEF\xBB\xBF<html>"}) {
    const Refusal refused = plg_refusal(text);
    EXPECT_EQ(refused.name, "not-a-rend386-plg") << text;
    EXPECT_THAT(refused.cause, HasSubstr("HTML or XML"));
  }
  EXPECT_EQ(plg_refusal(std::string("PLG\0\1\2", 6)).name, "not-a-rend386-plg");
}

TEST(Plg, ErrorsNameTheLine) {
  const auto expect = [](const std::string& text, const std::string& name, const std::string& part) {
    const Refusal refused = plg_refusal(text);
    EXPECT_EQ(refused.name, name) << text;
    EXPECT_THAT(refused.cause, HasSubstr(part)) << text;
  };
  expect("", "empty-mesh", "x.plg: ");
  expect("# nothing\n", "empty-mesh", "no facet");
  expect("a 3 0\n0 0 0\n1 0 0\n0 1 0\n", "empty-mesh", "no facet");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\n1 2 0 1\n", "empty-mesh", "no facet");
  expect("hello\n", "bad-plg", "x.plg:1: expected an object's header");
  expect("a three 1\n", "bad-plg", "x.plg:1: ");
  expect("a -3 1\n", "bad-plg", "x.plg:1: ");
  expect("a 3 1\n0 0 0\n\n# more\n1 x 0\n", "bad-plg",
         "x.plg:5: vertex 1 of 3: expected three numbers, found \"x\"");
  expect("a 3 1\n0 0\n", "bad-plg", "x.plg:2: vertex 0 of 3");
  expect("a 3 1\n0 0 nan\n", "bad-plg", "x.plg:2: ");
  expect("a 3 1\n0 0 1e999\n", "bad-plg", "x.plg:2: ");
  expect("a 3 1\n0 0 0\n", "bad-plg", "the file ends at vertex 1 of 3");
  expect("a 4000000000 4000000000\n0 0 0\n", "bad-plg", "the file ends at vertex 1 of 4000000000");
  expect("a 3 2\n0 0 0\n1 0 0\n0 1 0\n1 3 0 1 2\n", "bad-plg", "the file ends at facet 1 of 2");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\n1 3 0 1 3\n", "bad-plg",
         "x.plg:5: facet 0 of 1: vertex \"3\" does not exist");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\n1 3 0 1\n", "bad-plg", "3 points announced, 2 given");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\nred 3 0 1 2\n", "bad-plg", "expected a colour");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\n0xZZ 3 0 1 2\n", "bad-plg", "expected a colour");
  expect("a 3 1\n0 0 0\n1 0 0\n0 1 0\n1 5000 0 1 2\n", "bad-plg", "1 to 4096");
}

TEST(Plg, BrokenBytesNeverDoMoreThanFail) {
  const std::string text = kTetrahedron;
  Random random(23);
  std::size_t refused = 0;
  constexpr int kRounds = 20000;
  for (int round = 0; round < kRounds; ++round) {
    std::string changed = text.substr(0, round % 4 == 0 ? random.below(text.size()) : text.size());
    for (std::uint64_t i = random.below(4); i > 0 && !changed.empty(); --i) {
      changed[random.below(changed.size())] =
          static_cast<char>(random.below(2) == 0 ? '0' + random.below(10) : random.below(256));
    }
    refused += plg_refusal(changed).name != "nothing refused" ? 1U : 0U;
  }
  figure("spoilt .plg files refused, of 20 000", static_cast<double>(refused), "> 5000, and none does harm");
  EXPECT_GT(refused, 5000U);
}

TEST(Polygon, ConcaveOnesKeepTheirArea) {
  TriangleSoup soup;
  soup.vertices_m = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {3, 4, 0},
                     {3, 1, 0}, {1, 1, 0}, {1, 4, 0}, {0, 4, 0}};  // a U
  host::append_polygon({0, 1, 2, 3, 4, 5, 6, 7}, soup);
  ASSERT_EQ(soup.triangles.size(), 6U);
  double area = 0;
  for (const auto& t : soup.triangles) {
    const Vector3d normal =
        (soup.vertices_m[t[1]] - soup.vertices_m[t[0]]).cross(soup.vertices_m[t[2]] - soup.vertices_m[t[0]]);
    EXPECT_GT(normal.z(), 0.0);
    area += normal.z() / 2.0;
  }
  EXPECT_DOUBLE_EQ(area, 10.0);
  TriangleSoup dart;
  dart.vertices_m = {{0, 0, 0}, {2, 0, 0}, {0.5, 0.5, 0}, {0, 2, 0}};
  host::append_polygon({0, 1, 2, 3}, dart);
  ASSERT_EQ(dart.triangles.size(), 2U);
  for (const auto& t : dart.triangles) {
    EXPECT_GT((dart.vertices_m[t[1]] - dart.vertices_m[t[0]])
                  .cross(dart.vertices_m[t[2]] - dart.vertices_m[t[0]])
                  .z(),
              0.0);
  }
  TriangleSoup flat;
  flat.vertices_m.assign(4096, Vector3d::Zero());
  std::vector<std::uint32_t> all(4096);
  for (std::uint32_t i = 0; i < 4096; ++i) all[i] = i;
  host::append_polygon(all, flat);  // no ear anywhere: still ends
  EXPECT_EQ(flat.triangles.size(), 4094U);
}

TEST(MeshFile, ObjComesThroughAndScales) {
  const TemporaryFolder folder;
  const TriangleSoup sphere = icosphere(3, 0.05);
  for (const double units_per_m : {1.0, 10.0, 1000.0}) {
    const fs::path file = folder.path() / "sphere.obj";
    write_obj(sphere, units_per_m, file);
    const TriangleSoup soup = host::read_mesh_file(file, 1.0 / units_per_m, "sphere");
    EXPECT_EQ(soup.triangles.size(), sphere.triangles.size());
    const host::CompiledMesh mesh = host::compile_mesh(soup, {}, "sphere");
    EXPECT_EQ(unsound(mesh), "");
    EXPECT_EQ(mesh.vertices.size(), sphere.vertices_m.size());
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      EXPECT_NEAR(position(mesh, v).norm(), 0.05, 1e-8);
    }
  }
}

TEST(MeshFile, NodeTransformsArePlacedAndMirrorsRewound) {
  const TemporaryFolder folder;
  const std::string collada = R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array>
<technique_common><accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><translate>10 0 0</translate>
<node id="n1"><scale>-2 2 2</scale><instance_geometry url="#g"/></node>
<node id="n2"><translate>5 0 0</translate><instance_geometry url="#g"/></node></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  const TriangleSoup soup = host::read_mesh_file(folder.write("two.dae", collada), 0.01, "two");
  ASSERT_EQ(soup.triangles.size(), 8U);
  double volume = 0;
  Vector3d low = soup.vertices_m[0];
  Vector3d high = low;
  for (const Vector3d& p : soup.vertices_m) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  for (const auto& t : soup.triangles) {
    volume += soup.vertices_m[t[0]].dot(soup.vertices_m[t[1]].cross(soup.vertices_m[t[2]])) / 6.0;
  }
  EXPECT_NEAR(low.x(), 0.08, 1e-8);
  EXPECT_NEAR(high.x(), 0.16, 1e-8);
  EXPECT_NEAR(volume, (8.0 + 1.0) / 6.0 * 1e-6, 1e-12);  // both wound outwards, the mirrored one too
}

TEST(MeshFile, ErrorsAreClear) {
  const TemporaryFolder folder;
  EXPECT_EQ(file_refusal(folder.path() / "no.obj").name, "missing-mesh");
  EXPECT_THAT(file_refusal(folder.path() / "no.obj").cause, HasSubstr("there is no such file"));
  EXPECT_EQ(file_refusal(folder.path()).name, "missing-mesh");
  EXPECT_EQ(file_refusal(folder.write("empty.obj", "")).name, "unreadable-mesh");
  EXPECT_EQ(file_refusal(folder.write("empty.stl", "")).name, "unreadable-mesh");
  EXPECT_EQ(file_refusal(folder.write("noface.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")).name, "empty-mesh");
  EXPECT_EQ(file_refusal(folder.write("lines.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n")).name, "empty-mesh");
  EXPECT_EQ(file_refusal(folder.write("x.xyz123", "hello")).name, "unreadable-mesh");
  EXPECT_EQ(file_refusal(folder.write("log.PLG", "<html></html>")).name, "not-a-rend386-plg");
  EXPECT_EQ(file_refusal(folder.write("page.stl", "<html></html>")).name, "unreadable-mesh");
  EXPECT_THAT(file_refusal(folder.write("huge.off", "OFF\n353535235358 6 0\n0 0 0\n")).cause,
              HasSubstr("the header announces 353535235358 elements"));
  EXPECT_THAT(file_refusal(folder.write("huge.ply",
                                        "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                                        "end_header\n"))
                  .cause,
              HasSubstr("the header announces 4000000000 elements"));
  EXPECT_THAT(
      file_refusal(folder.write("endless.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"))
          .cause,
      HasSubstr("no \"end_header\""));
  EXPECT_EQ(file_refusal(
                folder.write("strips.ply",
                             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                             "property float z\nelement tristrips 1\nproperty list int int vertex_indices\n"
                             "end_header\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n4 0 1 2 3\n"))
                .name,
            "triangle-strips");
  // Coordinates may be as large as they like.
  EXPECT_EQ(host::read_mesh_file(
                folder.write("far.off", "OFF 3 1 0\n0 0 0\n900000 0 0\n0 900000 0\n3 0 1 2\n"), 1e-6, "far")
                .triangles.size(),
            1U);
  const Refusal bin = file_refusal(test_model_path("glTF2/MissingBin/BoxTextured.gltf"));
  EXPECT_EQ(bin.name, "unreadable-mesh");
  EXPECT_THAT(bin.cause, HasSubstr("BoxTextured0.bin"));
}

}  // namespace
}  // namespace thimble::test
