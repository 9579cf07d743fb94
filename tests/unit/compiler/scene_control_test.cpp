// The control elements of a scene file: their content in the image, and every error with its position.
#include "host-tools/compiler/scene_control.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/unit/compiler/refusal.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test::scene_control {
namespace {

using nlohmann::json;
using testing::HasSubstr;

// Every key of a control, both ways.
constexpr const char* kScene = R"({ "thimble_scene": 1, "name": "controls", "objects": [
{ "name": "fader", "shape": { "box": { "size_m": [0.01, 0.02, 0.01] } }, "material": { "stiffness_N_m": 500 },
"body": { "motion": "slide", "mass_kg": 0.05, "axis": [2, 0, 0], "restitution": 0.25, "control": {
"stiffness_N_m": 20, "rest_m": -0.001, "damping_N_s_m": 0.5, "friction_N": 0.2, "low_m": -0.02, "high_m": 0.03,
"detents": { "pitch_m": 0.005, "phase_m": 0.001, "force_N": 0.8 },
"curve_m_N": [[0, 0.5], [0.01, 1.5]],
"switch": { "on_at_m": 0.02, "off_at_m": 0.01 } } } },
{ "name": "knob", "shape": { "cylinder": { "radius_m": 0.02, "height_m": 0.01 } }, "material": { "stiffness_N_m": 500 },
"body": { "motion": "turn", "mass_kg": 0.05, "axis": [0, 0, 1], "control": {
"stiffness_N_m_rad": 0.1, "rest_deg": 90, "damping_N_m_s_rad": 0.001, "friction_N_m": 0.002, "low_deg": -180, "high_deg": 45,
"detents": { "pitch_deg": 30, "phase_deg": 15, "torque_N_m": 0.03 },
"curve_deg_N_m": [[-10, 0.5], [10, -0.5]],
"switch": { "on_at_deg": -30, "off_at_deg": -10 } } } }
] })";

std::string with(const std::string& from, const std::string& to) { return replaced(kScene, from, to); }

Refusal refusal(const std::string& text) { return refusal_of_scene(text, "."); }

TEST(SceneControlElement, ReadsEveryKeyIntoTheImage) {
  const host::CompiledScene compiled = host::compile_scene_text(kScene, "test.scene.json", ".");
  control::SceneView view;
  ASSERT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
  const auto& objects = *view.scene()->objects();
  const scene::Control& fader = *objects[0]->body()->control();
  EXPECT_EQ(fader.stiffness(), 20.0F);
  EXPECT_EQ(fader.rest(), -0.001F);
  EXPECT_EQ(fader.damping(), 0.5F);
  EXPECT_EQ(fader.friction(), 0.2F);
  EXPECT_EQ(fader.low(), -0.02F);
  EXPECT_EQ(fader.high(), 0.03F);
  EXPECT_EQ(fader.detent_pitch(), 0.005F);
  EXPECT_EQ(fader.detent_phase(), 0.001F);
  EXPECT_EQ(fader.detent_effort(), 0.8F);
  ASSERT_EQ(fader.curve()->size(), 2U);
  EXPECT_EQ(fader.curve()->Get(1)->at(), 0.01F);
  EXPECT_EQ(fader.curve()->Get(1)->effort(), 1.5F);
  EXPECT_TRUE(fader.has_switch());
  EXPECT_EQ(fader.on_at(), 0.02F);
  EXPECT_EQ(fader.off_at(), 0.01F);

  constexpr float kDegree = std::numbers::pi_v<float> / 180.0F;
  const scene::Control& knob = *objects[1]->body()->control();
  EXPECT_EQ(knob.stiffness(), 0.1F);
  EXPECT_NEAR(knob.rest(), 90 * kDegree, 1e-6F);
  EXPECT_EQ(knob.damping(), 0.001F);
  EXPECT_EQ(knob.friction(), 0.002F);
  EXPECT_NEAR(knob.low(), -180 * kDegree, 1e-6F);
  EXPECT_NEAR(knob.high(), 45 * kDegree, 1e-6F);
  EXPECT_NEAR(knob.detent_pitch(), 30 * kDegree, 1e-6F);
  EXPECT_NEAR(knob.detent_phase(), 15 * kDegree, 1e-6F);
  EXPECT_EQ(knob.detent_effort(), 0.03F);
  EXPECT_NEAR(knob.curve()->Get(0)->at(), -10 * kDegree, 1e-6F);
  EXPECT_EQ(knob.curve()->Get(0)->effort(), 0.5F);
  EXPECT_NEAR(knob.on_at(), -30 * kDegree, 1e-6F);
  EXPECT_NEAR(knob.off_at(), -10 * kDegree, 1e-6F);
}

