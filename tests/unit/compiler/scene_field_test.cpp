// Fields in scene files: their content in the image, and every error with its position.
#include "host-tools/compiler/scene_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/unit/compiler/refusal.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using testing::HasSubstr;

// The shape is in line 2.
std::string scene_of(const std::string& shape, const std::string& material = R"("stiffness_N_m": 500)") {
  return "{\"thimble_scene\": 1, \"name\": \"one\", \"objects\": [{\"name\": \"it\", \"shape\":\n{" + shape +
         "}, \"material\": {" + material + "}}]}";
}

host::CompiledScene compiled(const std::string& shape) {
  return host::compile_scene_text(scene_of(shape), "test.scene.json", {});
}

const scene::Object& only_object(const host::CompiledScene& scene) {
  control::SceneView view;
  EXPECT_EQ(control::SceneView::check(scene.image, view), control::ImageStatus::kOk);
  return *scene::GetScene(scene.image.data())->objects()->Get(0);
}

TEST(SceneField, ABoxBecomesSixSubvolumesAndABox) {
  const host::CompiledScene scene = compiled(R"("vector_field": {"box": {"size_m": [0.02, 0.04, 0.06]}})");
  const scene::VectorField& field = *only_object(scene).shape_as_VectorField();
  ASSERT_EQ(field.subvolumes()->size(), 6U);
  for (const scene::Subvolume* subvolume : *field.subvolumes()) {
    EXPECT_EQ(subvolume->sides()->size(), 6U);  // its face and five borders
    EXPECT_EQ(subvolume->radius_m(), 0.0F);
  }
  EXPECT_FLOAT_EQ(field.hi_m()->x(), 0.01F);
  EXPECT_FLOAT_EQ(field.hi_m()->z(), 0.03F);
  EXPECT_FLOAT_EQ(field.lo_m()->y(), -0.02F);
}

TEST(SceneField, AForceFieldHasItsNumbersAndNeedsNoMaterial) {
  const auto compiled_object = [](const std::string& rest) {
    return host::compile_scene_text(
        R"({"thimble_scene": 1, "name": "one", "objects": [{"name": "it", "shape": )" + rest + "}]}",
        "test.scene.json", {});
  };
  const host::CompiledScene scene = compiled_object(R"({"force_field": {"constant_N": [1, 2, 3],
    "stiffness_N_m": [4, 5, 6], "damping_N_s_m": [7, 8, 9], "curl_N_s_m": [-1, -2, -3], "size_m": [0.2, 0.4, 0.6], "trial": 7}})");
  EXPECT_TRUE(scene.report.warnings.empty());
  const scene::ForceField& field = *only_object(scene).shape_as_ForceField();
  const auto is = [](const scene::Vec3& v, float x, float y, float z) {
    return v.x() == x && v.y() == y && v.z() == z;
  };
  EXPECT_TRUE(is(field.constant_n(), 1, 2, 3) && is(field.stiffness_n_per_m(), 4, 5, 6) &&
              is(field.damping_n_s_per_m(), 7, 8, 9) && is(field.curl_n_s_per_m(), -1, -2, -3) &&
              is(field.half_size_m(), 0.1F, 0.2F, 0.3F));
  EXPECT_EQ(field.trial(), 7U);
  const host::CompiledScene with_mass = compiled_object(
      R"({"force_field": {"mass": {"mass_kg": 0.5, "stiffness_N_m": 60, "damping_N_s_m": 0.25}}})");
  const scene::ForceField& cup = *only_object(with_mass).shape_as_ForceField();
  EXPECT_EQ(cup.mass_kg(), 0.5F);
  EXPECT_EQ(cup.mass_stiffness_n_per_m(), 60.0F);
  EXPECT_EQ(cup.mass_damping_n_s_per_m(), 0.25F);

  const host::CompiledScene empty = compiled_object(R"({"force_field": {}})");
  const scene::ForceField& nothing = *only_object(empty).shape_as_ForceField();
  EXPECT_TRUE(is(nothing.half_size_m(), control::kMaxCoordinate_m, control::kMaxCoordinate_m,
                 control::kMaxCoordinate_m));
  EXPECT_EQ(nothing.mass_kg(), 0.0F);
  EXPECT_EQ(nothing.trial(), 0U);
  const Refusal refusal =
      refusal_of_scene(R"({"thimble_scene": 1, "name": "one", "objects": [{"name": "it", "shape":
{"sphere": {"radius_m": 0.01}}}]})",
                       {});
  EXPECT_EQ(refusal.name, "missing-key");
  EXPECT_THAT(refusal.cause, HasSubstr("material"));
}

