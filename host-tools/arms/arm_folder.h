// The arm files that come with Thimble.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace thimble::host {

inline constexpr const char* kArmSuffix = ".arm.json";

// Beside the program: installed, or in its build folder. Sorted by name; empty if there is no such folder.
[[nodiscard]] std::vector<std::filesystem::path> arm_files();

// The file of an arm that comes with Thimble by its name, or the path as it is.
[[nodiscard]] std::filesystem::path arm_path(const std::string& name_or_path);

}  // namespace thimble::host