TEST(SceneControlElement, WithoutAKeyItHasNone) {
  const json whole = json::parse(kScene);
  json bare = whole;
  for (json& object : bare["objects"]) object["body"]["control"] = json::object();
  const host::CompiledScene compiled = host::compile_scene_text(bare.dump(), "t", ".");
  control::SceneView view;
  ASSERT_EQ(control::SceneView::check(compiled.image, view), control::ImageStatus::kOk);
  for (const scene::Object* object : *view.scene()->objects()) {
    const scene::Control& control = *object->body()->control();
    EXPECT_EQ(control.stiffness() + control.damping() + control.friction() + control.detent_pitch(), 0.0F);
    EXPECT_EQ(control.curve(), nullptr);
    EXPECT_FALSE(control.has_switch());
    EXPECT_EQ(control.low(), -control.high());
    EXPECT_NEAR(control.high(), object->body()->motion() == scene::Motion::Slide ? 10.0F : 99.99F, 0.01F);
  }
  // Each key alone may be left out, but for those that the schema requires.
  std::ifstream stream(THIMBLE_SOURCE_DIR "/host-tools/compiler/scene.schema.json");
  const json definitions = json::parse(stream).at("$defs");
  for (const auto& [kind, place] :
       std::vector<std::pair<std::string, std::string>>{{"slide_control", "/objects/0/body/control"},
                                                        {"slide_detents", "/objects/0/body/control/detents"},
                                                        {"slide_switch", "/objects/0/body/control/switch"},
                                                        {"turn_control", "/objects/1/body/control"},
                                                        {"turn_detents", "/objects/1/body/control/detents"},
                                                        {"turn_switch", "/objects/1/body/control/switch"}}) {
    const auto required = definitions.at(kind).value("required", std::vector<std::string>());
    for (const auto& [key, unused] : definitions.at(kind).at("properties").items()) {
      json less = whole;
      ASSERT_EQ(less[json::json_pointer(place)].erase(key), 1U) << place << "/" << key;
      const bool needed = std::find(required.begin(), required.end(), key) != required.end();
      EXPECT_EQ(refusal(less.dump()).name, needed ? "missing-key" : "nothing refused") << place << "/" << key;
    }
  }
}

