// A tip with a radius pushes bodies and controls at the place of contact.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/heap.h"

namespace thimble::test {
namespace {

// A button pressed by a sphere goes as if a point one radius lower pressed it.
TEST(TipRadius, PressesAButtonAsAPointOneRadiusLower) {
  constexpr double kRadius_m = 0.004;
  const auto text = [](double radius_m) {
    return R"("tip_radius_m": )" + std::to_string(radius_m) + R"(, "objects": [{"name": "key", "shape":
      {"box": {"size_m": [0.02, 0.02, 0.01]}}, "material": {"stiffness_N_m": 800, "damping_N_s_m": 1, "static_friction": 0.3,
      "dynamic_friction": 0.2}, "body": {"motion": "slide", "axis": [0, 0, -1], "mass_kg": 0.02,
      "control": {"stiffness_N_m": 300, "damping_N_s_m": 2, "low_m": 0, "high_m": 0.004}}}])";
  };
  const Vector3d up(0.0, 0.0, kRadius_m);
  BodyRun point(text(0.0), {{0.0, 0.0, 0.006}});
  BodyRun ball(text(kRadius_m), {Vector3d(0.0, 0.0, 0.006) + up});
  double worst_m = 0.0;
  double most_m = 0.0;
  for (int tick = 0; tick < 8000; ++tick) {
    const Vector3d tip(0.0005 * std::sin(2e-3 * tick), 0.0, 0.006 - 0.004 * (1.0 - std::cos(1.6e-3 * tick)));
    point.tick({tip});
    ball.tick({tip + up});
    worst_m = std::max(worst_m, (point.position_m(0) - ball.position_m(0)).norm());
    most_m = std::max(most_m, point.position_m(0).norm());
  }
  figure("tip radius, button: way against the one under the point, um", 1e6 * worst_m, "10");
  EXPECT_GT(most_m, 0.001);
  EXPECT_LT(worst_m, 1e-5);
}

// A free body pushed off its centre gets momentum and spin from the place where the sphere touches it.
TEST(TipRadius, PushesAFreeBodyAtThePlaceOfContact) {
  constexpr double kRadius_m = 0.005;
  const std::string text = R"("tip_radius_m": 0.005, "objects": [{"name": "block", "shape":
      {"box": {"size_m": [0.02, 0.04, 0.02]}}, "material": {"stiffness_N_m": 600, "damping_N_s_m": 0, "static_friction": 0,
      "dynamic_friction": 0}, "body": {"motion": "free", "mass_kg": 0.1}}])";
  BodyRun run(text, {{-0.02, 0.012, 0.0}});
  Vector3d impulse = Vector3d::Zero();
  Vector3d twist = Vector3d::Zero();
  double nearest_m = 1.0;
  for (int tick = 0; tick < 4000; ++tick) {
    const Vector3d before_m = run.position_m(0);
    run.tick({Vector3d(-0.02 + 0.05 * run.time_s() * std::min(1.0, run.time_s() / 0.1), 0.012, 0.0)});
    impulse -= run.period_s() * run.force_N(0);
    if (run.contacts(0) > 0) {
      const Vector3d n = -run.force_N(0).normalized();
      twist += run.period_s() * (run.god_m(0) + kRadius_m * n - before_m).cross(-run.force_N(0));
    }
    const control::BodyState& met = run.before(0);
    const Vector3d local =
        met.rotation.cast<double>().conjugate() * (run.god_m(0) - met.position_m.cast<double>());
    nearest_m = std::min(nearest_m, box_distance({0.01, 0.02, 0.01}, local));
  }
  const double inertia = 0.1 / 12.0 * (0.02 * 0.02 + 0.04 * 0.04);
  figure("tip radius, free body: momentum off, part",
         (0.1 * run.velocity_m_s(0) - impulse).norm() / impulse.norm(), "1e-3");
  EXPECT_GT(impulse.norm(), 1e-4);
  EXPECT_LT((0.1 * run.velocity_m_s(0) - impulse).norm(), 1e-3 * impulse.norm());
  const double spin = static_cast<double>(run.body(0).spin_rad_s.z());
  figure("tip radius, free body: angular momentum off, part",
         std::abs(inertia * spin - twist.z()) / std::abs(twist.z()), "1e-2");
  EXPECT_GT(std::abs(spin), 0.1);
  EXPECT_NEAR(inertia * spin, twist.z(), 1e-2 * std::abs(twist.z()));
  figure("tip radius, free body: sphere nearest to it, um below the radius", 1e6 * (kRadius_m - nearest_m),
         "3");
  EXPECT_GT(nearest_m, kRadius_m - 3e-6);
}

}  // namespace
}  // namespace thimble::test
