// Scene files: what is read, every error with its position, required keys, the image.
#include "host-tools/compiler/scene_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/compiler/refusal.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test::scene_file {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::HasSubstr;

const fs::path kSource = THIMBLE_SOURCE_DIR;

// Every key the format has, one object a line.
constexpr const char* kScene = R"({
"$schema": "scene.schema.json",
"thimble_scene": 1,
"name": "everything",
"description": "one of each",
"materials": {
"ice": { "stiffness_N_m": 1000 },
"skin": { "stiffness_N_m": 300, "damping_N_s_m": 1.5, "static_friction": 0.8, "dynamic_friction": 0.5, "friction_mode": "steady" }
},
"objects": [
{ "name": "floor", "shape": { "plane": { "normal": [0, 0, 2], "offset_m": -0.05 } }, "material": "ice" },
{ "name": "ball", "shape": { "sphere": { "radius_m": 0.02 } }, "material": "skin", "pose": { "position_m": [0.1, 0.2, 0.3] } },
{ "name": "crate", "shape": { "box": { "size_m": [0.02, 0.04, 0.06] } }, "material": { "stiffness_N_m": 500, "static_friction": 0.3 },
  "pose": { "position_m": [0, 0, 0], "rotation_deg": [0, 0, 90] } },
{ "name": "can", "shape": { "cylinder": { "radius_m": 0.01, "height_m": 0.05 } }, "material": "ice" },
{ "name": "pill", "shape": { "capsule": { "radius_m": 0.01, "height_m": 0.05 } }, "material": "ice" },
{ "name": "hat", "shape": { "cone": { "radius_m": 0.01, "height_m": 0.04 } }, "material": "ice" },
{ "name": "rock", "shape": { "mesh": { "file": "asteroid.plg", "scale": 1e-5, "crease_deg": 30, "side": "outside" } }, "material": "ice" },
{ "name": "phone", "shape": { "height_field": { "file": "../telephone/heights_mm.csv", "size_m": [0.15, 0.12], "height_m": 0.001, "thickness_m": 0.02, "crease_deg": 40 } }, "material": "ice" }
]
})";

const fs::path kAsteroid = kSource / "scenes" / "asteroid";

std::string with(const std::string& from, const std::string& to) { return replaced(kScene, from, to); }

Refusal refusal(const std::string& text) { return refusal_of_scene(text, kAsteroid); }

TEST(SceneFile, ReadsEveryKeyIntoTheImage) {
  const host::CompiledScene compiled = host::compile_scene_text(kScene, "test.scene.json", kAsteroid);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(compiled.image.data()) % 16, 0U);
  control::SceneView view;
  ASSERT_STREQ(control::name(control::SceneView::check(compiled.image, view)),
               control::name(control::ImageStatus::kOk));
  const scene::Scene& scene = *view.scene();
  EXPECT_EQ(scene.name()->str(), "everything");
  ASSERT_EQ(scene.objects()->size(), 8U);
  const auto& objects = *scene.objects();

  EXPECT_EQ(objects[0]->name()->str(), "floor");
  EXPECT_EQ(objects[0]->shape_as_Plane()->normal().z(), 1.0F);
  EXPECT_EQ(objects[0]->shape_as_Plane()->offset_m(), -0.05F);
  EXPECT_EQ(objects[0]->pose()->rotation().w(), 1.0F);

  EXPECT_EQ(objects[1]->shape_as_Sphere()->radius_m(), 0.02F);
  EXPECT_EQ(objects[1]->pose()->position_m().y(), 0.2F);
  const host::SceneFile file = host::read_scene_file(kScene, "test.scene.json");
  EXPECT_EQ(file.objects[1].material.stiffness_N_m, 300);
  EXPECT_EQ(file.objects[1].material.damping_N_s_m, 1.5);
  EXPECT_EQ(file.objects[1].material.static_friction, 0.8);
  EXPECT_EQ(file.objects[1].material.dynamic_friction, 0.5);
  EXPECT_EQ(objects[1]->material()->friction_mode(), scene::FrictionMode::Steady);
  EXPECT_EQ(objects[0]->material()->friction_mode(), scene::FrictionMode::StickSlip);
  EXPECT_EQ(file.objects[2].material.dynamic_friction, 0.3);  // static's, when only that is given
  EXPECT_EQ(file.objects[0].material.damping_N_s_m, 0);

  EXPECT_EQ(objects[2]->shape_as_Box()->half_size_m().z(), 0.03F);
  EXPECT_NEAR(objects[2]->pose()->rotation().w(), std::sqrt(0.5), 1e-7);
  EXPECT_NEAR(objects[2]->pose()->rotation().z(), std::sqrt(0.5), 1e-7);
  EXPECT_EQ(objects[3]->shape_as_Cylinder()->half_height_m(), 0.025F);
  EXPECT_EQ(objects[4]->shape_as_Capsule()->half_height_m(), 0.025F);
  EXPECT_EQ(objects[5]->shape_as_Cone()->radius_m(), 0.01F);
  EXPECT_EQ(objects[5]->shape_as_Cone()->height_m(), 0.04F);
  EXPECT_EQ(objects[6]->shape_as_Mesh()->triangles()->size(), 320U);
  EXPECT_EQ(objects[6]->shape_as_Mesh()->corner_normals()->size(), 960U);

  // A 76 x 76 grid: its points, those of its rim again below, and the triangles of top, walls and bottom.
  const scene::Mesh& phone = *objects[7]->shape_as_Mesh();
  EXPECT_EQ(phone.vertices()->size(), 76U * 76U + 4U * 75U + 8U);
  EXPECT_EQ(phone.triangles()->size(), 2U * 75U * 75U + 8U * 75U + 4U * 75U - 2U + 16U);
  EXPECT_EQ(phone.corner_normals()->size(), 3U * phone.triangles()->size());
  EXPECT_EQ(compiled.report.objects[7].shape, "height_field");
  EXPECT_EQ(compiled.report.objects[7].mesh.open_edges, 0U);
  EXPECT_EQ(compiled.report.objects[7].mesh.flipped_components, 0U);

  EXPECT_EQ(compiled.report.objects[6].shape, "mesh");
  EXPECT_EQ(compiled.report.objects[6].mesh.triangles, 320U);
  EXPECT_EQ(compiled.report.bytes, compiled.image.size());
  EXPECT_THAT(compiled.report.warnings, testing::IsEmpty());
}