TEST(SceneControlElement, EveryErrorSaysWhereWhatAndWhatIsAllowed) {
  struct Case {
    std::string text;
    std::string name;
    std::vector<std::string> parts;  // of the cause
  };
  std::string points = "[0, 0]";
  for (int i = 1; i <= 32; ++i) points += ", [" + std::to_string(i) + "e-4, 0]";
  const std::vector<Case> cases{
      {with("\"stiffness_N_m\": 20", "\"stiffness_N_m\": -20"),
       "bad-value",
       {"test.scene.json:4: /objects/0/body/control/stiffness_N_m is -20", "from 0.0 to 100000.0 N/m"}},
      {with("\"stiffness_N_m\": 20", "\"stiffness_N_m\": \"20\""), "bad-value", {"is \"20\""}},
      {with("\"stiffness_N_m\": 20", "\"stiffness_N_m_rad\": 20"), "unknown-key", {"a control that slides"}},
      {with("\"rest_m\": -0.001", "\"rest_m\": 11"), "bad-value", {"rest_m is 11"}},
      {with("\"rest_deg\": 90", "\"rest_deg\": 5730"),
       "bad-value",
       {"rest_deg is 5730", "-5729.0 to 5729.0 degrees"}},
      {with("\"damping_N_s_m\": 0.5", "\"damping_N_s_m\": 1001"), "bad-value", {"damping_N_s_m is 1001"}},
      {with("\"friction_N\": 0.2", "\"friction_N\": null"), "bad-value", {"friction_N is null"}},
      {with("\"friction_N_m\": 0.002", "\"friction_N_m\": 101"),
       "bad-value",
       {"friction_N_m is 101", "100.0 N m"}},
      {with("\"low_m\": -0.02", "\"low_m\": 0.001"), "bad-value", {"low_m is 0.001", "from -10.0 to 0.0 m"}},
      {with("\"high_deg\": 45", "\"high_deg\": -1"), "bad-value", {"high_deg is -1"}},
      {with("\"low_m\": -0.02, \"high_m\": 0.03", "\"low_m\": 0, \"high_m\": 0"),
       "bad-value",
       {"/objects/0/body/control/high_m is 0, allowed is a number above low_m"}},
      {with("\"pitch_m\": 0.005, ", ""),
       "missing-key",
       {"/objects/0/body/control/detents has no \"pitch_m\""}},
      {with("\"pitch_m\": 0.005", "\"pitch_m\": 0"), "bad-value", {"pitch_m is 0, allowed is a number from"}},
      {with("\"pitch_deg\": 30", "\"pitch_deg\": 0.001"), "bad-value", {"pitch_deg is 0.001"}},
      {with("\"phase_m\": 0.001", "\"phase_m\": []"), "bad-value", {"phase_m is []"}},
      {with("\"force_N\": 0.8", "\"force_N\": 0"), "bad-value", {"force_N is 0", "above 0.0"}},
      {with("\"torque_N_m\": 0.03", "\"force_N\": 0.03"), "unknown-key", {"detents/force_N"}},
      {with("\"detents\": {", "\"detents\": 7, \"switch\": {"), "duplicate-key", {"switch is given twice"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[]"), "bad-value", {"curve_m_N is []", "an array of points"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[0, 0.5]"), "bad-value", {"curve_m_N/0 is 0", "two numbers"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[[0, 0.5], [0, 1.5]]"),
       "bad-value",
       {"curve_m_N/1/0 is 0", "above the one of the point before"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[[0, 0.5], [0.01, 101]]"), "bad-value", {"curve_m_N/1/1 is 101"}},
      {with("[[-10, 0.5], [10, -0.5]]", "[[-10, 0.5], [6000, -0.5]]"),
       "bad-value",
       {"curve_deg_N_m/1/0 is 6000"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[" + points + "]"),
       "too-many-curve-points",
       {"curve_m_N has 33 points, at most 32"}},
      {with("\"on_at_m\": 0.02, ", ""), "missing-key", {"switch has no \"on_at_m\""}},
      {with("\"off_at_m\": 0.01", "\"off_at_m\": 0.02"),
       "bad-value",
       {"off_at_m is 0.02", "other than on_at_m"}},
      {with("\"on_at_deg\": -30", "\"on_at_deg\": true"), "bad-value", {"on_at_deg is true"}},
      {with("\"motion\": \"slide\"", "\"motion\": \"plane\""), "senseless-key", {"/objects/0/body/control"}},
      {with("\"mass_kg\": 0.05, \"axis\": [2, 0, 0]",
            "\"mass_kg\": 0.05, \"axis\": [2, 0, 0], \"spring_N_m\": 5"),
       "senseless-key",
       {"/objects/0/body/spring_N_m stands beside a control"}},
      // sqrt((20 + 2 pi 40 / 0.005 + 100) / 0.05) = 1003 rad/s.
      {with("\"force_N\": 0.8", "\"force_N\": 40"),
       "control-too-stiff",
       {"test.scene.json:3: /objects/0/body/control is too stiff", "1004", "at most 1000.0 rad/s"}},
      {with("[[0, 0.5], [0.01, 1.5]]", "[[0, 0], [0.0001, 50]]"), "control-too-stiff", {"rad/s"}},
      {with("\"stiffness_N_m_rad\": 0.1", "\"stiffness_N_m_rad\": 20"),
       "control-too-stiff",
       {"/objects/1/body/control"}},
  };
  for (const Case& c : cases) {
    const Refusal refused = refusal(c.text);
    EXPECT_EQ(refused.name, c.name) << refused.cause;
    for (const std::string& part : c.parts) EXPECT_THAT(refused.cause, HasSubstr(part)) << c.name;
  }
  figure("kinds of mistakes tried", static_cast<double>(cases.size()), "each refused with its place");
}

}  // namespace
}  // namespace thimble::test::scene_control
