// What a page calls: C functions, and a buffer for whatever goes in or out.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#define EXPORT(type, name) extern "C" __attribute__((export_name(#name))) type name

namespace thimble::host {

inline std::string
    page_buffer;  // NOLINT(cppcoreguidelines-avoid-non-const-global-variables): one page, one thread

inline int give(std::string_view bytes) {
  page_buffer.assign(bytes);
  return static_cast<int>(bytes.size());
}

}  // namespace thimble::host

// A place for `bytes` bytes that go in; it moves when it grows.
EXPORT(char*, page_in)(std::size_t bytes) {
  thimble::host::page_buffer.resize(bytes);
  return thimble::host::page_buffer.data();
}
// What the last call gave: as many bytes as it returned.
EXPORT(const char*, page_out)() { return thimble::host::page_buffer.data(); }
