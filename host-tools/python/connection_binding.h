// thimble._thimble.Connection and discover(): devices on the link.
#pragma once

#include <pybind11/pybind11.h>

namespace thimble::host {

void bind_connection(pybind11::module_& m);

}  // namespace thimble::host
