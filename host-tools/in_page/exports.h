// What a page calls, and what calls it: C functions, and a buffer for whatever goes in or out.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#define THIMBLE_EXPORT(type, name) extern "C" __attribute__((export_name(#name))) type name
#define THIMBLE_IMPORT(type, name) \
  extern "C" __attribute__((import_module("page"), import_name(#name))) type page_##name

namespace thimble::host {

inline std::string page_buffer;

inline int give(std::string_view bytes) {
  page_buffer.assign(bytes);
  return static_cast<int>(bytes.size());
}

}  // namespace thimble::host

// A place for `bytes` bytes that go in; it moves when it grows.
THIMBLE_EXPORT(char*, place)(std::size_t bytes) {
  thimble::host::page_buffer.resize(bytes);
  return thimble::host::page_buffer.data();
}
// What the last call gave: as many bytes as it returned.
THIMBLE_EXPORT(const char*, given)() { return thimble::host::page_buffer.data(); }
