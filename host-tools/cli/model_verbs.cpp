// model: arm files are checked, shown, listed, and made from a URDF.
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <optional>

#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/arms/arm_writer.h"
#include "host-tools/arms/urdf_import.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/arm_upload.h"
#include "host-tools/client/device.h"
#include "host-tools/commission/expectation.h"
#include "host-tools/files/image_file.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/kept_arms.h"

namespace thimble::host {
namespace {

struct CheckedArm {
  ArmFile arm;
  ArmFigures figures;
};
CheckedArm read_and_check(const std::filesystem::path& path) {
  CheckedArm checked{read_arm_file(read_input(path), path.string()), {}};
  checked.figures = check_arm(checked.arm, path.string());
  return checked;
}

std::string summary(const CheckedArm& checked) {
  const auto counted = [](std::size_t count, const char* one, const char* many) {
    return fmt::format("{} {}", count, count == 1 ? one : many);
  };
  return fmt::format("{}, {}, {}, {}", checked.arm.family, counted(checked.arm.axes.size(), "axis", "axes"),
                     counted(static_cast<std::size_t>(checked.figures.force_dof), "force", "forces"),
                     counted(static_cast<std::size_t>(checked.figures.pose_dof), "position", "positions"));
}

Json to_json(const CheckedArm& checked) {
  const ArmFigures& figures = checked.figures;
  Json json{{"name", checked.arm.name},
            {"family", checked.arm.family},
            {"force_dof", figures.force_dof},
            {"pose_dof", figures.pose_dof},
            {"home_tip_m", {figures.home_tip_m.x(), figures.home_tip_m.y(), figures.home_tip_m.z()}},
            {"singular_values_m", figures.singular_values},
            {"least_peak_force_N", figures.least_peak_force_N},
            {"most_peak_force_N", figures.most_peak_force_N},
            {"max_force_N", checked.arm.max_force_N},
            {"commissioned", checked.arm.is_commissioned ? Json(checked.arm.commissioned_on) : Json()},
            {"axes", Json::array()},
            {"warnings", figures.warnings}};
  for (std::size_t j = 0; j < checked.arm.axes.size(); ++j) {
    const ArmAxis& axis = checked.arm.axes[j];
    json["axes"].push_back({{"name", axis.name},
                            {"driven", axis.drive.has_value()},
                            {axis.is_prismatic ? "lower_m" : "lower_rad", axis.lower.value},
                            {axis.is_prismatic ? "upper_m" : "upper_rad", axis.upper.value},
                            {axis.is_prismatic ? "home_m" : "home_rad", axis.home.value},
                            {"count_m", figures.axes[j].count_m},
                            {"peak_force_N", figures.axes[j].peak_force_N}});
  }
  return json;
}

// In mm, without the sign of a nought.
double tenths_of_mm(double metres) { return std::round(1e4 * metres) / 10.0 + 0.0; }

void warn(const ArmFigures& figures) {
  for (const std::string& warning : figures.warnings) say(stderr, "warning: {}\n", warning);
}

// What check_arm() throws.
std::optional<Error> refusal(const ArmFile& arm, const std::string& file) {
  try {
    static_cast<void>(check_arm(arm, file));
    return std::nullopt;
  } catch (const Error& error) {
    return error;
  }
}

}  // namespace

void model_check(const Common& common, const std::string& model) {
  const CheckedArm checked = read_and_check(arm_path(model));
  if (common.json) {
    Json json = document("model check");
    json.update(to_json(checked));
    print(json);
    return;
  }
  say("{}: {}\n", checked.arm.name, summary(checked));
  warn(checked.figures);
}

void model_show(const Common& common, const std::string& model) {
  const CheckedArm checked = read_and_check(arm_path(model));
  const ArmFile& arm = checked.arm;
  const ArmFigures& figures = checked.figures;
  if (common.json) {
    Json json = document("model show");
    json.update(to_json(checked));
    json["description"] = arm.description;
    json["source"] = arm.source;
    print(json);
    return;
  }
  say("{}: {}\n", arm.name, summary(checked));
  if (!arm.description.empty()) say("  {}\n", arm.description);
  say("  figures: {}\n", arm.source);
  say("  at home the tip is at {:.1f}, {:.1f}, {:.1f} mm in the world, from the base; the motors give {:.2f} "
      "to {:.2f} N "
      "there, allowed are {:.2f} N\n",
      tenths_of_mm(figures.home_tip_m.x()), tenths_of_mm(figures.home_tip_m.y()),
      tenths_of_mm(figures.home_tip_m.z()), figures.least_peak_force_N, figures.most_peak_force_N,
      arm.max_force_N);
  say("  {:<12} {:>22} {:>10} {:>14} {:>12}\n", "axis", "range", "home", "count at tip", "peak force");
  for (std::size_t j = 0; j < arm.axes.size(); ++j) {
    const ArmAxis& axis = arm.axes[j];
    const double scale = axis.is_prismatic ? 1e3 : 180.0 / std::numbers::pi;
    const char* unit = axis.is_prismatic ? "mm" : "deg";
    say("  {:<12} {:>22} {:>10} {:>14} {:>12}\n", axis.name,
        fmt::format("{:.1f} to {:.1f} {}", scale * axis.lower.value, scale * axis.upper.value, unit),
        fmt::format("{:.1f} {}", scale * axis.home.value, unit),
        fmt::format("{:.1f} um", 1e6 * figures.axes[j].count_m),
        axis.drive ? fmt::format("{:.2f} N", figures.axes[j].peak_force_N) : "no motor");
  }
  say("  commissioned: {}\n", arm.is_commissioned ? arm.commissioned_on : "no");
  warn(figures);
}

void model_compile(const Common& common, const ModelCompileChoice& choice) {
  const std::filesystem::path path = arm_path(choice.model);
  keep_apart(path, choice.output);
  const CheckedArm checked = read_and_check(path);
  const std::vector<std::byte> image = arm_image(checked.arm);
  write_image(choice.output, image);
  if (common.json) {
    Json json = document("model compile");
    json["name"] = checked.arm.name;
    json["image"] = choice.output.string();
    json["bytes"] = image.size();
    print(json);
    return;
  }
  say("{}: {}, {} bytes\n", choice.output.string(), checked.arm.name, image.size());
  warn(checked.figures);
}

void model_upload(const Common& common, const Remote& remote, const ModelUploadChoice& choice) {
  const std::filesystem::path path = arm_path(choice.model);
  const CheckedArm checked = read_and_check(path);
  const std::vector<std::byte> image = arm_image(checked.arm);
  Device device = open_device(common, remote);
  if (choice.arm >= device.info().arms) {
    throw Error(
        ExitCode::kUsage, "no-such-arm",
        fmt::format("--number {}: the device has {} arm(s), counted from 0", choice.arm, device.info().arms),
        "give the number of an arm that it has");
  }
  std::optional<Busy> busy(std::in_place, common.json, "storing the arm and restarting the device");
  const auto [result, arms] = replace_arm([&] { return open_remote(remote); }, std::move(device),
                                          static_cast<std::uint8_t>(choice.arm), checked.arm.name, image);
  busy.reset();
  std::vector<std::string> warnings = checked.figures.warnings;
  if (checked.arm.commissioned_on.empty() && checked.arm.max_force_N > kTipForce_N)
    warnings.push_back(
        "this arm has not passed `thimble commission`: the device refuses to arm it with a max_force above 1 "
        "N");
  try {
    keep_arm(read_input(path), result.crc);
  } catch (const Error& error) {
    warnings.push_back("`thimble upload` will not know which walls this arm holds: " + error.cause);
  }
  if (common.json) {
    Json json = document("model upload");
    json["name"] = checked.arm.name;
    json["arm"] = arms;
    json["number"] = choice.arm;
    json["bytes"] = result.bytes;
    json["crc"] = result.crc;
    json["warnings"] = warnings;
    print(json);
    return;
  }
  say("{}: {} bytes, CRC {:08x}, stored and in use\n", checked.arm.name, result.bytes, result.crc);
  for (const std::string& warning : warnings) say(stderr, "warning: {}\n", warning);
}

void model_list(const Common& common) {
  Json json = document("model list");
  json["models"] = Json::array();
  for (const std::filesystem::path& path : arm_files()) {
    const CheckedArm checked = read_and_check(path);
    if (common.json) {
      json["models"].push_back({{"name", checked.arm.name},
                                {"family", checked.arm.family},
                                {"force_dof", checked.figures.force_dof},
                                {"pose_dof", checked.figures.pose_dof},
                                {"file", path.string()}});
    } else {
      say("{:<14} {}\n", checked.arm.name, summary(checked));
    }
  }
  if (common.json) print(json);
}

void model_import(const Common& common, const ModelImportChoice& choice) {
  keep_apart(choice.urdf, choice.output);
  const std::string name = choice.output.filename().string();
  if (!name.ends_with(kArmSuffix) || name == kArmSuffix)
    throw Error(ExitCode::kUsage, "bad-output",
                fmt::format("'{}' is not the name of an arm file", choice.output.string()),
                "give a name that ends with .arm.json");
  const std::string text = import_urdf(
      read_input(choice.urdf), name.substr(0, name.size() - std::string(kArmSuffix).size()), choice.tip);
  const ArmFile arm = read_arm_file(text, choice.urdf.string() + " as an arm file");
  OutputFile output(choice.output);
  output.stream() << text;
  output.commit();
  // The file is there to be edited: what has to be, beside the guesses.
  const std::optional<Error> refused = refusal(arm, choice.output.string());
  if (common.json) {
    Json json = document("model import");
    json["model"] = choice.output.string();
    json["name"] = arm.name;
    json["axes"] = arm.joints;
    json["guesses"] = {"encoder", "drive", "motor", "limits"};
    json["refused"] = refused ? Json(refused->name) : Json();
    print(json);
  } else {
    say("{}: {} axes. Encoders, drives, motors and limits are guesses: replace them, then `thimble model "
        "check {}`\n",
        choice.output.string(), arm.axes.size(), choice.output.string());
  }
  if (refused)
    say(stderr, "warning: as it is, `thimble model check` refuses it: {}: {}; {}\n", refused->name,
        refused->cause, refused->remedy);
}

}  // namespace thimble::host
