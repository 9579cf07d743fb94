// What the bindings share.
#pragma once

#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string_view>
#include <vector>

namespace thimble::host {

// Ctrl-C in the middle of a call that has released the interpreter.
inline void heed_python() {
  const pybind11::gil_scoped_acquire python;
  if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
}

inline std::vector<std::byte> bytes_of(const pybind11::bytes& given) {
  const std::string_view view = given;
  std::vector<std::byte> copy(view.size());
  if (!view.empty()) std::memcpy(copy.data(), view.data(), view.size());
  return copy;
}

inline pybind11::bytes to_python(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace thimble::host
