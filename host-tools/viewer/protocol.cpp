#include "host-tools/viewer/protocol.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <utility>

#include "board/files/json_value.h"

namespace thimble::host {
namespace {

[[noreturn]] void nonsense(const std::string& why) {
  throw Error(ExitCode::kUsage, "bad-message", "the page sent what is no message: " + why,
              "reload the page; pages and servers of one release belong together");
}

const Json& member(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end()) nonsense(std::string("no \"") + key + "\"");
  return *found;
}

double number(const Json& json, const char* what) {
  if (!json.is_number()) nonsense(std::string("\"") + what + "\" is not a number");
  const double value = json.get<double>();
  if (!std::isfinite(value)) nonsense(std::string("\"") + what + "\" is not finite");
  return value;
}

std::size_t index_of(const Json& json, const char* key, double most = 1e6) {
  const double value = number(member(json, key), key);
  if (value < 0 || value > most || value != std::floor(value))
    nonsense(std::string("\"") + key + "\" is not an index");
  return static_cast<std::size_t>(value);
}

std::string text_of(const Json& json, const char* key) {
  const Json& value = member(json, key);
  if (!value.is_string()) nonsense(std::string("\"") + key + "\" is not a text");
  return value.get<std::string>();
}

HandMessage read_hand(const Json& json) {
  HandMessage hand;
  hand.arm = index_of(json, "arm");
  const Json& position = member(json, "position_m");
  if (!position.is_array() || position.size() != hand.position_m.size())
    nonsense("\"position_m\" has not three numbers");
  for (std::size_t i = 0; i < hand.position_m.size(); ++i)
    hand.position_m[i] = number(position[i], "position_m");
  return hand;
}

CommandMessage read_command(const Json& json) {
  const std::string verb = text_of(json, "verb");
  for (const auto& [name, command] :
       {std::pair{"home", ViewCommand::kHome}, std::pair{"arm", ViewCommand::kArm},
        std::pair{"disarm", ViewCommand::kDisarm}, std::pair{"clear", ViewCommand::kClear},
        std::pair{"stop", ViewCommand::kStop}}) {
    if (verb == name) return {command};
  }
  nonsense("\"verb\" is not home, arm, disarm, clear or stop");
}

ParameterMessage read_parameter(const Json& json) {
  const std::string name = text_of(json, "name");
  const firmware::ParamRow* row = firmware::find_param(std::string_view(name));
  if (row == nullptr) {
    throw Error(ExitCode::kUsage, "unknown-parameter", "there is no parameter of that name",
                "`thimble param list` names them");
  }
  const double value = number(member(json, "value"), "value");
  const bool whole = row->type == firmware::ParamType::kFloat || std::floor(value) == value;
  if (!whole || value < static_cast<double>(row->min) || value > static_cast<double>(row->max)) {
    throw Error(ExitCode::kUsage, "bad-value",
                name + " is a " + (whole ? "number" : "whole number") + " from " +
                    Json(exact(row->min)).dump() + " to " + Json(exact(row->max)).dump() + " " + row->unit,
                "choose a value in that range");
  }
  return {row, value};
}

MaterialMessage read_material_message(const Json& json) {
  MaterialMessage material;
  material.object = index_of(json, "object");
  material.value = number(member(json, "value"), "value");
  const std::string key = text_of(json, "key");
  for (const auto& [name, in_file] :
       {std::pair{"stiffness", "stiffness_N_m"}, std::pair{"damping", "damping_N_s_m"},
        std::pair{"static_friction", "static_friction"}, std::pair{"dynamic_friction", "dynamic_friction"}}) {
    if (key == name) material.key = in_file;
  }
  if (material.key.empty())
    nonsense("\"key\" is not stiffness, damping, static_friction or dynamic_friction");
  return material;
}

DraftMessage read_draft(const Json& json) {
  constexpr double kMostNumber = 2147483647;  // a page begins anywhere, and a drag makes many
  DraftMessage draft{index_of(json, "number", kMostNumber), text_of(json, "text"), {}};
  if (draft.text.size() <= kMostDraftBytes) return draft;
  throw Error(ExitCode::kUsage, "scene-file-too-large", "the text of the scene is longer than 1 MiB",
              "put large data into files that the scene names");
}

SaveMessage read_save(const Json& json) {
  const auto replaces = json.find("replaces");
  if (replaces == json.end()) return {};
  if (!replaces->is_boolean()) nonsense("\"replaces\" is not true or false");
  return {replaces->get<bool>()};
}

AnswerMessage read_answer(const Json& json) {
  const std::string answer = text_of(json, "answer");
  if (answer != "done" && answer != "decline") nonsense("\"answer\" is not done or decline");
  return {index_of(json, "prompt"), answer == "decline"};
}

RecordMessage read_record(const Json& json) {
  const Json& on = member(json, "on");
  if (!on.is_boolean()) nonsense("\"on\" is not true or false");
  return {on.get<bool>()};
}

}  // namespace

