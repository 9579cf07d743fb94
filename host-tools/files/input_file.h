// Files that are read.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

namespace thimble::host {

// As bytes. Errors: kPermission; kBadInput (cannot-read) where there is no such file, or it is a folder.
[[nodiscard]] std::ifstream open_input(const std::filesystem::path& file);
[[nodiscard]] std::string read_input(const std::filesystem::path& file);  // the whole of it

}  // namespace thimble::host