TEST(SceneField, APlaneOfABodyThatIsNearestToNothingIsLeftOut) {
  const host::CompiledScene scene = compiled(R"("vector_field": {"planes": [
    {"normal": [0, 0, 1], "offset_m": 0.01}, {"normal": [0, 0, 1], "offset_m": 0.02}, {"normal": [0, 0, 2], "offset_m": 0.01}]})");
  const scene::VectorField& field = *only_object(scene).shape_as_VectorField();
  EXPECT_EQ(field.subvolumes()->size(), 1U);
  EXPECT_FLOAT_EQ(field.hi_m()->z(), 0.01F);
  EXPECT_FLOAT_EQ(field.hi_m()->x(), control::kMaxCoordinate_m);  // it goes on for ever
}

TEST(SceneField, APotentialsGridHoldsTheShapeAndTheSplinesWindow) {
  const host::CompiledScene scene = compiled(
      R"("potential_field": {"shape": {"box": {"size_m": [0.02, 0.03, 0.0401]}}, "step_m": 0.002, "law": "energy", "source_N_m": 10})");
  const scene::PotentialField& field = *only_object(scene).shape_as_PotentialField();
  EXPECT_EQ(field.law(), scene::PotentialLaw::Energy);
  EXPECT_EQ(field.count()->Get(0), 2 * (5 + 2) + 1);
  EXPECT_EQ(field.count()->Get(1), 2 * (8 + 2) + 1);
  EXPECT_EQ(field.count()->Get(2), 2 * (11 + 2) + 1);
  EXPECT_FLOAT_EQ(field.origin_m()->z(), -0.026F);
  EXPECT_EQ(
      compiled(
          R"("potential_field": {"shape": {"sphere": {"radius_m": 0.02}}, "step_m": 0.002, "source_per_m": 1})")
          .image,
      compiled(
          R"("potential_field": {"shape": {"sphere": {"radius_m": 0.02}}, "step_m": 0.002, "source_per_m": 1})")
          .image);
}