TEST(SceneFile, RotationsAreRollPitchYawAboutFixedAxes) {
  const std::string text = with("\"rotation_deg\": [0, 0, 90]", "\"rotation_deg\": [90, 0, 90]");
  const Eigen::Quaterniond q = host::read_scene_file(text, "t").objects[2].rotation;
  // x first: y goes to z; then z by 90 degrees leaves it there, and x goes to y.
  EXPECT_LT((q * Eigen::Vector3d::UnitY() - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((q * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(SceneFile, TheSameInputGivesTheSameBytes) {
  EXPECT_EQ(host::compile_scene_text(kScene, "a", kAsteroid).image,
            host::compile_scene_text(kScene, "b", kAsteroid).image);
}

TEST(SceneFile, EveryErrorSaysWhereWhatAndWhatIsAllowed) {
  struct Case {
    std::string text;
    std::string name;
    std::vector<std::string> parts;  // of the cause
  };
  const auto at = [](int line, const std::string& rest) {
    return "test.scene.json:" + std::to_string(line) + ": " + rest;
  };
  std::string many = R"({"thimble_scene": 1, "name": "many", "objects": [)";
  for (std::size_t i = 0; i <= control::kMaxObjects; ++i) {
    many += std::string(i == 0 ? "" : ",") + R"({"name": "o)" + std::to_string(i) +
            R"(", "shape": {"sphere": {"radius_m": 0.01}}, "material": {"stiffness_N_m": 1}})";
  }
  many += "]}";
  const std::vector<Case> cases{
      // Not JSON.
      {"", "bad-json", {at(1, "")}},
      {"{\n\"name\": \"x\",\n]", "bad-json", {at(3, "")}},
      {with("\"radius_m\": 0.02", "\"radius_m\": NaN"), "bad-json", {at(12, "")}},
      {with("\"radius_m\": 0.02", "\"radius_m\": 1e999"), "bad-json", {at(12, ""), "1e999"}},
      {with("everything", "\xFF\xFE"), "bad-json", {at(4, ""), "UTF-8"}},
      {std::string("\xFF\xFE{\0", 4), "bad-json", {at(1, "")}},
      {with("everything", "everything") + std::string("\0}}]{\"a\":[1,2", 13), "bad-json", {"NUL"}},
      {std::string(100, '['), "bad-json", {"nested deeper than 32"}},
      {"{\n\"" + std::string(1000, 'k') + "\": [1, 2]}",
       "bad-json",
       {at(2, ""), "1001 bytes", "at most 256"}},
      {std::string((std::size_t{1} << 20U) + 1, ' '), "scene-file-too-large", {"1048577 bytes", "1048576"}},
      {with("\"name\": \"ball\"", "\"name\": \"ball\", \"name\": \"b\""),
       "duplicate-key",
       {at(12, "/objects/1/name is given twice (first in line 12)")}},
      {with("\"skin\":", "\"ice\":"),
       "duplicate-key",
       {at(8, "/materials/ice is given twice (first in line 7)")}},
      // The whole.
      {"[]", "bad-value", {at(1, "the scene is [], allowed is an object")}},
      {with("\"thimble_scene\": 1", "\"thimble_scene\": 2"),
       "wrong-version",
       {at(3, "/thimble_scene is 2"), "version 1"}},
      {with("\"thimble_scene\": 1", "\"thimble_scene\": \"1\""),
       "wrong-version",
       {at(3, "/thimble_scene is \"1\"")}},
      {with("\"thimble_scene\": 1,", ""), "missing-key", {at(1, "the scene has no \"thimble_scene\"")}},
      {with("\"name\": \"everything\",", ""), "missing-key", {"has no \"name\""}},
      {with("\"everything\"", "7"), "bad-value", {at(4, "/name is 7, allowed is a string")}},
      {with("\"everything\"", "\"\""), "bad-value", {at(4, "/name is \"\"")}},
      {R"({"thimble_scene": 1, "name": "x"})", "missing-key", {"has no \"objects\""}},
      {R"({"thimble_scene": 1, "name": "x", "objects": {}})",
       "bad-value",
       {"/objects is {}, allowed is an array"}},
      {many, "too-many-objects", {"/objects has 65 objects, at most 64"}},
      // Unknown keys.
      {with("\"materials\"", "\"material\""),
       "unknown-key",
       {at(6, "/material is not a key"), "did you mean \"materials\"?"}},
      {with("\"radius_m\": 0.02", "\"radius\": 0.02"),
       "unknown-key",
       {at(12, "/objects/1/shape/sphere/radius is not a key of a sphere"), "did you mean \"radius_m\"?"}},
      {with("\"stiffness_N_m\": 300", "\"stiffness\": 300"),
       "unknown-key",
       {at(8, "/materials/skin/stiffness"), "did you mean \"stiffness_N_m\"?"}},
      {with("\"pose\": { \"position_m\"", "\"pose\": { \"zzz/~\""),
       "unknown-key",
       {at(12, "/objects/1/pose/zzz~1~0"), "allowed: "}},
      {with("\"sphere\": {", "\"spheer\": {"), "unknown-key", {"did you mean \"sphere\"?"}},
      // Objects.
      {with("\"name\": \"pill\"", "\"name\": \"can\""),
       "repeated-name",
       {at(16, "/objects/4/name is \"can\"")}},
      {with("\"name\": \"pill\", ", ""), "missing-key", {at(16, "/objects/4 has no \"name\"")}},
      {with("{ \"name\": \"pill\"", "7, { \"name\": \"pill\""), "bad-value", {at(16, "/objects/4 is 7")}},
      {with("\"shape\": { \"sphere\": { \"radius_m\": 0.02 } }, ", ""),
       "missing-key",
       {"/objects/1 has no \"shape\""}},
      {with("\"sphere\": { \"radius_m\": 0.02 }", ""),
       "bad-value",
       {"/objects/1/shape is {}", "exactly one of"}},
      {with("\"sphere\": { \"radius_m\": 0.02 }", "\"sphere\": { \"radius_m\": 0.02 }, \"box\": {}"),
       "bad-value",
       {"exactly one of"}},
      {with("\"sphere\": { \"radius_m\": 0.02 }", "\"sphere\": 0.02"),
       "bad-value",
       {"/objects/1/shape/sphere is 0.02"}},
      // Shapes.
      {with("[0, 0, 2]", "[0, 0, 0]"),
       "bad-value",
       {at(11, "/objects/0/shape/plane/normal is [0,0,0]"), "any length but zero"}},
      {with("[0, 0, 2]", "[0, 2]"), "bad-value", {"normal is [0,2], allowed is an array of three numbers"}},
      {with("[0, 0, 2]", "[0, 0, \"up\"]"), "bad-value", {"/objects/0/shape/plane/normal/2 is \"up\""}},
      {with("\"offset_m\": -0.05", "\"offset_m\": 11"),
       "bad-value",
       {"offset_m is 11, allowed is a number from -10.0 to 10.0 m"}},
      {with("\"radius_m\": 0.02", "\"radius_m\": -0.02"),
       "bad-value",
       {at(12, "/objects/1/shape/sphere/radius_m is -0.02")}},
      {with("\"radius_m\": 0.02", "\"radius_m\": 0"),
       "bad-value",
       {"radius_m is 0, allowed is a number from 1e-05 to 10.0 m"}},
      {with("\"radius_m\": 0.02", "\"radius_m\": null"), "bad-value", {"radius_m is null"}},
      {with("{ \"radius_m\": 0.02 }", "{}"), "missing-key", {"/objects/1/shape/sphere has no \"radius_m\""}},
      {with("[0.02, 0.04, 0.06]", "[0.02, 0, 0.06]"), "bad-value", {"/objects/2/shape/box/size_m/1 is 0"}},
      {with("\"cylinder\": { \"radius_m\": 0.01, ", "\"cylinder\": { "),
       "missing-key",
       {"/objects/3/shape/cylinder has no"}},
      {with("\"capsule\": { \"radius_m\": 0.01, \"height_m\": 0.05",
            "\"capsule\": { \"radius_m\": 0.01, \"height_m\": true"),
       "bad-value",
       {"/objects/4/shape/capsule/height_m is true"}},
      // Meshes.
      {with("\"file\": \"asteroid.plg\", ", ""), "missing-key", {"/objects/6/shape/mesh has no \"file\""}},
      {with("asteroid.plg", "missing.obj"),
       "missing-mesh",
       {at(18, "/objects/6/shape/mesh/file: missing.obj: there is no such file")}},
      {with("asteroid.plg", "make_asteroid.py"), "unreadable-mesh", {at(18, "/objects/6/shape/mesh/file: ")}},
      {with("1e-5", "0"), "bad-value", {"/objects/6/shape/mesh/scale is 0"}},
      {with("1e-5", "1"),
       "mesh-too-large",
       {at(18, "/objects/6/shape/mesh/file: asteroid.plg: vertex"), "10 m"}},
      {with("1e-5", "1e-9"), "mesh-too-small", {"asteroid.plg: the mesh is"}},
      {with("\"crease_deg\": 30", "\"crease_deg\": 181"), "bad-value", {"crease_deg is 181"}},
      {with("\"side\": \"outside\"", "\"side\": \"out\""),
       "bad-value",
       {"side is \"out\", allowed is one of \"outside\""}},
      // Height fields.
      {with("\"file\": \"../telephone/heights_mm.csv\", ", ""),
       "missing-key",
       {"/objects/7/shape/height_field has no \"file\""}},
      {with("../telephone/heights_mm.csv", "no.csv"),
       "missing-heights",
       {at(19, "/objects/7/shape/height_field/file: no.csv: there is no such file")}},
      {with("../telephone/heights_mm.csv", "asteroid.plg"),
       "bad-number",
       {at(19, "/objects/7/shape/height_field/file: asteroid.plg:2: column 1 is \"asteroid 162 320\"")}},
      {with("\"size_m\": [0.15, 0.12]", "\"size_m\": [0.15]"), "bad-value", {"size_m is [0.15]"}},
      {with("\"size_m\": [0.15, 0.12]", "\"size_m\": [0.15, 0]"),
       "bad-value",
       {"height_field/size_m/1 is 0"}},
      {with("\"height_m\": 0.001, \"thick", "\"thick"), "missing-key", {"height_field has no \"height_m\""}},
      {with("\"height_m\": 0.001, \"thick", "\"height_m\": 0, \"thick"),
       "bad-value",
       {"height_m is 0, allowed is a number above 0.0 and at most 10.0 m"}},
      {with("\"height_m\": 0.001, \"thick", "\"height_m\": 1, \"thick"),
       "heights-out-of-range",
       {"heights_mm.csv: the block reaches from ", "allowed is from -10.0 to 10.0 m"}},
      {with("\"thickness_m\": 0.02", "\"thickness_m\": -0.02"), "bad-value", {"thickness_m is -0.02"}},
      {with("\"crease_deg\": 40", "\"crease_deg\": \"all\""), "bad-value", {"crease_deg is \"all\""}},
      // Poses.
      {with("[0.1, 0.2, 0.3]", "[0.1, 0.2, 1e9]"),
       "bad-value",
       {"/objects/1/pose/position_m/2 is 1000000000.0"}},
      {with("[0, 0, 90]", "[0, 0, 361]"), "bad-value", {at(14, "/objects/2/pose/rotation_deg/2 is 361")}},
      {with("\"pose\": { \"position_m\": [0.1, 0.2, 0.3] }", "\"pose\": []"),
       "bad-value",
       {"/objects/1/pose is []"}},
      // Materials.
      {with("\"material\": \"skin\"", "\"material\": \"skn\""),
       "unknown-material",
       {at(12, "/objects/1/material is \"skn\""), "did you mean \"skin\"?"}},
      {with("\"material\": \"skin\", ", ""), "missing-key", {"/objects/1 has no \"material\""}},
      {with("\"material\": \"skin\"", "\"material\": 5"), "bad-value", {"/objects/1/material is 5"}},
      {with("\"stiffness_N_m\": 300", "\"stiffness_N_m\": -300"),
       "bad-value",
       {at(8,
           "/materials/skin/stiffness_N_m is -300, allowed is a number above 0.0 and at most 100000.0 N/m")}},
      {with("\"stiffness_N_m\": 300", "\"stiffness_N_m\": 1e6"), "bad-value", {"stiffness_N_m is 1000000.0"}},
      {with("\"stiffness_N_m\": 300, ", ""),
       "missing-key",
       {at(8, "/materials/skin has no \"stiffness_N_m\"")}},
      {with("\"damping_N_s_m\": 1.5", "\"damping_N_s_m\": -1"), "bad-value", {"damping_N_s_m is -1"}},
      {with("\"dynamic_friction\": 0.5", "\"dynamic_friction\": 0.9"),
       "bad-value",
       {at(8, "/materials/skin/dynamic_friction is 0.9, allowed is at most static_friction, which is 0.8")}},
      {with("\"static_friction\": 0.8", "\"static_friction\": -0.8"),
       "bad-value",
       {"static_friction is -0.8"}},
      {with("\"steady\"", "\"slippery\""), "bad-value", {"friction_mode is \"slippery\", allowed is one of"}},
      {with("\"ice\": { \"stiffness_N_m\": 1000 }", "\"ice\": 1000"),
       "bad-value",
       {at(7, "/materials/ice is 1000")}},
  };
  for (const Case& c : cases) {
    const Refusal refused = refusal(c.text);
    EXPECT_EQ(refused.name, c.name) << refused.cause << "\n" << c.text.substr(0, 400);
    for (const std::string& part : c.parts) {
      EXPECT_THAT(refused.cause, HasSubstr(part)) << c.name;
    }
    EXPECT_THAT(refused.cause, testing::StartsWith("test.scene.json:"));
  }
  figure("kinds of mistakes tried", static_cast<double>(cases.size()), "each refused with its place");
}

TEST(SceneFile, LinesAreRightAcrossStringsAndNesting) {
  const std::string text =
      "{ \"description\": \"a \\\"quoted\\\\\" ,\n\"thimble_scene\":1,\"name\":\"x{[,]}\\n\",\n\n"
      "\"objects\":[{\"name\":\"a\",\"shape\":{\"sphere\":{\n\"radius_m\":0.01}},\"material\":{\"stiffness_N_"
      "m\":\n1}},\n"
      "{\"name\":\"b\",\"shape\":{\"sphere\":{\"radius_m\":\n-1}},\"material\":\"none\"}]}";
  EXPECT_THAT(refusal(text).cause,
              testing::StartsWith("test.scene.json:7: /objects/1/shape/sphere/radius_m is -1"));
}

TEST(SceneFile, BrokenTextNeverDoesMoreThanFail) {
  constexpr std::size_t kStep = kUnderSanitizers ? 3 : 1;
  // Many changes leave a scene that compiles: with the telephone's heights all of them took 18 s.
  const TemporaryFolder folder;
  const std::string text =
      with("../telephone/heights_mm.csv", folder.write("heights.csv", "0,1,0\n1,0,1\n").string());
  EXPECT_EQ(refusal(text).name, "nothing refused");
  std::size_t tried = 0;
  std::size_t refused = 0;
  for (std::size_t i = 0; i < text.size(); i += kStep) {  // prefixes, and bytes turned into something else
    ++tried;
    refused += refusal(text.substr(0, i)).name != "nothing refused" ? 1U : 0U;
    for (const char c : {'"', '\\', '}', '\0', '\x80', '9'}) {
      std::string changed = text;
      changed[i] = c;
      static_cast<void>(refusal(changed));
    }
  }
  EXPECT_EQ(refused, tried);
}

TEST(SceneFile, AMissingSceneIsAnError) {
  try {
    static_cast<void>(host::compile_scene(kAsteroid / "no.scene.json"));
    FAIL();
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "missing-scene");
  }
  EXPECT_THROW(static_cast<void>(host::compile_scene(kAsteroid)), host::Error);
}

TEST(SceneFile, WarnsOfWhatItRepaired) {
  const host::CompiledScene empty =
      host::compile_scene_text(R"({"thimble_scene": 1, "name": "nothing", "objects": []})", "t", kAsteroid);
  EXPECT_THAT(empty.report.warnings, testing::ElementsAre(HasSubstr("no object")));
}

TEST(SceneFile, WarnsOfAMeshOfWhichMostIsUnused) {
  const TemporaryFolder folder;
  for (const int unused : {50, 500}) {
    std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(4 + unused) +
                       "\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n"
                       "property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
    for (int i = 0; i < unused; ++i) text += std::to_string(i) + " 5 5\n";
    folder.write("mesh.ply", text + "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    const host::CompiledScene compiled = host::compile_scene_text(
        R"({"thimble_scene": 1, "name": "x", "objects": [{"name": "rock", "shape": {"mesh": {"file": "mesh.ply", "scale": 0.01}},
            "material": {"stiffness_N_m": 500}}]})",
        "t", folder.path());
    EXPECT_EQ(compiled.report.objects[0].mesh.unused_vertices, static_cast<std::size_t>(unused));
    if (unused == 50) {
      EXPECT_THAT(compiled.report.warnings, testing::IsEmpty());
    } else {
      EXPECT_THAT(compiled.report.warnings,
                  testing::ElementsAre("rock (mesh.ply): 500 vertices of the file belong to no triangle: "
                                       "were all of its faces read?"));
    }
  }
}

