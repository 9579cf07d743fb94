// Plans of the tests, written to a folder with their scene and path.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/sweep/sweep_runs.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {

inline const std::string kFloorScene = R"({
  // A floor under the tip.
  "thimble_scene": 1, "name": "floor",
  "materials": { "wood": { "stiffness_N_m": 1000, "damping_N_s_m": 0 }, "steel": { "stiffness_N_m": 4000 } },
  "objects": [{ "name": "floor", "shape": { "plane": { "normal": [0, 0, 1], "offset_m": 0 } }, "material": "wood" }]
})";
// 2 mm deep for 0.1 s, from 1 mm above, and up again.
inline const std::string kPressPath =
    "time_s,x_m,y_m,z_m\n0,0,0,0.001\n0.03,0,0,-0.002\n0.13,0,0,-0.002\n0.16,0,0,0.001\n0.2,0,0,0.001\n";

inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class PlanFolder : public TemporaryFolder {
 public:
  PlanFolder() {
    write("floor.scene.json", kFloorScene);
    write("press.csv", kPressPath);
  }
  [[nodiscard]] host::SweepPlan plan(const std::string& text) const {
    return host::read_sweep_plan(write("plan.json", text));
  }
  // Of the floor, with these keys.
  [[nodiscard]] host::SweepPlan floor(const std::string& keys) const {
    return plan(R"({"thimble_sweep": 1, "name": "test", "scene": "floor.scene.json", "path": "press.csv", )" +
                keys + "}");
  }
};

}  // namespace thimble::test
