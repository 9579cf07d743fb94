// The unit of a mesh file does not change the force.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/compiler/compile.h"
#include "tests/support/figure.h"
#include "tests/support/ideal_run.h"
#include "tests/support/meshes.h"
#include "tests/support/oracle.h"
#include "tests/support/peer_path.h"
#include "tests/support/sanitizers.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

constexpr int kTicks = kUnderSanitizers ? 2000 : 40'000;

TEST(Units, TheSameForcesInMetresDecimetresAndMillimetres) {
  const TemporaryFolder temporary;
  const std::filesystem::path& folder = temporary.path();
  struct Unit {
    std::string name;
    double per_m;
    std::string scale;
  };
  const std::vector<Unit> units = {{"m", 1.0, "1"}, {"dm", 10.0, "0.1"}, {"mm", 1000.0, "0.001"}};
  const host::TriangleSoup fine = icosphere(5, 0.05);
  // Also small: at 2 mm across, a triangle is far below what another engine can feel in metres.
  for (const double size : {1.0, 0.02}) {
    for (const bool friction : {false, true}) {
      const host::TriangleSoup soup = transformed(fine, Eigen::Matrix3d::Identity() * size, Vector3d::Zero());
      const std::vector<Vector3d> path = peer_path(MeshOracle(fine), {.ticks = kTicks});
      std::vector<std::vector<Vector3d>> forces;
      for (const Unit& unit : units) {
        write_obj(soup, unit.per_m, folder / ("ball_" + unit.name + ".obj"));
        const std::string text =
            R"({"thimble_scene": 1, "name": "ball", "objects": [{"name": "ball", "shape": {"mesh": {"file": "ball_)" +
            unit.name + R"(.obj", "scale": )" + unit.scale +
            R"(}}, "material": {"stiffness_N_m": 1000, "damping_N_s_m": 0, )" +
            (friction ? R"("static_friction": 0.6, "dynamic_friction": 0.4}}]})"
                      : R"("static_friction": 0, "dynamic_friction": 0}}]})");
        const SceneImage image(host::compile_scene_text(text, "ball.scene.json", folder).image);
        IdealRun run(image);
        std::vector<Vector3d> felt;
        felt.reserve(path.size());
        for (const Vector3d& p : path) felt.push_back(run.step(size * p).force_N);
        forces.push_back(std::move(felt));
      }
      double most_N = 0.0;
      double worst_N = 0.0;
      int apart = 0;
      for (std::size_t tick = 0; tick < path.size(); ++tick) {
        most_N = std::max(most_N, forces[0][tick].norm());
        for (std::size_t unit = 1; unit < units.size(); ++unit) {
          const double error_N = (forces[unit][tick] - forces[0][tick]).norm();
          worst_N = std::max(worst_N, error_N);
          if (error_N > 1e-5 * forces[0][tick].norm() + 1e-5) ++apart;
        }
      }
      const std::string what = "units, ball of " + std::to_string(static_cast<int>(100 * size)) + " mm" +
                               (friction ? ", with friction: " : ": ");
      figure(what + "largest force, N", most_N, "> 0");
      figure(what + "m, dm, mm: force error over the largest", worst_N / most_N, friction ? "1e-4" : "1e-5");
      figure(what + "ticks apart by more than 1e-5, of " + std::to_string(2 * path.size()), apart,
             friction ? "0.5 %" : "");
      EXPECT_GT(most_N, 0.01);
      // Where a tip first sticks is known to the surface's tolerance of 2e-7 m, which K makes 2e-4 N until it
      // slips.
      EXPECT_LE(worst_N, (friction ? 1e-4 : 1e-5) * most_N);
      EXPECT_LE(apart, static_cast<int>(path.size() / 100));
    }
  }
}

}  // namespace
}  // namespace thimble::test