TEST(SceneField, EveryErrorSaysWhereWhatAndWhatIsAllowed) {
  struct Case {
    std::string shape;
    std::string name;
    std::vector<std::string> parts;  // of the cause
  };
  const auto vector = [](const std::string& of) { return "\"vector_field\": " + of; };
  const auto potential = [](const std::string& rest,
                            const std::string& start =
                                R"("shape": {"sphere": {"radius_m": 0.02}}, "step_m": 0.004)") {
    return "\"potential_field\": {" + start + (rest.empty() ? "" : ", ") + rest + "}";
  };
  const auto inclusion = [&](const std::string& of) { return potential("\"inclusions\": [{" + of + "}]"); };
  const auto repeated = [](const std::string& what, std::size_t count) {
    std::string list = what;
    for (std::size_t i = 1; i < count; ++i) list += ", " + what;
    return "[" + list + "]";
  };
  const std::string plane = R"({"normal": [0, 0, 1], "offset_m": 0.01})";
  const std::string ball = R"({"ball": {"radius_m": 0.01}})";
  const std::string small = R"("shape": {"sphere": {"radius_m": 0.006}})";
  const std::vector<Case> cases{
      // Force fields.
      {R"("force_field": {"trial": 1.5})",
       "bad-value",
       {"/force_field/trial is 1.5, allowed is a whole number"}},
      {R"("force_field": {"trial": 256})", "bad-value", {"from 0.0 to 255.0"}},
      {R"("force_field": {"stiffness_N_m": [0, -1, 0]})",
       "bad-value",
       {"/force_field/stiffness_N_m/1 is -1"}},
      {R"("force_field": {"constant_N": [0, 101, 0]})", "bad-value", {"/force_field/constant_N/1 is 101"}},
      {R"("force_field": {"curl_N_s": [0, 0, 1]})", "unknown-key", {"did you mean \"curl_N_s_m\"?"}},
      {R"("force_field": {"mass": {"mass_kg": 1}})", "missing-key", {"stiffness_N_m"}},
      {R"("force_field": {"curl_N_s_m": [0, 1, 0], "mass": {"mass_kg": 1, "stiffness_N_m": 9}})",
       "senseless-key",
       {"/force_field/mass stands beside a curl_N_s_m"}},
      {R"("force_field": {"size_m": [0, 1, 1]})", "bad-value", {"/force_field/size_m/0 is 0"}},
      // Vector fields.
      {vector("7"),
       "bad-value",
       {"test.scene.json:2: /objects/0/shape/vector_field is 7, allowed is an object"}},
      {vector("{}"), "bad-value", {"exactly one of \"box\", \"sphere\", \"planes\", \"subvolumes\""}},
      {vector(R"({"box": {"size_m": [1, 1, 1]}, "sphere": {"radius_m": 1}})"),
       "bad-value",
       {"exactly one of"}},
      {vector(R"({"cube": {"size_m": [1, 1, 1]}})"), "unknown-key", {"vector_field/cube"}},
      {vector(R"({"box": {"size_m": [0.02, 0.02, 0]}})"),
       "bad-value",
       {"/objects/0/shape/vector_field/box/size_m/2 is 0"}},
      {vector(R"({"sphere": {"radius": 0.02}})"), "unknown-key", {"did you mean \"radius_m\"?"}},
      {vector(R"({"sphere": {"radius_m": 11}})"),
       "bad-value",
       {"is 11, allowed is a number from 1e-05 to 10.0 m"}},
      {vector(R"({"planes": {}})"), "bad-value", {"an array of planes, at least 1"}},
      {vector(R"({"planes": []})"), "bad-value", {"an array of planes, at least 1"}},
      {vector("{\"planes\": " + repeated(plane, 17) + "}"),
       "too-many-samples",
       {"has 17 planes, at most 16"}},
      {vector(R"({"planes": [{"normal": [0, 0, 0]}]})"),
       "bad-value",
       {"planes/0/normal", "any length but zero"}},
      {vector(R"({"planes": [{"normal": [0, 0, 1], "offset_m": 11}]})"),
       "bad-value",
       {"planes/0/offset_m is 11"}},
      {vector(
           R"({"planes": [{"normal": [0, 0, 1], "offset_m": -1}, {"normal": [0, 0, -1], "offset_m": -1}]})"),
       "empty-subvolume",
       {"/vector_field/planes hold no point together"}},
      {vector("{\"subvolumes\": " + repeated(ball, 65) + "}"),
       "too-many-samples",
       {"has 65 subvolumes, at most 64"}},
      {vector(R"({"subvolumes": [{}]})"), "bad-value", {"exactly one of \"plane\" and \"ball\""}},
      {vector("{\"subvolumes\": [{\"plane\": " + plane + ", \"ball\": {\"radius_m\": 1}}]}"),
       "bad-value",
       {"exactly one of"}},
      {vector("{\"subvolumes\": [{\"plane\": " + plane + ", \"side\": []}]}"),
       "unknown-key",
       {"did you mean \"sides\"?"}},
      {vector("{\"subvolumes\": [{\"plane\": " + plane + ", \"sides\": " + repeated(plane, 17) + "}]}"),
       "too-many-samples",
       {"/subvolumes/0/sides has 17 planes, at most 16"}},
      {vector("{\"subvolumes\": [{\"plane\": " + plane +
              R"(, "sides": [{"normal": [0, 0, -1], "offset_m": -0.02}]}]})"),
       "empty-subvolume",
       {"/subvolumes/0 holds no point"}},
      {vector(R"({"subvolumes": [{"ball": {"radius_m": 0.01, "centre_m": [0, 0, 11]}}]})"),
       "bad-value",
       {"ball/centre_m/2 is 11"}},
      {vector(
           R"({"subvolumes": [{"ball": {"radius_m": 0.01}, "sides": [{"normal": [0, 0, 1], "offset_m": -0.02}]}]})"),
       "empty-subvolume",
       {"holds no point"}},
      // Potential fields.
      {potential("", R"("step_m": 0.002)"), "missing-key", {"/potential_field has no \"shape\""}},
      {potential("", R"("shape": {"sphere": {"radius_m": 0.02}})"), "missing-key", {"has no \"step_m\""}},
      {potential("", R"("shape": {"plane": {"normal": [0, 0, 1]}}, "step_m": 0.002)"),
       "unknown-key",
       {"shape/plane"}},
      {potential("", R"("shape": {}, "step_m": 0.002)"), "bad-value", {"exactly one of \"sphere\", \"box\""}},
      {potential("", R"("shape": {"sphere": {"radius_m": 0.02}}, "step_m": 0)"),
       "bad-value",
       {"step_m is 0"}},
      {potential("", R"("shape": {"sphere": {"radius_m": 0.02}}, "step_m": "fine")"),
       "bad-value",
       {"step_m is \"fine\""}},
      {potential(R"("source_per_m": 1)", R"("shape": {"sphere": {"radius_m": 0.2}}, "step_m": 0.002)"),
       "too-many-samples",
       {"/potential_field needs a grid of 205 x 205 x 205 = 8615125 samples, at most 2097152"}},
      {potential(R"("source_per_m": 1)", R"("shape": {"sphere": {"radius_m": 10}}, "step_m": 0.00001)"),
       "too-many-samples",
       {"at most 2097152"}},
      {potential(R"("source_per_m": 1)", R"("shape": {"sphere": {"radius_m": 0.001}}, "step_m": 0.002)"),
       "field-too-coarse",
       {"has 1 points of the grid of 0.002 m inside, at least 27"}},
      {potential(R"("law": "Spring")"), "bad-value", {"one of \"spring\", \"energy\""}},
      {potential(""), "empty-field", {"nothing that raises the potential"}},
      {potential(R"("source_per_m": -1)"),
       "bad-value",
       {"source_per_m is -1, allowed is a number from 0.0 to 1000000.0 1/m"}},
      {potential(R"("source_per_m": [1])"), "bad-value", {"source_per_m is [1]"}},
      {potential(R"("source_N_m": 1)"), "wrong-law", {"source_N_m belongs to the law \"energy\""}},
      {potential(R"("law": "energy", "source_per_m": 1)"),
       "wrong-law",
       {"source_per_m belongs to the law \"spring\""}},
      {potential(R"("inclusions": {})"), "bad-value", {"an array of inclusions"}},
      {potential("\"inclusions\": " + repeated("{}", 65)),
       "too-many-samples",
       {"has 65 inclusions, at most 64"}},
      {inclusion(small), "missing-key", {"/inclusions/0 has no \"depth_m\""}},
      {inclusion(R"("depth_m": 0.01)"), "missing-key", {"has no \"shape\""}},
      {inclusion(small + R"(, "depth_m": 0)"),
       "bad-value",
       {"/inclusions/0/depth_m is 0, allowed is a number above 0.0 and at most 1.0 m"}},
      {inclusion(small + R"(, "potential_J": 1)"),
       "wrong-law",
       {"potential_J belongs to the law \"energy\""}},
      {inclusion(small + R"(, "depth": 1)"), "unknown-key", {"did you mean \"depth_m\"?"}},
      {inclusion(small + R"(, "depth_m": 0.01, "pose": {"position_m": [0, 0, 0.017]})"),
       "inclusion-outside",
       {"/potential_field/inclusions/0 reaches out"}},
      {inclusion(
           R"("shape": {"sphere": {"radius_m": 0.001}}, "depth_m": 0.01, "pose": {"position_m": [0.002, 0.002, 0]})"),
       "inclusion-too-small",
       {"/inclusions/0 holds no point of the grid of 0.004 m"}},
      {potential("\"inclusions\": " + repeated("{" + small + ", \"depth_m\": 0.01}", 2)),
       "inclusions-meet",
       {"/inclusions/1 meets an earlier inclusion"}},
      {potential("\"regions\": " + repeated("{}", 65)), "too-many-samples", {"has 65 regions, at most 64"}},
      {potential("\"regions\": [{" + small + "}]"), "missing-key", {"/regions/0 has no \"source_per_m\""}},
      {potential("\"regions\": [{" + small + ", \"source_per_m\": 2e6}]"),
       "bad-value",
       {"/regions/0/source_per_m is 2000000"}},
      {potential("\"regions\": [{" + small + ", \"pose\": {\"position\": 1}, \"source_per_m\": 1}]"),
       "unknown-key",
       {"did you mean \"position_m\"?"}},
      {potential(R"("source_per_m": 1000000)", R"("shape": {"sphere": {"radius_m": 1}}, "step_m": 0.2)"),
       "potential-too-high",
       {"/potential_field reaches ", " m, at most 1000.0"}}};
  int wrong = 0;
  for (const Case& test : cases) {
    std::string name = "nothing refused";
    std::string cause;
    try {
      static_cast<void>(compiled(test.shape));
    } catch (const host::Error& error) {
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      EXPECT_FALSE(error.remedy.empty());
      name = error.name;
      cause = error.cause;
    }
    wrong += name != test.name ? 1 : 0;
    EXPECT_EQ(name, test.name) << test.shape << "\n" << cause;
    EXPECT_THAT(cause, HasSubstr("test.scene.json:2: ")) << test.shape;
    for (const std::string& part : test.parts) EXPECT_THAT(cause, HasSubstr(part)) << test.shape;
  }
  figure("mistakes in fields not named, of " + std::to_string(cases.size()), wrong, "0");
}

TEST(SceneField, TooManyVolumesAreRefused) {
  std::string text = R"({"thimble_scene": 1, "name": "many", "objects": [)";
  for (std::size_t i = 0; i <= control::kMaxVolumes; ++i) {
    text +=
        std::string(i == 0 ? "" : ",") + R"({"name": "v)" + std::to_string(i) +
        R"(", "shape": {"vector_field": {"sphere": {"radius_m": 0.01}}}, "material": {"stiffness_N_m": 1}})";
  }
  try {
    static_cast<void>(host::compile_scene_text(text + "]}", "test.scene.json", {}));
    FAIL() << "accepted";
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, "too-many-volumes");
    EXPECT_THAT(error.cause, HasSubstr("/objects/16/shape is the scene's volume number 17, at most 16"));
  }
}

}  // namespace
}  // namespace thimble::test
