#include "host-tools/lab/arm_choice.h"

#include <filesystem>

#include "board/files/text_file.h"
#include "board/sim/arm_image_file.h"
#include "board/sim/plant.h"
#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

std::optional<kinematics::ArmData> read_image(const std::filesystem::path& path) {
  try {
    return board::arm_of_image(path.string());
  } catch (const board::ArmImageError& error) {
    throw Error(ExitCode::kBadInput, "bad-arm-image", error.cause, error.remedy);
  } catch (const board::FileError& error) {
    throw Error(ExitCode::kBadInput, "cannot-read", error.what(), "give an arm image that can be read");
  }
}

}  // namespace

ArmWalls walls_of(const ArmFile& arm, const std::string& file) {
  if (arm.largest_walls.empty()) return known_walls(arm.name);
  ArmWalls walls{.arm = arm.name, .walls = {}, .source = "limits.largest_walls of " + file};
  walls.walls.reserve(arm.largest_walls.size());
  for (const ArmWall& wall : arm.largest_walls)
    walls.walls.push_back({wall.rate_Hz, wall.damping_N_s_m, wall.stiffness_N_m.value});
  return walls;
}

ArmChoice chosen_arm(const std::string& name) {
  if (const board::PlantVariant* variant = board::find_plant_variant(name); variant != nullptr)
    return {name, board::PlantParameters::from(*variant).model, known_walls(name)};
  const std::filesystem::path path = arm_path(name);
  if (!std::filesystem::exists(path))
    throw Error(ExitCode::kUsage, "unknown-arm", "there is no arm and no arm file named " + name,
                "`thimble model list` names the arms; an arm file ends with .arm.json, an image with .tarm");
  if (const std::optional<kinematics::ArmData> image = read_image(path)) {
    const std::string arm(kinematics::name_of(*image));
    return {arm, *image, known_walls(arm)};
  }
  const ArmFile arm = read_arm_file(read_input(path), path.string());
  static_cast<void>(check_arm(arm, path.string()));
  return {arm.name, arm_data(arm), walls_of(arm, path.filename().string())};
}

std::optional<kinematics::ArmData> other_arm(const std::string& name) {
  if (board::find_plant_variant(name) != nullptr) return std::nullopt;
  return chosen_arm(name).data;
}

}  // namespace thimble::host
