// Scenes for thimble._thimble: compiled, checked, changed; and the errors of all bindings.
#pragma once

#include <pybind11/pybind11.h>

namespace thimble::host {

void bind_errors(pybind11::module_& m);
void bind_scene(pybind11::module_& m);

}  // namespace thimble::host
