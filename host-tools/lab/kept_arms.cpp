#include "host-tools/lab/kept_arms.h"

#include <fmt/format.h>

#include <cstdlib>
#include <optional>
#include <vector>

#include "firmware/link/crc32.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/arms/arm_folder.h"
#include "host-tools/arms/arm_writer.h"
#include "host-tools/error.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/arm_choice.h"

namespace thimble::host {
namespace {

std::filesystem::path kept_file(std::uint32_t crc) {
  return kept_arms_folder() / fmt::format("{:08x}{}", crc, kArmSuffix);
}

// Nothing: there is no such file, it is damaged, or its image is another one.
std::optional<ArmFile> arm_with(const std::filesystem::path& file, std::uint32_t crc) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) return std::nullopt;
  try {
    ArmFile arm = read_arm_file(read_input(file), file.string());
    if (firmware::link::crc32(arm_image(arm)) == crc) return arm;
  } catch (const Error&) {
    return std::nullopt;
  }
  return std::nullopt;
}

// Kept, or one that comes with Thimble.
std::optional<ArmFile> file_of(std::uint32_t crc) {
  std::vector<std::filesystem::path> files = arm_files();
  files.insert(files.begin(), kept_file(crc));
  for (const std::filesystem::path& file : files)
    if (std::optional<ArmFile> arm = arm_with(file, crc)) return arm;
  return std::nullopt;
}

}  // namespace

std::filesystem::path kept_arms_folder() {
  const std::filesystem::path end = std::filesystem::path("thimble") / "arms";
  if (const char* data = std::getenv("XDG_DATA_HOME"); data != nullptr && *data != '\0')
    return std::filesystem::path(data) / end;
  const char* home = std::getenv("HOME");
  return std::filesystem::path(home == nullptr ? "." : home) / ".local" / "share" / end;
}

void keep_arm(const std::string& text, std::uint32_t crc) {
  std::error_code error;
  std::filesystem::create_directories(kept_arms_folder(), error);
  if (error)
    throw Error(ExitCode::kPermission, "cannot-write", kept_arms_folder().string() + ": " + error.message(),
                "see who may write there");
  OutputFile file(kept_file(crc));
  file.stream() << text;
  file.commit();
}

ArmWalls walls_of_device(const std::string& name, std::uint32_t crc) {
  if (crc == 0) return known_walls(name);
  const std::optional<ArmFile> arm = file_of(crc);
  return arm ? walls_of(*arm, "its arm file") : known_walls(name);
}

std::optional<kinematics::ArmData> data_of_device(const std::string& name, std::uint32_t crc) {
  if (crc != 0) {
    const std::optional<ArmFile> arm = file_of(crc);
    return arm ? std::optional(arm_data(*arm)) : std::nullopt;
  }
  try {
    return chosen_arm(name).data;
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace thimble::host
