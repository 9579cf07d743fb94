// The arm files that `thimble model upload` has stored on devices from this machine: a device has the image of its arm, which does not say which walls
// the arm holds.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/compiler/stable_stiffness.h"

namespace thimble::host {

// $XDG_DATA_HOME/thimble/arms, or ~/.local/share/thimble/arms.
[[nodiscard]] std::filesystem::path kept_arms_folder();

// text: of an arm file, crc: of its image. The last file with an image is the one that is kept. Throws Error (kPermission, kRefused).
void keep_arm(const std::string& text, std::uint32_t crc);

// Of the arm of a device. crc: of its stored image; 0: it has none. By the file with such an image, kept or one that comes with Thimble; where
// there is none, by the name.
[[nodiscard]] ArmWalls walls_of_device(const std::string& name, std::uint32_t crc);
// The same for its numbers; nothing: no such arm is known here. An arm without a stored image is taken to be what is known by its name.
[[nodiscard]] std::optional<kinematics::ArmData> data_of_device(const std::string& name, std::uint32_t crc);

}  // namespace thimble::host
