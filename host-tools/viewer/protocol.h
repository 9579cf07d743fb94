// The messages between page and server: JSON text over the WebSocket /live.
//
// server -> page: hello, scene, state, event, link, text, checked, recording. page -> server: hand, command, pick, parameter, material, text, draft,
// save, record; of a commissioning (commission_page.h) answer.
// SI units, the world frame; object numbers are places in the scene image.
#pragma once

#include <array>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firmware/params.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/error.h"

namespace thimble::host {

using Json = nlohmann::ordered_json;

inline constexpr std::size_t kMostMessageBytes = 4096;                 // of a page, but for drafts
inline constexpr std::size_t kMostDraftBytes = std::size_t{1} << 20U;  // of a scene's text
// Every character of it written as two, and what is around it.
inline constexpr std::size_t kMostDraftMessageBytes = 2 * kMostDraftBytes + 1024;

struct HandMessage {
  std::size_t arm = 0;
  std::array<double, 3> position_m{};
};
enum class ViewCommand { kHome, kArm, kDisarm, kClear, kStop };
struct CommandMessage {
  ViewCommand verb;
};
struct PickMessage {
  std::string scene;
};
struct ParameterMessage {
  const firmware::ParamRow* row = nullptr;
  double value = 0;
};
struct MaterialMessage {
  std::size_t object = 0;
  std::string key;  // of the scene file: "stiffness_N_m"
  double value = 0;
};
// Asks for the text of the running scene's file, with the changes that are not saved.
struct TextMessage {};
// The text to be run in place of that of the running scene's file, which stays as it is until it is saved.
struct DraftMessage {
  std::size_t number = 0;  // of the page, for the answer
  std::string text;
  std::vector<std::size_t> replaced{};  // numbers of those that waited and that this one takes the place of
};
struct SaveMessage {
  bool replaces = false;  // also a file that another program has changed since it was read
};
// Beside the running scene's file, for it to name. Comes by HTTP: PUT /files/NAME.
struct FileMessage {
  std::string name;
  std::string bytes;
};
inline constexpr std::size_t kMostFileBytes = std::size_t{32} << 20U;
// To the prompt with this number.
struct AnswerMessage {
  std::size_t prompt = 0;
  bool declines = false;
};
struct RecordMessage {
  bool on = false;
};
using PageMessage =
    std::variant<HandMessage, CommandMessage, PickMessage, ParameterMessage, MaterialMessage, TextMessage,
                 DraftMessage, FileMessage, SaveMessage, AnswerMessage, RecordMessage>;

// Throws Error (kUsage) for everything that is not such a message. Parameters are checked against their limits.
[[nodiscard]] PageMessage parse_page_message(std::string_view text);

// Throws Error (kUsage) for a name that is none of a mesh or a grid of heights in this folder.
[[nodiscard]] FileMessage file_message(std::string name, std::string bytes);

[[nodiscard]] Json event_json(std::string_view level, std::string_view name, std::string_view cause,
                              std::string_view remedy);
[[nodiscard]] Json event_json(const Error& error);
// name, cause, remedy, and the place: pointer, line, column.
[[nodiscard]] Json json_of(const SceneIssue& issue);
[[nodiscard]] Json link_json(bool up);

// The double that prints like the float: 0.1F as 0.1.
[[nodiscard]] double exact(float value);

// One line; bytes that are not UTF-8 are replaced.
[[nodiscard]] std::string to_text(const Json& json);

}  // namespace thimble::host
