// Valid and invalid messages of a page.
#include "host-tools/viewer/protocol.h"

#include <gtest/gtest.h>

#include <string>

namespace thimble::host {
namespace {

std::string refusal(std::string_view text) {
  try {
    static_cast<void>(parse_page_message(text));
  } catch (const Error& error) {
    EXPECT_EQ(error.code, ExitCode::kUsage);
    EXPECT_FALSE(error.cause.empty());
    EXPECT_FALSE(error.remedy.empty());
    return error.name;
  }
  return "";
}

TEST(Protocol, MessagesOfAPage) {
  const auto hand = std::get<HandMessage>(
      parse_page_message(R"({"type": "hand", "arm": 1, "position_m": [0.01, -2e-3, 0]})"));
  EXPECT_EQ(hand.arm, 1U);
  EXPECT_EQ(hand.position_m, (std::array<double, 3>{0.01, -0.002, 0}));
  EXPECT_EQ(std::get<CommandMessage>(parse_page_message(R"({"type": "command", "verb": "disarm"})")).verb,
            ViewCommand::kDisarm);
  EXPECT_EQ(std::get<PickMessage>(parse_page_message(R"({"type": "pick", "scene": "ring"})")).scene, "ring");
  const auto parameter = std::get<ParameterMessage>(
      parse_page_message(R"({"type": "parameter", "name": "max_force", "value": 3.5})"));
  EXPECT_STREQ(parameter.row->name, "max_force");
  EXPECT_EQ(parameter.value, 3.5);
  const auto material = std::get<MaterialMessage>(
      parse_page_message(R"({"type": "material", "object": 2, "key": "damping", "value": 1})"));
  EXPECT_EQ(material.object, 2U);
  EXPECT_EQ(material.key, "damping_N_s_m");
  EXPECT_TRUE(std::holds_alternative<SaveMessage>(parse_page_message(R"({"type": "save"})")));
  EXPECT_FALSE(std::get<SaveMessage>(parse_page_message(R"({"type": "save"})")).replaces);
  EXPECT_TRUE(std::get<SaveMessage>(parse_page_message(R"({"type": "save", "replaces": true})")).replaces);
  EXPECT_TRUE(std::holds_alternative<TextMessage>(parse_page_message(R"({"type": "text"})")));
  const auto answer =
      std::get<AnswerMessage>(parse_page_message(R"({"type": "answer", "prompt": 7, "answer": "decline"})"));
  EXPECT_EQ(answer.prompt, 7U);
  EXPECT_TRUE(answer.declines);
  EXPECT_FALSE(
      std::get<AnswerMessage>(parse_page_message(R"({"type": "answer", "prompt": 0, "answer": "done"})"))
          .declines);
  EXPECT_TRUE(std::get<RecordMessage>(parse_page_message(R"({"type": "record", "on": true})")).on);
  EXPECT_FALSE(std::get<RecordMessage>(parse_page_message(R"({"type": "record", "on": false})")).on);
}

TEST(Protocol, Nonsense) {
  for (const char* text : {"",
                           " ",
                           "{",
                           "[]",
                           "null",
                           "3",
                           "\"hand\"",
                           "{}",
                           R"({"type": null})",
                           R"({"type": "fly"})",
                           R"({"type": "hand"})",
                           R"({"type": "answer", "prompt": 1})",
                           R"({"type": "answer", "prompt": 1, "answer": "maybe"})",
                           R"({"type": "answer", "prompt": -1, "answer": "done"})",
                           R"({"type": "answer", "answer": "done"})",
                           R"({"type": "record"})",
                           R"({"type": "record", "on": 1})",
                           R"({"type": "hand", "arm": "0", "position_m": [0, 0, 0]})",
                           R"({"type": "hand", "arm": -1, "position_m": [0, 0, 0]})",
                           R"({"type": "hand", "arm": 0.5, "position_m": [0, 0, 0]})",
                           R"({"type": "hand", "arm": 1e300, "position_m": [0, 0, 0]})",
                           R"({"type": "hand", "arm": 0, "position_m": [0, 0]})",
                           R"({"type": "hand", "arm": 0, "position_m": [0, 0, 0, 0]})",
                           R"({"type": "hand", "arm": 0, "position_m": [0, 0, null]})",
                           R"({"type": "hand", "arm": 0, "position_m": [0, 0, 1e999]})",
                           R"({"type": "hand", "arm": 0, "position_m": {"x": 1, "y": 2, "z": 3}})",
                           R"({"type": "command"})",
                           R"({"type": "command", "verb": "halt"})",
                           R"({"type": "pick"})",
                           R"({"type": "draft", "number": 1})",
                           R"({"type": "draft", "text": "{}"})",
                           R"({"type": "draft", "number": -1, "text": "{}"})",
                           R"({"type": "draft", "number": 1, "text": ["{}"]})",
                           R"({"type": "save", "replaces": 1})",
                           R"({"type": "pick", "scene": ["ring"]})",
                           R"({"type": "parameter", "name": "max_force"})",
                           R"({"type": "material", "object": 0, "key": "stiffness_N_m", "value": 1})",
                           R"({"type": "material", "object": 0, "key": "stiffness"})"})
    EXPECT_EQ(refusal(text), "bad-message") << text;
  EXPECT_EQ(refusal("{\"type\": \"save\"" + std::string(kMostMessageBytes, ' ') + "}"), "bad-message");
  EXPECT_EQ(refusal(std::string(kMostMessageBytes, '[')), "bad-message");
  using namespace std::string_view_literals;
  EXPECT_EQ(refusal("{\"type\": \"save\"}\0{}"sv), "bad-message");
  EXPECT_EQ(refusal(R"({"type": "parameter", "name": "x", "value": 1})"), "unknown-parameter");
  EXPECT_EQ(refusal(R"({"type": "parameter", "name": "max_force", "value": 21})"), "bad-value");
  EXPECT_EQ(refusal(R"({"type": "parameter", "name": "allow_moves", "value": 0.5})"), "bad-value");
}

TEST(Protocol, ADraftMayBeAsLongAsASceneMayBe) {
  const auto message = [](const std::string& text) {
    return to_text({{"type", "draft"}, {"number", 2147483647}, {"text", text}});
  };
  for (const char c : {'x', '"', '\n'}) {  // of which some are written as two
    const std::string text(kMostDraftBytes, c);
    const auto draft = std::get<DraftMessage>(parse_page_message(message(text)));
    EXPECT_EQ(draft.number, 2147483647U);
    EXPECT_EQ(draft.text, text);
    EXPECT_EQ(refusal(message(text + c)), "scene-file-too-large");
  }
  EXPECT_EQ(refusal(std::string(kMostDraftMessageBytes + 1, ' ')), "bad-message");
  // What is deep, or long, and no draft.
  const std::string deep(kMostDraftBytes, '[');
  EXPECT_EQ(refusal(R"({"type": "draft", "number": 1, "text": )" + deep + "}"), "bad-message");
  EXPECT_EQ(refusal(R"({"type": "save", "x": ")" + std::string(kMostMessageBytes, 'x') + "\"}"),
            "bad-message");
}

TEST(Protocol, FilesHaveTheNameOfAMeshOrOfHeights) {
  EXPECT_EQ(file_message("Part_2.OBJ", "v 0 0 0").name, "Part_2.OBJ");
  for (const char* name : {"", ".obj", "a", "a.json", "a.scene.json", "../a.obj", "a/b.obj", "a b.obj",
                           ".a.obj", "a.obj\n", "a.sh", "a\\b.obj", "%2e%2e%2fa.obj", "\xC3\xA4.obj"}) {
    EXPECT_THROW(static_cast<void>(file_message(name, "")), Error) << name;
  }
  EXPECT_THROW(static_cast<void>(file_message(std::string(200, 'a') + ".obj", "")), Error);
}

TEST(Protocol, Texts) {
  EXPECT_EQ(to_text(link_json(true)), R"({"type":"link","up":true})");
  EXPECT_EQ(
      to_text(event_json(Error(ExitCode::kLinkLost, "link-lost", "it \xFF broke", "mend it"))),
      "{\"type\":\"event\",\"level\":\"error\",\"name\":\"link-lost\",\"cause\":\"it \xEF\xBF\xBD broke\","
      "\"remedy\":\"mend it\"}");
  EXPECT_EQ(exact(0.1F), 0.1);
}

}  // namespace
}  // namespace thimble::host