PageMessage parse_page_message(std::string_view text) {
  if (text.size() > kMostDraftMessageBytes) nonsense("it is longer than a message may be");
  // The parser takes a NUL for the end of the text.
  if (text.find('\0') != std::string_view::npos) nonsense("it has a NUL character");
  // What is deeper than any message goes is left out, so that it takes no memory.
  constexpr int kDepth = 2;
  const Json json = Json::parse(
      text, [](int depth, Json::parse_event_t, const Json&) { return depth <= kDepth; }, false);
  if (!json.is_object()) nonsense("not a JSON object");
  const std::string type = text_of(json, "type");
  if (type == "draft") return read_draft(json);
  if (text.size() > kMostMessageBytes) nonsense("it is longer than a message may be");
  if (type == "hand") return read_hand(json);
  if (type == "command") return read_command(json);
  if (type == "pick") return PickMessage{text_of(json, "scene")};
  if (type == "parameter") return read_parameter(json);
  if (type == "material") return read_material_message(json);
  if (type == "text") return TextMessage{};
  if (type == "save") return read_save(json);
  if (type == "answer") return read_answer(json);
  if (type == "record") return read_record(json);
  nonsense("its \"type\" is unknown");
}

FileMessage file_message(std::string name, std::string bytes) {
  constexpr std::size_t kMostName = 100;
  constexpr std::string_view kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-";
  constexpr std::array<std::string_view, 14> kEndings = {".obj",  ".mtl", ".stl", ".ply", ".off",
                                                         ".gltf", ".glb", ".bin", ".plg", ".dae",
                                                         ".fbx",  ".3ds", ".png", ".csv"};
  std::string small = name;
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return std::tolower(c); });
  const bool ends = std::ranges::any_of(kEndings, [&](std::string_view ending) {
    return small.size() > ending.size() && small.ends_with(ending);
  });
  if (!ends || name.size() > kMostName || name.starts_with('.') ||
      name.find_first_not_of(kAllowed) != std::string::npos) {
    throw Error(ExitCode::kUsage, "bad-file-name",
                "a file that is added to a scene is a mesh (.obj, .stl, .ply, .off, .gltf, .plg ...) or a "
                "grid of heights (.png, "
                ".csv), with letters, digits, '.', '_' and '-' in its name",
                "rename the file");
  }
  return {std::move(name), std::move(bytes)};
}

Json event_json(std::string_view level, std::string_view name, std::string_view cause,
                std::string_view remedy) {
  return {{"type", "event"}, {"level", level}, {"name", name}, {"cause", cause}, {"remedy", remedy}};
}

Json json_of(const SceneIssue& issue) {
  return {{"name", issue.name},       {"cause", issue.cause},     {"remedy", issue.remedy},
          {"pointer", issue.pointer}, {"line", issue.place.line}, {"column", issue.place.column}};
}

Json event_json(const Error& error) { return event_json("error", error.name, error.cause, error.remedy); }

Json link_json(bool up) { return {{"type", "link"}, {"up", up}}; }

double exact(float value) { return board::as_written(value); }

std::string to_text(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

}  // namespace thimble::host
