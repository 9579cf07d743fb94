// new and show: the beginning and the overview of a scene.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/cli/cost_json.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/scene_tree.h"

namespace thimble::host {
namespace {

constexpr std::string_view kBeforeName = R"({
  "thimble_scene": 1,
  "name": ")";
constexpr std::string_view kAfterName = R"(",
  "description": "A floor, a block to slide along, and a drawer that clicks.",

  // Gravity acts on what moves. All numbers are in metres, newtons, kilograms and seconds; z points up.
  "gravity_m_s2": [0, 0, -9.81],

  "materials": {
    "wood": { "stiffness_N_m": 800, "damping_N_s_m": 1, "static_friction": 0.5, "dynamic_friction": 0.4 },
    "ice": { "stiffness_N_m": 1000, "damping_N_s_m": 1 }
  },

  "objects": [
    {
      "name": "floor",
      "shape": { "plane": { "normal": [0, 0, 1], "offset_m": -0.03 } },
      "material": "wood"
    },
    {
      "name": "block",
      "shape": { "box": { "size_m": [0.04, 0.04, 0.02] } },
      "pose": { "position_m": [-0.04, 0, -0.02] },
      "material": "ice"
    },
    {
      // It slides along x from where it is, 2 cm either way, and holds every 5 mm.
      "name": "drawer",
      "shape": { "box": { "size_m": [0.02, 0.03, 0.02] } },
      "pose": { "position_m": [0.04, 0, -0.015] },
      "material": "wood",
      "body": {
        "motion": "slide",
        "axis": [1, 0, 0],
        "mass_kg": 0.05,
        "control": {
          "friction_N": 0.2,
          "damping_N_s_m": 0.5,
          "low_m": -0.02,
          "high_m": 0.02,
          "detents": { "pitch_m": 0.005, "force_N": 0.8 }
        }
      }
    }
  ]
}
)";

std::string sides(const SceneTreeObject& object) {
  const auto& [x, y, z] = object.size_m;
  if (std::isinf(x) && std::isinf(y)) return "without end";
  return fmt::format("{:.3g} x {:.3g} x {:.3g} mm", 1e3 * x, 1e3 * y, 1e3 * z);
}

std::vector<std::string> branches(const SceneTreeObject& object) {
  std::vector<std::string> lines;
  std::string feel = fmt::format("feels: {:g} N/m, {:g} N s/m", object.stiffness_N_m, object.damping_N_s_m);
  if (object.stiffness_N_m == 0) {
    lines.push_back(fmt::format("acts: {}", fmt::join(object.effects, ", ")));
    return lines;
  }
  if (object.static_friction > 0 || object.dynamic_friction > 0)
    feel += fmt::format(", friction {:g} at rest, {:g} in motion", object.static_friction,
                        object.dynamic_friction);
  for (const std::string& effect : object.effects) feel += ", " + effect;
  lines.push_back(feel);
  if (!object.motion.empty()) {
    const std::string with =
        object.control.empty() ? "" : fmt::format("; {}", fmt::join(object.control, ", "));
    lines.push_back(fmt::format("moves: {}, {:g} kg{}", object.motion, object.mass_kg, with));
  }
  if (object.triangles > 0) lines.push_back(fmt::format("{} triangles", object.triangles));
  if (object.bytes > 0) lines.push_back(fmt::format("{} bytes of the image", object.bytes));
  return lines;
}

Json to_json(const SceneTreeObject& object) {
  Json json = {{"name", object.name}, {"shape", object.shape}};
  json["size_m"] = object.size_m;  // null: without end
  json["position_m"] = object.position_m;
  if (object.stiffness_N_m > 0)
    json["material"] = {{"stiffness_N_m", object.stiffness_N_m},
                        {"damping_N_s_m", object.damping_N_s_m},
                        {"static_friction", object.static_friction},
                        {"dynamic_friction", object.dynamic_friction}};
  json["effects"] = object.effects;
  if (!object.motion.empty())
    json["body"] = {{"motion", object.motion}, {"mass_kg", object.mass_kg}, {"control", object.control}};
  json["triangles"] = object.triangles;
  json["bytes"] = object.bytes;
  return json;
}

}  // namespace

void new_scene(const Common& common, const std::string& name) {
  const std::filesystem::path named = name;
  std::string stem = named.filename().string();
  const std::string suffix = ".scene.json";
  if (stem.ends_with(suffix)) stem.erase(stem.size() - suffix.size());
  const bool is_plain = !stem.empty() && std::ranges::all_of(stem, [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '-' || letter == '_' || letter == ' ';
  });
  if (!is_plain || stem.size() > 31)
    throw Error(ExitCode::kUsage, "bad-name", "\"" + stem + "\" is no name of a scene",
                "take letters, digits, -, _ and spaces, 31 at most");
  const std::filesystem::path file = named.parent_path() / (stem + suffix);
  if (std::filesystem::exists(file))
    throw Error(ExitCode::kRefused, "file-exists", file.string() + " is there already",
                "choose another name");
  OutputFile output(file);
  output.stream() << kBeforeName << stem << kAfterName;
  output.commit();
  if (common.json) {
    Json json = document("new");
    json["scene"] = file.string();
    print(json);
  } else {
    say("{}: a floor, a block and a drawer. See it with `thimble view --scene {}`: what you save is felt at "
        "once\n",
        file.string(), file.string());
  }
}

void show(const Common& common, const ShowChoice& choice) {
  const CompiledScene compiled = compile_scene(choice.scene);
  const std::vector<SceneTreeObject> tree = scene_tree(compiled);
  std::vector<CostReport> costs;
  for (const board::BoardCost& board : board::board_costs())
    costs.push_back(cost_report(compiled.image, board, choice.rate_Hz));
  if (common.json) {
    Json json = document("show");
    json["scene"] = compiled.report.name;
    json["bytes"] = compiled.image.size();
    json["tip_radius_m"] = compiled.report.tip_radius_m;
    json["objects"] = Json::array();
    for (const SceneTreeObject& object : tree) json["objects"].push_back(to_json(object));
    json["costs"] = Json::array();
    for (const CostReport& cost : costs)
      if (!cost.text.empty()) json["costs"].push_back(to_json(cost));
    json["warnings"] = compiled.report.warnings;
    print(json);
    return;
  }
  say("{}: {} object{}, {} bytes\n", compiled.report.name, tree.size(), tree.size() == 1 ? "" : "s",
      compiled.image.size());
  for (const SceneTreeObject& object : tree) {
    const bool last = &object == &tree.back();
    const auto& [x, y, z] = object.position_m;
    say("{} {}: {}, {}, at ({:g}, {:g}, {:g}) mm\n", last ? "└─" : "├─", object.name, object.shape,
        sides(object), 1e3 * x, 1e3 * y, 1e3 * z);
    const std::vector<std::string> lines = branches(object);
    for (const std::string& line : lines)
      say("{}  {} {}\n", last ? " " : "│", &line == &lines.back() ? "└─" : "├─", line);
  }
  for (const CostReport& cost : costs)
    if (!cost.text.empty()) say("{}\n", cost.text);
  for (const std::string& warning : compiled.report.warnings) say(stderr, "warning: {}\n", warning);
}

}  // namespace thimble::host
