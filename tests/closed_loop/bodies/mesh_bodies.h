// Scenes with bodies on meshes and height fields that a test writes itself.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {

inline constexpr const char* kWood =
    R"("materials": {"wood": {"stiffness_N_m": 1000, "static_friction": 0.5, "dynamic_friction": 0.4}}, )";

inline std::string object(const std::string& name, const std::string& shape, const Vector3d& at_m,
                          const std::string& rest, const Vector3d& angles_deg = Vector3d::Zero()) {
  return R"({"name": ")" + name + R"(", "material": "wood", "shape": {)" + shape +
         R"(}, "pose": {"position_m": )" + list(at_m) + R"(, "rotation_deg": )" + list(angles_deg) + "}" +
         rest + "}";
}

inline const std::string kFree = R"(, "body": {"motion": "free", "mass_kg": 0.1})";

class MeshBodies : public ::testing::Test {
 protected:
  // Writes the mesh in metres; returns its shape.
  std::string mesh(const host::TriangleSoup& soup) {
    const std::filesystem::path file = folder_.path() / ("mesh" + std::to_string(files_++) + ".obj");
    write_obj(soup, 1000.0, file);
    return R"("mesh": {"file": ")" + file.string() + R"(", "scale": 0.001})";
  }
  std::string height_field(std::size_t columns, std::size_t rows, double width_m, double depth_m,
                           const std::function<double(double, double)>& height_m) {
    const std::filesystem::path file = folder_.path() / ("heights" + std::to_string(files_++) + ".csv");
    std::ofstream out(file);
    for (std::size_t y = 0; y < rows; ++y) {  // the first row is the one at the top, +y
      for (std::size_t x = 0; x < columns; ++x) {
        const double u = (static_cast<double>(x) / static_cast<double>(columns - 1) - .5) * width_m;
        const double v = (.5 - static_cast<double>(y) / static_cast<double>(rows - 1)) * depth_m;
        out << (x > 0 ? "," : "") << 1000 * height_m(u, v);
      }
      out << "\n";
    }
    return R"("height_field": {"file": ")" + file.string() + R"(", "size_m": [)" + std::to_string(width_m) +
           ", " + std::to_string(depth_m) + R"(], "height_m": 0.001, "thickness_m": 0.01})";
  }

  TemporaryFolder folder_;
  int files_ = 0;
};

}  // namespace thimble::test
