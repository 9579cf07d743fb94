// Comments of scene files, and changes of their text that leave everything else as it is.
#include "host-tools/compiler/scene_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host-tools/compiler/compile.h"
#include "tests/support/random.h"
#include "tests/unit/compiler/refusal.h"

namespace thimble::test {
namespace {

using host::with_material;
using host::without_comments;

constexpr const char* kScene = R"(// a scene with "quotes", { and }
{
	"thimble_scene": 1, /* version */ "name": "a // b /* c */",
	"materials": {
		"brass": { // "static_friction": 5
			"stiffness_N_m": 800,
			"damping_N_s_m":   1.50  /* N s/m */
			// the end
		},
		"own": {"stiffness_N_m": 600.0}
	},
	"objects": [
		{ "name": "left", "shape": {"plane": {"normal": [1, 0, 0], "offset_m": -0.03}}, "material": "brass" },
		{ "name": "right", "shape": {"plane": {"normal": [-1, 0, 0], "offset_m": -0.03}}, "material": "brass" },
		{ "name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.03}}, "material": "own" },
		{ "name": "back", "shape": {"plane": {"normal": [0, 1, 0], "offset_m": -0.03}},
		  "material": {"stiffness_N_m":700,"static_friction":0.1} }
	]
}
// the last)";

std::string crlf(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '\n' ? "\r\n" : std::string(1, c);
  return out;
}

std::vector<std::byte> image_of(const std::string& text) {
  return host::compile_scene_text(text, "test.scene.json", ".").image;
}

TEST(SceneText, CommentsAreBlanksOfTheSameLength) {
  EXPECT_EQ(without_comments("1 // x\n2"), "1     \n2");
  EXPECT_EQ(without_comments("1 // x\r\n2"), "1     \r\n2");
  EXPECT_EQ(without_comments("/* a\n\tb */ 1"), "    \n\t     1");
  EXPECT_EQ(without_comments(R"("a // b" "\"/*" /**/)"), R"("a // b" "\"/*"     )");
  EXPECT_EQ(without_comments("1 /* never ends"), "1 /* never ends");
  EXPECT_EQ(without_comments("/* // */ 1 //"), "         1   ");
  EXPECT_EQ(without_comments("/ *"), "/ *");
  Random random(3);
  for (int run = 0; run < 2000; ++run) {  // any bytes
    std::string text;
    for (std::size_t i = random.below(40); i > 0; --i) text += "/*\"\\\r\n a"[random.below(8)];
    const std::string plain = without_comments(text);
    ASSERT_EQ(plain.size(), text.size());
    for (std::size_t i = 0; i < text.size(); ++i)
      ASSERT_TRUE(plain[i] == text[i] || (plain[i] == ' ' && text[i] != '\n')) << text;
  }
}

TEST(SceneText, ASceneMayHaveComments) {
  EXPECT_EQ(image_of(kScene), image_of(without_comments(kScene)));
  EXPECT_EQ(image_of(kScene), image_of(crlf(kScene)));
  // Lines stay right, and what is in comments is nothing.
  const Refusal refused = refusal_of_scene(replaced(kScene, "1.50", "-1.50"), ".");
  EXPECT_THAT(refused.cause,
              testing::StartsWith("test.scene.json:7: /materials/brass/damping_N_s_m is -1.5"));
  EXPECT_EQ(refusal_of_scene(replaced(kScene, "800,", "800, /*"), ".").name, "bad-json");
  const Refusal comma = refusal_of_scene(replaced(kScene, "[1, 0, 0]", "[1, 0, 0,]"), ".");
  EXPECT_EQ(comma.name, "bad-json");
  EXPECT_THAT(comma.cause, testing::StartsWith("test.scene.json:13: "));
}

TEST(SceneText, ANumberIsChangedAndNothingElse) {
  for (const std::string& text : {std::string(kScene), crlf(kScene), "\xEF\xBB\xBF" + std::string(kScene)}) {
    EXPECT_EQ(with_material(text, 3, "stiffness_N_m", 712.5), replaced(text, ":700", ":712.5"));
    EXPECT_EQ(with_material(text, 3, "static_friction", 0.25), replaced(text, ":0.1}", ":0.25}"));
    // A key that was not there, in the manner of the one before it.
    EXPECT_EQ(with_material(text, 3, "damping_N_s_m", 2),
              replaced(text, ":0.1}", ":0.1,\"damping_N_s_m\": 2}"));
    // Only this object has the shared material.
    EXPECT_EQ(with_material(text, 2, "stiffness_N_m", 500), replaced(text, "600.0", "500"));
    EXPECT_EQ(with_material(text, 2, "damping_N_s_m", 1),
              replaced(text, "600.0}", "600.0, \"damping_N_s_m\": 1}"));
    // Values that are there already, or by default.
    EXPECT_EQ(with_material(text, 0, "stiffness_N_m", 800), text);
    EXPECT_EQ(with_material(text, 0, "damping_N_s_m", 1.5), text);
    EXPECT_EQ(with_material(text, 0, "static_friction", 0), text);
    EXPECT_EQ(with_material(text, 3, "stiffness_N_m", 0.1 + 0.2), replaced(text, ":700", ":0.3"));
  }
}

TEST(SceneText, AnObjectLeavesTheMaterialThatItShares) {
  const std::string own = with_material(kScene, 1, "stiffness_N_m", 900);
  EXPECT_EQ(
      own,
      replaced(kScene, "\"offset_m\": -0.03}}, \"material\": \"brass\" },\n\t\t{ \"name\": \"floor\"",
               "\"offset_m\": -0.03}}, \"material\": { \"stiffness_N_m\": 900, \"damping_N_s_m\": 1.50 } "
               "},\n\t\t{ \"name\": \"floor\""));
  // Now the other object is the only one of brass: a key of its own line there.
  EXPECT_EQ(with_material(own, 0, "static_friction", 0.5),
            replaced(own, "1.50  /* N s/m */", "1.50,\n\t\t\t\"static_friction\": 0.5  /* N s/m */"));
  EXPECT_EQ(with_material(crlf(own), 0, "static_friction", 0.5),
            crlf(with_material(own, 0, "static_friction", 0.5)));
}

TEST(SceneText, TheImageHasEveryValueThatWasGiven) {
  Random random(4);
  std::string text = kScene;
  for (int run = 0; run < 100; ++run) {
    const std::size_t object = random.below(4);
    const std::string key = random.below(2) == 0 ? "stiffness_N_m" : "damping_N_s_m";
    const double value =
        random.below(4) == 0 ? 0.125 * static_cast<double>(1 + random.below(8)) : random.uniform(0.1, 90);
    text = with_material(text, object, key, value);
    const host::CompiledScene compiled = host::compile_scene_text(text, "test.scene.json", ".");
    const auto& material =
        *scene::GetScene(compiled.image.data())->objects()->Get(static_cast<unsigned>(object))->material();
    ASSERT_FLOAT_EQ(key == "stiffness_N_m" ? material.stiffness_n_per_m() : material.damping_n_s_per_m(),
                    static_cast<float>(value))
        << text;
  }
}

TEST(SceneText, AMaterialThatOthersShareBecomesOwnBehindAnObjectWithout) {
  const std::string text =
      R"({"objects": [{"name": "wind"}, {"name": "a", "material": "wood"}, {"name": "b", "material": "wood"}],
"materials": {"wood": {"stiffness_N_m": 800}}})";
  EXPECT_EQ(with_material(text, 1, "stiffness_N_m", 500),
            replaced(text, R"("a", "material": "wood")", R"("a", "material": {"stiffness_N_m": 500})"));
  EXPECT_THROW(static_cast<void>(with_material(text, 0, "stiffness_N_m", 500)), host::Error);
}

}  // namespace
}  // namespace thimble::test
