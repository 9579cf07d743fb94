// thimble._thimble.Recording: a recording of a device (docs/recording.md) as arrays.
#pragma once

#include <pybind11/pybind11.h>

namespace thimble::host {

void bind_recording(pybind11::module_& m);

}  // namespace thimble::host
