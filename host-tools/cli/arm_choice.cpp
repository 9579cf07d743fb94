#include "host-tools/cli/arm_choice.h"

#include <filesystem>

#include "board/sim/plant.h"
#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {

std::optional<kinematics::ArmData> other_arm(const std::string& name) {
  if (board::find_plant_variant(name) != nullptr) return std::nullopt;
  const std::filesystem::path path = arm_path(name);
  if (!std::filesystem::exists(path))
    throw Error(ExitCode::kUsage, "unknown-arm", "there is no arm and no arm file named " + name,
                "`thimble model list` names the arms; an arm file ends with .arm.json");
  const ArmFile arm = read_arm_file(read_input(path), path.string());
  static_cast<void>(check_arm(arm, path.string()));
  return arm_data(arm);
}

}  // namespace thimble::host
