// The page as it was built into this program (CMakeLists.txt): every file under its address.
#pragma once

#include <span>
#include <string_view>

namespace thimble::host {

struct PageFile {
  std::string_view path;  // "/index.html"
  std::string_view type;  // "text/html; charset=utf-8"
  std::string_view bytes;
};
[[nodiscard]] std::span<const PageFile> page_files();
// Null: there is no such file.
[[nodiscard]] const PageFile* find_page_file(std::string_view path);

}  // namespace thimble::host
