// thimble._thimble.simulate() and Simulation: runs on the simulated arm, and their rows as arrays.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/lab/scene_columns.h"

namespace thimble::host {

inline constexpr std::size_t kHeedRows = 4096;  // between two looks at Ctrl-C

// The rows of a run, without padding: the columns that every scene has, then those of this one.
class SimulationRows {
 public:
  explicit SimulationRows(const SceneColumns& scene);

  void add(const board::LogRow& row);
  void clear() {
    bytes_.clear();
    count_ = 0;
  }
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] pybind11::array to_numpy() const { return {dtype_, {count_}, bytes_.data()}; }

 private:
  const SceneColumns& scene_;
  pybind11::dtype dtype_;
  std::vector<std::byte> bytes_;
  std::size_t count_ = 0;
};

void bind_simulation(pybind11::module_& m);

}  // namespace thimble::host
