// All errors of a scene file at once, each with its place in the text.
#include "host-tools/compiler/scene_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <ctime>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

using host::SceneErrors;
using testing::HasSubstr;

SceneErrors errors_of(const std::string& text, const std::filesystem::path& folder = ".") {
  try {
    static_cast<void>(host::compile_scene_text(text, "test.scene.json", folder));
  } catch (const SceneErrors& errors) {
    EXPECT_EQ(errors.code, host::ExitCode::kBadInput);
    EXPECT_EQ(errors.name, errors.issues.at(0).name);
    EXPECT_EQ(errors.cause, errors.issues.at(0).cause);
    EXPECT_EQ(errors.remedy, errors.issues.at(0).remedy);
    return errors;
  }
  ADD_FAILURE() << "nothing refused";
  return {host::ExitCode::kOk, {host::SceneIssue{}}};
}

std::vector<std::string> told(const SceneErrors& errors) {
  std::vector<std::string> lines;
  for (const host::SceneIssue& issue : errors.issues)
    lines.push_back(std::to_string(issue.place.line) + ":" + std::to_string(issue.place.column) + " " +
                    issue.name + " " + issue.pointer);
  return lines;
}

constexpr const char* kWrong = R"({
  "thimble_scene": 1, "name": "é", "colour": 1, // é
  "materials": { "soft": { "stiffness_N_m": -1, "stifness": 2 }, "hard": { "stiffness_N_m": 500 } },
  "objects": [
    { "name": "a", "shape": { "sphere": { "radius_m": 0 } }, "material": "soft" },
    { "name": "b", "shape": { "box": { "size_m": [1, "2", 3] } }, "material": "hart" },
    { "name": "a", "shape": { "sphere": { "radius_m": 0.01 } }, "material": "hard", "pose": { "position_m": [1] } },
    { "name": "c", "shape": { "sphere": { "radius_m": 0.01 } } },
    { "name": "d", "shape": { "sphere": { "radius_m": 0.01 } },
      "material": { "stiffness_N_m": 1, "static_friction": 0.1, "dynamic_friction": 0.2, "click": { "amplitude_N": 1 } } }
  ]
})";

TEST(SceneErrors, EveryErrorIsTold) {
  const SceneErrors errors = errors_of(kWrong);
  // The first is that which a reader meets first; then by place.
  EXPECT_THAT(
      told(errors),
      testing::ElementsAre(
          "2:36 unknown-key /colour", "3:45 bad-value /materials/soft/stiffness_N_m",
          "3:49 unknown-key /materials/soft/stifness", "5:55 bad-value /objects/0/shape/sphere/radius_m",
          "6:54 bad-value /objects/1/shape/box/size_m/1", "6:79 unknown-material /objects/1/material",
          "7:15 repeated-name /objects/2/name", "7:109 bad-value /objects/2/pose/position_m",
          "8:5 missing-key /objects/3", "10:85 bad-value /objects/4/material/dynamic_friction",
          "10:99 missing-key /objects/4/material/click", "10:99 missing-key /objects/4/material/click"))
      << testing::PrintToString(told(errors));
  for (const host::SceneIssue& issue : errors.issues) {
    EXPECT_THAT(issue.cause,
                testing::StartsWith("test.scene.json:" + std::to_string(issue.place.line) + ": "));
    EXPECT_FALSE(issue.remedy.empty());
  }
  EXPECT_EQ(errors.more, 0U);
}

TEST(SceneErrors, AtMostTwentyAreListed) {
  std::string text = R"({"thimble_scene": 1, "name": "many", "objects": [)";
  for (int i = 0; i < 25; ++i)
    text += std::string(i == 0 ? "" : ",") + "\n{\"name\": \"" + std::to_string(i) +
            R"(", "shape": {"sphere": {"radius_m": 0}}, "material": {"stiffness_N_m": 1}})";
  const SceneErrors errors = errors_of(text + "]}");
  EXPECT_EQ(errors.issues.size(), 20U);
  EXPECT_EQ(errors.more, 5U);
  EXPECT_EQ(errors.issues.back().place.line, 21U);
}

// A text of a mebibyte that has nothing but errors, and long pointers in one that is refused for a repeated key.
TEST(SceneErrors, ManyErrorsTakeNoLongerThanAScene) {
  std::string text = R"({"thimble_scene": 1)";
  while (text.size() < 1'000'000) text += ", \"x" + std::to_string(text.size()) + "\": 1";
  const auto begun = std::clock();
  EXPECT_EQ(errors_of(text + "}").more, 180U);
  std::string numbers = "0";
  while (numbers.size() < 400'000) numbers += ",0";
  EXPECT_EQ(errors_of(R"({"a": 1, "a": 1, ")" + std::string(400'000, 'k') + "\": [" + numbers + "]}").name,
            "duplicate-key");
  EXPECT_LT(static_cast<double>(std::clock() - begun) / CLOCKS_PER_SEC, 20.0);
}

TEST(SceneErrors, OfTheFilesThatTheObjectsName) {
  const TemporaryFolder folder;
  folder.write("flat.obj", "v 0 0 0\nv 1 0 0\nf 1 2 2\n");
  const SceneErrors errors = errors_of(R"({"thimble_scene": 1, "name": "files", "objects": [
  {"name": "a", "shape": {"mesh": {"file": "none.obj"}}, "material": {"stiffness_N_m": 1}},
  {"name": "b", "shape": {"sphere": {"radius_m": 0.01}}, "material": {"stiffness_N_m": 1}},
  {"name": "c", "shape": {"mesh": {"file": "flat.obj"}}, "material": {"stiffness_N_m": 1}},
  {"name": "d", "shape": {"height_field": {"file": "none.png", "size_m": [1, 1], "height_m": 1}},
   "material": {"stiffness_N_m": 1}}]})",
                                       folder.path());
  ASSERT_EQ(errors.issues.size(), 3U) << testing::PrintToString(told(errors));
  EXPECT_THAT(errors.issues[0].cause, HasSubstr("none.obj"));
  EXPECT_THAT(errors.issues[1].pointer, testing::StartsWith("/objects/2"));
  EXPECT_EQ(errors.issues[1].place.line, 4U);
  EXPECT_EQ(errors.issues[2].place.line, 5U);
}

TEST(SceneErrors, OfTextThatIsNoJsonTheFirst) {
  const SceneErrors errors = errors_of("{ // é\n  \"é\": é }");
  EXPECT_THAT(told(errors), testing::ElementsAre("2:8 bad-json "));
  EXPECT_THAT(errors.remedy, HasSubstr("comments are allowed"));
  EXPECT_EQ(errors_of(std::string(100000, '[')).name, "bad-json");
  EXPECT_THAT(told(errors_of("{\"a\": 1,\n \"a\": 2}")), testing::ElementsAre("2:7 duplicate-key /a"));
  EXPECT_THAT(told(errors_of("[1]")), testing::SizeIs(1));
  EXPECT_THAT(told(errors_of("{\"thimble_scene\": 2, \"x\": 1}")),
              testing::ElementsAre("1:19 wrong-version /thimble_scene"));
}

}  // namespace
}  // namespace thimble::test
