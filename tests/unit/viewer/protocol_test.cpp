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
  const auto answer =
      std::get<AnswerMessage>(parse_page_message(R"({"type": "answer", "prompt": 7, "answer": "decline"})"));
  EXPECT_EQ(answer.prompt, 7U);
  EXPECT_TRUE(answer.declines);
  EXPECT_FALSE(
      std::get<AnswerMessage>(parse_page_message(R"({"type": "answer", "prompt": 0, "answer": "done"})"))
          .declines);
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
