#include "tests/closed_loop/fields/support.h"

#include <cmath>

#include "host-tools/compiler/compile.h"

namespace thimble::test {

SceneImage one_object(const std::string& shape, const std::string& material, const std::string& pose) {
  const std::string text = R"({"thimble_scene": 1, "name": "one", "objects": [{"name": "it", "shape": {)" +
                           shape + R"(}, "material": {)" + material + R"(}, "pose": {)" + pose + "}}]}";
  return SceneImage(host::compile_scene_text(text, "one", {}).image);
}

void add_largest_step(IdealRun& run, const Eigen::Vector3d& to, double step_m, ForceStep& step) {
  const Eigen::Vector3d from = run.felt().tip_m;
  const int count = static_cast<int>(std::ceil((to - from).norm() / step_m));
  for (int i = 1; i <= count; ++i) {
    const Eigen::Vector3d before = run.felt().force_N;
    const Felt& felt = run.step(from + (to - from) * i / count);
    if ((felt.force_N - before).norm() > step.most_N) step = {(felt.force_N - before).norm(), felt.tip_m};
  }
}

}  // namespace thimble::test
