// Surfaces in scene files: their content in the image, and every error with its position.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_file.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/compiler/refusal.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test::scene_surface {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Every key of a surface, one material a line.
constexpr const char* kScene = R"({
"thimble_scene": 1,
"name": "surfaces",
"materials": {
"click": { "stiffness_N_m": 1000, "click": { "amplitude_N": 0.5, "frequency_Hz": 150, "decay_per_s": 90 }, "brake_friction": 0.4 },
"pattern": { "stiffness_N_m": 1000, "texture": { "kind": "height", "tile_m": [0.004, 0.003], "height_m": 0.0002, "pattern": "cos_cos" } },
"heights": { "stiffness_N_m": 1000, "texture": { "kind": "lateral", "tile_m": [0.004, 0.004], "height_m": 0.0002, "heights": [[0, 1, 2], [3, 4, 5]] } },
"file": { "stiffness_N_m": 1000, "texture": { "kind": "normal", "tile_m": [0.02, 0.02], "height_m": 0.0002, "file": "heights.csv" } },
"map": { "stiffness_N_m": 1000, "stiffness_map": { "stiffness_N_m": [[300, 400], [500, 600], [700, 800]], "damping_N_s_m": [[1, 2], [3, 4], [5, 6]],
  "cell_m": 0.005, "origin_m": [-0.01, -0.02, 0], "u": [2, 0, 0], "v": [0, 0, 1], "conservative": false } },
"map file": { "stiffness_N_m": 1000, "stiffness_map": { "stiffness_N_m": "stiffness.csv", "cell_m": 0.005 } }
},
"objects": [
{ "name": "clicks", "shape": { "sphere": { "radius_m": 0.02 } }, "material": "click" },
{ "name": "patterned", "shape": { "plane": { "normal": [0, 0, 1] } }, "material": "pattern" },
{ "name": "high", "shape": { "box": { "size_m": [0.02, 0.02, 0.02] } }, "material": "heights" },
{ "name": "filed", "shape": { "box": { "size_m": [0.03, 0.02, 0.02] } }, "material": "file" },
{ "name": "mapped", "shape": { "capsule": { "radius_m": 0.01, "height_m": 0.05 } }, "material": "map" },
{ "name": "scanned", "shape": { "plane": { "normal": [0, 0, 1] } }, "material": "map file" },
{ "name": "can", "shape": { "cylinder": { "radius_m": 0.01, "height_m": 0.05 } }, "material": "click" }
]
})";

class Folder : public TemporaryFolder {
 public:
  Folder() {
    write("heights.csv", "# seen from above\n1, 2, 3\n4, 5, 6\n7, 8, 9\n");
    write("stiffness.csv", "100, 200\n300, 400\n");
    write("negative.csv", "100, 200\n300, -400\n");
  }
};

host::CompiledScene compile(const std::string& text) {
  return host::compile_scene_text(text, "test.scene.json", Folder().path());
}

std::string with(const std::string& from, const std::string& to) { return replaced(kScene, from, to); }

Refusal refusal(const std::string& text) { return refusal_of_scene(text, Folder().path()); }