json schema() {
  std::ifstream stream(kSource / "host-tools/compiler/scene.schema.json");
  return json::parse(stream);
}

TEST(SceneSchema, EveryRequiredKeyIsRequiredByTheReader) {
  // Taking a required key away is an error, taking an optional one away is not.
  const json whole = json::parse(kScene);
  const json definitions = schema().at("$defs");
  struct Place {
    std::string kind;
    std::string pointer;
  };
  std::size_t tried = 0;
  for (const Place& place :
       {Place{"scene", ""}, Place{"object", "/objects/1"}, Place{"plane", "/objects/0/shape/plane"},
        Place{"sphere", "/objects/1/shape/sphere"}, Place{"box", "/objects/2/shape/box"},
        Place{"cylinder", "/objects/3/shape/cylinder"}, Place{"capsule", "/objects/4/shape/capsule"},
        Place{"cone", "/objects/5/shape/cone"}, Place{"height_field", "/objects/7/shape/height_field"},
        Place{"pose", "/objects/2/pose"}, Place{"material", "/objects/2/material"}}) {
    const json& definition = definitions.at(place.kind);
    for (const auto& [key, unused] : definition.at("properties").items()) {
      json less = whole;
      json& object = less[json::json_pointer(place.pointer)];
      if (object.erase(key) == 0 || key == "materials") {
        continue;
      }
      const auto required = definition.value("required", std::vector<std::string>());
      // The schema leaves it to the reader, because a force field needs none.
      const bool is_material = place.kind == "object" && key == "material";
      const bool needed = is_material || std::find(required.begin(), required.end(), key) != required.end();
      EXPECT_EQ(refusal(less.dump()).name, needed ? "missing-key" : "nothing refused")
          << place.pointer << "/" << key;
      ++tried;
    }
  }
  EXPECT_GT(tried, 20U);
}

TEST(Scenes, EverySceneOfTheRepositoryCompilesWithoutAWarning) {
  std::size_t scenes = 0;
  for (const fs::directory_entry& folder : fs::directory_iterator(kSource / "scenes")) {
    if (!folder.is_directory()) continue;
    const std::string name = folder.path().filename().string();
    const fs::path file = folder.path() / (name + ".scene.json");
    ASSERT_TRUE(fs::exists(file)) << file;
    const host::CompiledScene compiled = host::compile_scene(file);
    control::SceneView view;
    EXPECT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk) << name;
    EXPECT_THAT(compiled.report.warnings, testing::IsEmpty()) << name;
    figure("scene " + name + ", bytes", static_cast<double>(compiled.image.size()),
           "checked by the controller's own check");
    ++scenes;
  }
  EXPECT_GE(scenes, 3U);
}

}  // namespace
}  // namespace thimble::test::scene_file
