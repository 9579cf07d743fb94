#include "host-tools/sweep/sweep_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/files/input_file.h"
#include "host-tools/keys/key_values.h"
#include "host-tools/lab/arm_choice.h"
#include "host-tools/sweep/sweep_keys.h"

namespace thimble::host {
namespace {

struct NumberRow {
  std::string_view name;
  Range range;
  void (*set)(SweepSettings&, double);
  std::string_view text;
  bool of_walls = false;
  bool is_whole = false;
};

const std::vector<NumberRow>& number_rows() {
  using keys::above, keys::from;
  static const std::vector<NumberRow> rows = {
      {"rate_Hz", from(100, 20000, "Hz"), [](SweepSettings& s, double v) { s.press.rate_Hz = v; },
       "ticks a second"},
      {"seed", from(0, 1LL << 53U),
       [](SweepSettings& s, double v) { s.press.seed = static_cast<std::uint64_t>(v); },
       "of the simulated arm: where its encoders begin", false, true},
      {"trial", from(0, 255), [](SweepSettings& s, double v) { s.trial = static_cast<std::uint8_t>(v); },
       "the parameter trial: which force fields act", false, true},
      {"hand_mass_kg", from(0, 10, "kg"), [](SweepSettings& s, double v) { s.press.hand.mass_kg = v; },
       "of the simulated hand"},
      {"hand_stiffness_N_m", above(0, 1e6, "N/m"),
       [](SweepSettings& s, double v) { s.press.hand.stiffness_N_m = v; }, "of the hand's spring"},
      {"hand_damping_N_s_m", from(0, 1e4, "N s/m"),
       [](SweepSettings& s, double v) { s.press.hand.damping_N_s_m = v; }, "of the hand's damper"},
      {"stiffness_N_m", above(0, control::kMaxStiffness_N_m, "N/m"),
       [](SweepSettings& s, double v) { s.press.stiffness_N_m = v; }, "of the wall", true},
      {"damping_N_s_m", from(0, control::kMaxDamping_N_s_m, "N s/m"),
       [](SweepSettings& s, double v) { s.press.damping_N_s_m = v; }, "of the wall", true},
      {"force_N", above(0, 100, "N"), [](SweepSettings& s, double v) { s.press.force_N = v; },
       "that the hand settles at", true},
      {"approach_m_s", above(0, 10, "m/s"), [](SweepSettings& s, double v) { s.press.approach_m_s = v; },
       "at which the hand meets the wall", true},
      {"hold_s", above(0, 1000, "s"), [](SweepSettings& s, double v) { s.press.hold_s = v; },
       "for which the hand presses; the last half of it is the steady part", true},
  };
  return rows;
}

const NumberRow* find_number(std::string_view name) {
  const auto row = std::ranges::find(number_rows(), name, &NumberRow::name);
  return row == number_rows().end() ? nullptr : &*row;
}

// Texts stand in a CSV file.
const Value& plain(const Value& value, const std::string& text) {
  const bool is_plain = std::ranges::none_of(
      text, [](char c) { return c == ',' || c == '"' || (c >= 0 && c < ' ') || c == '\x7f'; });
  if (!is_plain) value.wrong("a text without commas, quotes and control characters");
  return value;
}

SweepValue read_hand(const Value& given) {
  const FilePart part(given, sweep_kind("hand"));
  const board::Hand hand{part.number("mass_kg"), part.number("stiffness_N_m"), part.number("damping_N_s_m")};
  std::string name = part.has("name") ? part.text("name")
                                      : fmt::format("{} kg {} N/m {} N s/m", hand.mass_kg, hand.stiffness_N_m,
                                                    hand.damping_N_s_m);
  if (part.has("name")) static_cast<void>(plain(part.at("name"), name));
  return {std::move(name), [hand](SweepSettings& settings) { settings.press.hand = hand; }};
}

SweepValue read_arm(const Value& given) {
  std::string name = given.text(4096);
  static_cast<void>(plain(given, name));
  std::optional<kinematics::ArmData> data;
  try {
    data = other_arm(name);
  } catch (const Error& error) {
    given.fail(error.name, "is \"" + name + "\": " + error.cause, error.remedy);
  }
  return {name, [name, data](SweepSettings& settings) {
            settings.press.arm = name;
            settings.press.arm_data = data;
          }};
}

}  // namespace

SweepScene::SweepScene(const std::filesystem::path& file) : file_(file), text_(read_input(file)) {
  CompiledScene compiled = compile_scene_text(text_, file_.string(), file_.parent_path());
  plain_ = without_comments(text_);
  ranges_ = find_values(plain_);
  files_ = std::move(compiled.report.files);
  parts_ = std::move(compiled.parts);
}

bool SweepScene::has(const std::string& pointer) const {
  const auto found = ranges_.find(pointer);
  if (found == ranges_.end() || pointer.empty()) return false;
  const char first = plain_[found->second.begin];
  return first != '{' && first != '[';
}

CompiledScene SweepScene::compile(const std::map<std::string, std::string>& values) const {
  std::vector<std::pair<ValueRange, std::string_view>> changes;
  changes.reserve(values.size());
  for (const auto& [pointer, value] : values) changes.emplace_back(ranges_.at(pointer), value);
  std::ranges::sort(changes, [](const auto& a, const auto& b) { return a.first.begin > b.first.begin; });
  std::string text = text_;
  for (const auto& [range, value] : changes) text.replace(range.begin, range.end - range.begin, value);
  return compile_scene_text(text, file_.string(), file_.parent_path(), parts_.get());
}

std::vector<std::string_view> SweepValues::names() const {
  std::vector<std::string_view> names = {"arm", "hand"};
  for (const NumberRow& row : number_rows())
    if (!row.of_walls || scene_ == nullptr) names.push_back(row.name);
  return names;
}

std::string SweepValues::known(const Value& what) const {
  std::string name = what.text(256);
  if (name.starts_with('/')) {
    if (scene_ == nullptr)
      what.fail("unknown-value", "is \"" + name + "\", and this plan has no scene file",
                "name a value of the wall, or give a scene");
    if (!scene_->has(name))
      what.fail("unknown-value", "is \"" + name + "\", which is no number, text or flag of the scene file",
                "give the JSON pointer of a value that stands in the scene file");
    static_cast<void>(plain(what, name));
    return name;
  }
  const std::vector<std::string_view> all = names();
  if (std::ranges::find(all, name) == all.end())
    what.fail("unknown-value", "is \"" + name + "\"; " + suggestion(name, all),
              "name one of these, or the JSON pointer of a value in the scene file");
  return name;
}

SweepValue SweepValues::read(const std::string& what, const Value& given) const {
  if (what == "arm") return read_arm(given);
  if (what == "hand") return read_hand(given);
  if (const NumberRow* row = find_number(what); row != nullptr)
    return number(what, given.number(row->range), given);
  const nlohmann::json& raw = given.raw();
  if (raw.is_structured() || raw.is_null()) given.wrong("a number, a text, true or false");
  std::string text = raw.is_string() ? raw.get<std::string>() : raw.dump();
  static_cast<void>(plain(given, text));
  return {std::move(text),
          [what, json = raw.dump()](SweepSettings& settings) { settings.scene[what] = json; }};
}

SweepValue SweepValues::number(const std::string& what, double number, const Value& place) const {
  return this->number(what, number, fmt::format("{}", number), place);
}
SweepValue SweepValues::number(const std::string& what, float number, const Value& place) const {
  return this->number(what, static_cast<double>(number), fmt::format("{}", number), place);
}

SweepValue SweepValues::number(const std::string& what, double number, std::string text,
                               const Value& place) const {
  const NumberRow* const row = find_number(what);
  if (row == nullptr && !what.starts_with('/')) place.wrong("values one by one: " + what + " is no number");
  if (row != nullptr && (!row->range.holds(number) || (row->is_whole && number != std::floor(number))))
    place.fail("bad-value",
               fmt::format("gives {} for {}, allowed is {}{}", board::number(number), what,
                           describe(row->range), row->is_whole ? ", without decimals" : ""),
               "choose other values");
  if (row != nullptr)
    return {std::move(text), [row, number](SweepSettings& settings) { row->set(settings, number); }};
  return {text, [what, text](SweepSettings& settings) { settings.scene[what] = text; }};
}

std::vector<SweepName> sweep_names() {
  std::vector<SweepName> names = {{"arm", "as `--arm` of `thimble simulate`", false},
                                  {"hand", "an object: name, mass_kg, stiffness_N_m, damping_N_s_m", false}};
  for (const NumberRow& row : number_rows()) names.push_back({row.name, row.text, row.of_walls});
  return names;
}

}  // namespace thimble::host
