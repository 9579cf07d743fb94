// Specimens and free space for the tests of the scan.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "board/sim/specimen.h"
#include "tests/support/scene.h"

namespace thimble::test {

// A horizontal square of 100 mm round (0, 0, z_m) with this stiffness at (x, y), in cells of 2 mm.
inline std::shared_ptr<const board::Specimen> specimen_of(
    double z_m, const std::function<double(double x_m, double y_m)>& stiffness_N_m, double damping_N_s_m = 0,
    const std::function<double(double x_m, double y_m)>& height_m = {}) {
  board::SpecimenMap map;
  map.origin_m = {-.05, -.05, z_m};
  map.cell_m = .002;
  map.columns = map.rows = 51;
  map.damping_N_s_m = damping_N_s_m;
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const double x_m = -.05 + .002 * static_cast<double>(column);
      const double y_m = -.05 + .002 * static_cast<double>(row);
      map.stiffness_N_m.push_back(stiffness_N_m(x_m, y_m));
      if (height_m) map.height_m.push_back(height_m(x_m, y_m));
    }
  }
  return std::make_shared<const board::Specimen>(std::move(map));
}

inline std::vector<std::byte> free_space() {  // a floor far below the arm's reach
  SceneBuilder scene;
  scene.plane({0, 0, 1}, -1.0, {});
  return scene.bytes();
}

}  // namespace thimble::test
