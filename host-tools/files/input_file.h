// Files that are read.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <string>

namespace thimble::host {

// Six hours of a recording.
inline constexpr std::size_t kMostInputBytes = std::size_t{1} << 29U;

// As bytes. Errors: kPermission; kBadInput (cannot-read) where there is no such file, or it is a folder or a device, which may have no end.
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);
[[nodiscard]] std::string read_input(
    const std::filesystem::path& file);  // the whole of it; kBadInput (too-large)

}  // namespace thimble::host
