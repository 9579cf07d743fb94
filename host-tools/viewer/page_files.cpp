#include "host-tools/viewer/page_files.h"

#include <algorithm>
#include <array>
#include <cstddef>

// Of the generated page_files.S, which holds the bytes.
#define THIMBLE_PAGE_FILE(number, path, type)    \
  extern "C" const char thimble_page_##number[]; \
  extern "C" const char thimble_page_##number##_end[];
#include "thimble_page/page_files.inc"
#undef THIMBLE_PAGE_FILE

namespace thimble::host {

std::span<const PageFile> page_files() {
#define THIMBLE_PAGE_FILE(number, path, type) \
  PageFile{path,                              \
           type,                              \
           {thimble_page_##number,            \
            static_cast<std::size_t>(thimble_page_##number##_end - thimble_page_##number)}},
  static const auto files = std::to_array<PageFile>({
#include "thimble_page/page_files.inc"
  });
#undef THIMBLE_PAGE_FILE
  return files;
}

const PageFile* find_page_file(std::string_view path) {
  if (path == "/") path = "/index.html";
  const std::span<const PageFile> files = page_files();
  const auto found = std::ranges::find(files, path, &PageFile::path);
  return found == files.end() ? nullptr : &*found;
}

}  // namespace thimble::host