TEST(SceneSurface, IsReadIntoTheImage) {
  const host::CompiledScene compiled = compile(kScene);
  control::SceneView view;
  ASSERT_STREQ(control::name(control::SceneView::check(compiled.image, view)), "ok");
  const auto& objects = *view.scene()->objects();
  const scene::Surface& click = *objects[0]->surface();
  EXPECT_EQ(click.click()->amplitude_n(), 0.5F);
  EXPECT_EQ(click.click()->frequency_hz(), 150.0F);
  EXPECT_EQ(click.click()->decay_per_s(), 90.0F);
  EXPECT_EQ(click.brake_friction(), 0.4F);
  EXPECT_EQ(click.texture(), nullptr);
  EXPECT_EQ(click.stiffness_map(), nullptr);

  const scene::Texture& pattern = *objects[1]->surface()->texture();
  EXPECT_EQ(objects[1]->surface()->click(), nullptr);
  EXPECT_EQ(pattern.kind(), scene::TextureKind::Height);
  EXPECT_EQ(pattern.tile_u_m(), 0.004F);
  EXPECT_EQ(pattern.tile_v_m(), 0.003F);
  EXPECT_EQ(pattern.columns(), 32);
  EXPECT_EQ(pattern.height_m()->size(), 1024U);
  const scene::Texture& heights = *objects[2]->surface()->texture();
  EXPECT_EQ(heights.kind(), scene::TextureKind::Lateral);
  EXPECT_EQ(heights.columns(), 3);
  EXPECT_EQ(heights.rows(), 2);
  EXPECT_GT(heights.height_m()->Get(0), heights.height_m()->Get(3));  // 3 4 5 is the row at v = 0
  EXPECT_EQ(objects[3]->surface()->texture()->kind(), scene::TextureKind::Normal);
  EXPECT_EQ(objects[3]->surface()->texture()->rows(), 3);

  const scene::StiffnessMap& map = *objects[4]->surface()->stiffness_map();
  EXPECT_EQ(map.columns(), 2);
  EXPECT_EQ(map.rows(), 3);
  EXPECT_EQ(map.stiffness_n_per_m()->Get(0), 700.0F);
  EXPECT_EQ(map.damping_n_s_per_m()->Get(5), 2.0F);
  EXPECT_EQ(map.cell_m(), 0.005F);
  EXPECT_EQ(map.origin_m()->y(), -0.02F);
  EXPECT_EQ(map.u()->x(), 1.0F);
  EXPECT_EQ(map.v()->z(), 1.0F);
  EXPECT_FALSE(map.conservative());
  const scene::StiffnessMap& scanned = *objects[5]->surface()->stiffness_map();
  EXPECT_EQ(scanned.stiffness_n_per_m()->Get(0), 300.0F);
  EXPECT_EQ(scanned.damping_n_s_per_m(), nullptr);
  EXPECT_EQ(scanned.v()->y(), 1.0F);
  EXPECT_TRUE(scanned.conservative());
  EXPECT_THAT(compiled.report.warnings, testing::IsEmpty());
}

TEST(SceneSurface, AMaterialWithoutEffectsHasNoSurface) {
  const host::CompiledScene compiled = compile(with(
      R"("click": { "amplitude_N": 0.5, "frequency_Hz": 150, "decay_per_s": 90 }, "brake_friction": 0.4)",
      R"("brake_friction": 0)"));
  control::SceneView view;
  ASSERT_STREQ(control::name(control::SceneView::check(compiled.image, view)), "ok");
  EXPECT_EQ(view.scene()->objects()->Get(0)->surface(), nullptr);
}

TEST(SceneSurface, AWholeNumberOfTilesGoesRoundACylinder) {
  const host::CompiledScene compiled = compile(
      with(R"("height_m": 0.05 } }, "material": "click")", R"("height_m": 0.05 } }, "material": "pattern")"));
  control::SceneView view;
  ASSERT_STREQ(control::name(control::SceneView::check(compiled.image, view)), "ok");
  const scene::Texture& texture = *view.scene()->objects()->Get(6)->surface()->texture();
  EXPECT_NEAR(texture.tile_u_m() * 16, 2 * 3.14159265 * 0.01, 1e-7);
  EXPECT_EQ(texture.tile_v_m(), 0.003F);
  ASSERT_EQ(compiled.report.warnings.size(), 1U);
  EXPECT_THAT(compiled.report.warnings[0], HasSubstr("can: a tile of the texture is 0.0039"));
}

