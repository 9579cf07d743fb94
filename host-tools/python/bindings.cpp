// thimble._thimble: the client library, the compiler, the simulation and recordings for Python. The modules beside thimble/__init__.py are the
// part that a person reads.
#include <pybind11/pybind11.h>

#include "host-tools/python/arm_binding.h"
#include "host-tools/python/connection_binding.h"
#include "host-tools/python/recording_binding.h"
#include "host-tools/python/scene_binding.h"
#include "host-tools/python/simulation_binding.h"

PYBIND11_MODULE(_thimble, m) {
  thimble::host::bind_errors(m);
  thimble::host::bind_scene(m);
  thimble::host::bind_simulation(m);
  thimble::host::bind_arm(m);
  thimble::host::bind_connection(m);
  thimble::host::bind_recording(m);
}
