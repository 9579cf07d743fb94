// Needle layers and tissues in a scene file: their content in the image, and each error with its position.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

json whole() {
  return json::parse(R"({
    "thimble_scene": 1, "name": "t", "objects": [
      { "name": "way", "material": { "stiffness_N_m": 600 }, "shape": { "needle": { "layers": [
        { "name": "skin", "thickness_m": 0.002, "stiffness_N_m": 800, "tear_N": 2, "friction_N": 0.2, "viscosity_N_s_m2": 10 },
        { "thickness_m": 0.01, "stiffness_N_m": 0, "tear_N": 0 } ] } } },
      { "name": "pad", "material": { "stiffness_N_m": 400 }, "shape": { "tissue": {
        "size_m": [0.12, 0.1], "contact_radius_m": 0.006, "relaxed_stiffness_N_m": 150, "recovery_s": 0.6 } } } ] })");
}

std::pair<std::string, std::string> refusal(const json& scene) {
  try {
    const host::CompiledScene compiled = host::compile_scene_text(scene.dump(), "t", {});
    control::SceneView view;
    EXPECT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
  } catch (const host::Error& error) {
    return {error.name, error.cause};
  }
  return {"nothing refused", ""};
}

TEST(SceneTissue, IsWrittenAsItStands) {
  const host::CompiledScene compiled = host::compile_scene_text(whole().dump(), "t", {});
  const scene::Scene& scene = *scene::GetScene(compiled.image.data());
  const auto& layers = *scene.objects()->Get(0)->shape_as_Needle()->layers();
  ASSERT_EQ(layers.size(), 2U);
  EXPECT_EQ(layers.Get(0)->thickness_m(), 0.002F);
  EXPECT_EQ(layers.Get(0)->stiffness_n_per_m(), 800.0F);
  EXPECT_EQ(layers.Get(0)->tear_n(), 2.0F);
  EXPECT_EQ(layers.Get(0)->friction_n(), 0.2F);
  EXPECT_EQ(layers.Get(0)->viscosity_n_s_per_m2(), 10.0F);
  EXPECT_EQ(layers.Get(1)->friction_n(), 0.0F);
  const scene::Tissue& tissue = *scene.objects()->Get(1)->shape_as_Tissue();
  EXPECT_EQ(tissue.half_x_m(), 0.06F);
  EXPECT_EQ(tissue.half_y_m(), 0.05F);
  EXPECT_EQ(tissue.contact_radius_m(), 0.006F);
  EXPECT_EQ(tissue.relaxed_stiffness_n_per_m(), 150.0F);
  EXPECT_EQ(tissue.recovery_s(), 0.6F);
}

TEST(SceneTissue, EachMistakeIsNamed) {
  const std::string layer = "/objects/0/shape/needle/layers/0/";
  const std::string tissue = "/objects/1/shape/tissue/";
  struct Case {
    std::string pointer;
    json value;
    std::string name;
    std::string part;
  };
  const std::vector<Case> cases{
      {layer + "name", "", "bad-value", "name is \"\""},
      {layer + "thickness_m", 0, "bad-value", "thickness_m is 0, allowed is a number from 1e-05 to 10.0 m"},
      {layer + "thickness_m", "thin", "bad-value", "thickness_m is \"thin\""},
      {layer + "thickness_m", nullptr, "bad-value", "thickness_m is null"},
      {layer + "stiffness_N_m", -1, "bad-value",
       "stiffness_N_m is -1, allowed is a number from 0.0 to 100000.0 N/m"},
      {layer + "stiffness_N_m", 1e6, "bad-value", "stiffness_N_m is 1000000.0"},
      {layer + "stiffness_N_m", 0, "bad-value", "tear_N is 2, allowed is 0, because without stiffness"},
      {layer + "tear_N", 101, "bad-value", "tear_N is 101, allowed is a number from 0.0 to 100.0 N"},
      {layer + "tear_N", true, "bad-value", "tear_N is true"},
      {layer + "friction_N", -0.1, "bad-value", "friction_N is -0.1"},
      {layer + "viscosity_N_s_m2", 1e5, "bad-value", "allowed is a number from 0.0 to 10000.0 N s/m^2"},
      {layer + "strength_N", 1, "unknown-key", "is not a key of a layer of a needle's way"},
      {"/objects/0/shape/needle/layers", json::array(), "bad-value", "an array of layers, at least 1"},
      {"/objects/0/shape/needle/layers", 5, "bad-value", "layers is 5"},
      {"/objects/0/shape/needle/layers",
       json::array_t(33, whole()["objects"][0]["shape"]["needle"]["layers"][0]), "too-many-layers",
       "has 33 layers, at most 32"},
      {"/objects/0/shape/needle/layer", 5, "unknown-key", "did you mean \"layers\"?"},
      {tissue + "size_m", json::array({0.1}), "bad-value", "an array of two numbers [x, y]"},
      {tissue + "size_m", json::array({0.1, 0}), "bad-value", "size_m/1 is 0"},
      {tissue + "contact_radius_m", -0.006, "bad-value", "contact_radius_m is -0.006"},
      {tissue + "relaxed_stiffness_N_m", 0, "bad-value", "relaxed_stiffness_N_m is 0"},
      {tissue + "relaxed_stiffness_N_m", 401, "bad-value", "(the material's stiffness is 400.0)"},
      {tissue + "relaxed_stiffness_N_m", 0.3, "bad-value", "a number from 0.4 to 400.0 N/m"},
      {tissue + "recovery_s", 0, "bad-value", "recovery_s is 0, allowed is a number from 0.001"},
      {tissue + "recovery_s", 3601, "bad-value", "recovery_s is 3601"},
      {tissue + "damping", 1, "unknown-key", "is not a key of a tissue"},
  };
  for (const Case& c : cases) {
    json scene = whole();
    scene[json::json_pointer(c.pointer)] = c.value;
    const auto [name, cause] = refusal(scene);
    EXPECT_EQ(name, c.name) << c.pointer << ": " << cause;
    EXPECT_THAT(cause, HasSubstr(c.part)) << c.pointer;
  }
  figure("kinds of mistakes tried", static_cast<double>(cases.size()), "each refused with its place");
  EXPECT_EQ(refusal(whole()).first, "nothing refused");
}

TEST(SceneTissue, EveryRequiredKeyIsRequired) {
  for (const auto& [pointer, key, needed] : {std::tuple("/objects/0/shape/needle/layers/0", "name", false),
                                             {"/objects/0/shape/needle/layers/0", "thickness_m", true},
                                             {"/objects/0/shape/needle/layers/0", "stiffness_N_m", true},
                                             {"/objects/0/shape/needle/layers/0", "tear_N", true},
                                             {"/objects/0/shape/needle/layers/0", "friction_N", false},
                                             {"/objects/0/shape/needle/layers/0", "viscosity_N_s_m2", false},
                                             {"/objects/0/shape/needle", "layers", true},
                                             {"/objects/1/shape/tissue", "size_m", true},
                                             {"/objects/1/shape/tissue", "contact_radius_m", true},
                                             {"/objects/1/shape/tissue", "relaxed_stiffness_N_m", true},
                                             {"/objects/1/shape/tissue", "recovery_s", true}}) {
    json scene = whole();
    scene[json::json_pointer(pointer)].erase(key);
    EXPECT_EQ(refusal(scene).first, needed ? "missing-key" : "nothing refused") << pointer << "/" << key;
  }
}

}  // namespace
}  // namespace thimble::test