TEST(SceneSurface, EveryErrorSaysWhereWhatAndWhatIsAllowed) {
  struct Case {
    std::string text;
    std::string name;
    std::vector<std::string> parts;  // of the cause
  };
  std::string many = "[";
  for (int i = 0; i < 257; ++i) {
    many += i == 0 ? "[0" : ", [0";
    for (int j = 0; j < 255; ++j) many += ", 1";
    many += "]";
  }
  many += "]";
  const std::vector<Case> cases{
      {with("\"amplitude_N\": 0.5", "\"amplitude_N\": -0.5"),
       "bad-value",
       {"test.scene.json:5: /materials/click/click/amplitude_N is -0.5, allowed is a number from 0.0 to 20.0 "
        "N"}},
      {with("\"amplitude_N\": 0.5, ", ""), "missing-key", {"/materials/click/click has no \"amplitude_N\""}},
      {with("\"amplitude_N\": 0.5", "\"amplitude_N\": null"), "bad-value", {"amplitude_N is null"}},
      {with("\"frequency_Hz\": 150", "\"frequency_Hz\": 1001"),
       "bad-value",
       {"frequency_Hz is 1001", "1000.0 Hz"}},
      {with("\"decay_per_s\": 90", "\"decay_per_s\": 0"), "bad-value", {"decay_per_s is 0"}},
      {with("\"decay_per_s\"", "\"decay\""),
       "unknown-key",
       {"/click/decay", "did you mean \"decay_per_s\"?"}},
      {with("\"brake_friction\": 0.4", "\"brake_friction\": 11"), "bad-value", {"brake_friction is 11"}},
      {with(R"("click": { "amplitude_N": 0.5, "frequency_Hz": 150, "decay_per_s": 90 })", R"("click": 7)"),
       "bad-value",
       {"/materials/click/click is 7"}},

      {with("\"kind\": \"height\"", "\"kind\": \"heigth\""),
       "bad-value",
       {"/materials/pattern/texture/kind is \"heigth\""}},
      {with("\"kind\": \"height\", ", ""), "missing-key", {"/materials/pattern/texture has no \"kind\""}},
      {with("[0.004, 0.003]", "[0.004]"),
       "bad-value",
       {"tile_m is [0.004], allowed is an array of two numbers [x, y]"}},
      {with("[0.004, 0.003]", "[0.004, 0]"), "bad-value", {"/tile_m/1 is 0"}},
      {with("[0.004, 0.003]", "[0.004, 0.0003]"),
       "too-fine",
       {"/materials/pattern/texture/tile_m/1 puts the heights", "1e-05 m"}},
      {with("\"height_m\": 0.0002", "\"height_m\": 0.02"), "bad-value", {"height_m is 0.02", "0.01"}},
      {with("\"height_m\": 0.0002", "\"height_m\": 0"), "bad-value", {"height_m is 0"}},
      {with("\"pattern\": \"cos_cos\"", "\"pattern\": \"dots\""), "bad-value", {"pattern is \"dots\""}},
      {with(", \"pattern\": \"cos_cos\"", ""),
       "bad-value",
       {"/materials/pattern/texture is ", "exactly one of"}},
      {with("\"pattern\": \"cos_cos\"", "\"pattern\": \"cos_cos\", \"file\": \"heights.csv\""),
       "bad-value",
       {"exactly one of"}},
      {with("[3, 4, 5]", "[3, 4]"),
       "bad-value",
       {"/texture/heights/1 is [3,4], allowed is a row of 3 numbers"}},
      {with("[3, 4, 5]", "[3, 4, \"5\"]"), "bad-value", {"/texture/heights/1/2 is \"5\""}},
      {with("[[0, 1, 2], [3, 4, 5]]", "[[0, 1, 2]]"),
       "bad-value",
       {"/texture/heights is ", "at least 2 x 2"}},
      {with("[[0, 1, 2], [3, 4, 5]]", "[[2, 2], [2, 2]]"),
       "flat-texture",
       {"/texture/heights has the same height"}},
      {with("[[0, 1, 2], [3, 4, 5]]", many), "too-many-samples", {"256 x 257 numbers, at most 65536"}},
      {with("\"heights.csv\"", "\"no.csv\""),
       "missing-heights",
       {"test.scene.json:8: /materials/file/texture/file: no.csv"}},
      {with("\"pattern\": \"cos_cos\"", "\"pattern\": \"cos_cos\", \"mapping\": \"uv\""),
       "no-coordinates",
       {"/materials/pattern/texture has the mapping \"uv\"", "\"patterned\", a plane"}},
      {with("\"pattern\": \"cos_cos\"", "\"pattern\": \"cos_cos\", \"mapping\": \"cube\""),
       "bad-value",
       {"/mapping is \"cube\""}},

      {with("[500, 600]", "[500, 0]"),
       "bad-value",
       {"test.scene.json:9: /materials/map/stiffness_map/stiffness_N_m/1/1 is 0"}},
      {with("[500, 600]", "[500, 2e5]"), "bad-value", {"/stiffness_N_m/1/1 is 200000.0"}},
      {with("[3, 4], [5, 6]", "[3, 4], [5, -6]"), "bad-value", {"/damping_N_s_m/2/1 is -6"}},
      {with("[3, 4], [5, 6]", "[3, 4]"),
       "unlike-grids",
       {"/damping_N_s_m is a grid of 2 x 2, the stiffness has 2 x 3"}},
      {with(
           R"("plane": { "normal": [0, 0, 1] } }, "material": "map file")",
           R"("tissue": { "size_m": [0.1, 0.1], "contact_radius_m": 0.004, "relaxed_stiffness_N_m": 500, "recovery_s": 1 } }, "material": "map file")"),
       "no-surface",
       {"test.scene.json:11: /materials/map file has effects", "\"scanned\", a tissue"}},
      {with("\"cell_m\": 0.005, \"origin_m\"", "\"cell_m\": 0, \"origin_m\""), "bad-value", {"cell_m is 0"}},
      {with("\"stiffness.csv\", \"cell_m\": 0.005", "\"stiffness.csv\""),
       "missing-key",
       {"/stiffness_map has no \"cell_m\""}},
      {with("[-0.01, -0.02, 0]", "[-0.01, -0.02, 11]"), "bad-value", {"/origin_m/2 is 11"}},
      {with("\"u\": [2, 0, 0]", "\"u\": [0, 0, 0]"), "bad-value", {"/u is [0,0,0], allowed is a direction"}},
      {with("\"u\": [2, 0, 0]", "\"u\": [0, 0, -3]"),
       "bad-value",
       {"whose u and v point in different directions"}},
      {with("\"conservative\": false", "\"conservative\": 0"),
       "bad-value",
       {"/conservative is 0, allowed is true or false"}},
      {with("\"stiffness.csv\"", "\"negative.csv\""),
       "bad-value",
       {"test.scene.json:11: /materials/map file/stiffness_map/stiffness_N_m: negative.csv: has the value "
        "-400"}},
      {with("\"stiffness.csv\"", "{}"),
       "bad-value",
       {"/stiffness_map/stiffness_N_m is {}, allowed is rows of numbers"}},
  };
  for (const Case& c : cases) {
    const Refusal refused = refusal(c.text);
    EXPECT_EQ(refused.name, c.name) << refused.cause;
    for (const std::string& part : c.parts) {
      EXPECT_THAT(refused.cause, HasSubstr(part)) << c.name;
    }
    EXPECT_THAT(refused.cause, testing::StartsWith("test.scene.json:"));
  }
  figure("kinds of mistakes tried", static_cast<double>(cases.size()), "each refused with its place");
}

TEST(SceneSurface, EveryRequiredKeyIsRequired) {
  std::ifstream file(THIMBLE_SOURCE_DIR "/host-tools/compiler/scene.schema.json");
  const json definitions = json::parse(file).at("$defs");
  // Taking a required key away is an error, taking an optional one away is not.
  const json whole = json::parse(kScene);
  for (const auto& [kind, pointer] :
       {std::pair("click", "/materials/click/click"), std::pair("texture", "/materials/pattern/texture"),
        std::pair("stiffness_map", "/materials/map/stiffness_map")}) {
    const json& definition = definitions.at(kind);
    for (const auto& [key, unused] : definition.at("properties").items()) {
      json less = whole;
      if (less[json::json_pointer(pointer)].erase(key) == 0 || key == "pattern") continue;
      const auto required = definition.value("required", std::vector<std::string>());
      const bool needed = std::find(required.begin(), required.end(), key) != required.end();
      EXPECT_EQ(refusal(less.dump()).name, needed ? "missing-key" : "nothing refused")
          << pointer << "/" << key;
    }
  }
}

}  // namespace
}  // namespace thimble::test::scene_surface
