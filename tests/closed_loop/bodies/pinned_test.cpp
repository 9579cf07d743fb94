// A body that pins a fingertip against something else: what it loses of its momentum, the other one and the hand get.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/meshes.h"
#include "tests/support/temporary_folder.h"

namespace thimble::test {
namespace {

constexpr double kMass_kg = 0.4;
constexpr double kHalf_m = 0.02;
constexpr double kStiffness_N_m = 500;

class Pinned : public ::testing::Test {
 protected:
  // A slab of triangles; its upper side is z = 0.
  std::string slab(double size_m) {
    const auto file = folder_.path() / "slab.obj";
    write_obj(box_mesh({size_m, size_m, .02}, 6), 1000.0, file);
    return R"({"name": "slab", "shape": {"mesh": {"file": ")" + file.string() +
           R"(", "scale": 0.001}}, "pose": {"position_m": [0, 0, -0.01]}, "material": {"stiffness_N_m": 800})";
  }
  // A body above it that comes down.
  static std::string body(const std::string& shape, const Vector3d& at_m, const Vector3d& velocity_m_s) {
    return R"({"name": "body", "shape": {)" + shape + R"(}, "pose": {"position_m": )" + list(at_m) +
           R"(}, "material": {"stiffness_N_m": )" + std::to_string(kStiffness_N_m) +
           R"(}, "body": {"motion": "free", "mass_kg": )" + std::to_string(kMass_kg) +
           R"(, "velocity_m_s": )" + list(velocity_m_s) + "}}";
  }
  static std::string scene(double tip_radius_m, const std::string& slab, const std::string& body) {
    return R"("tip_radius_m": )" + std::to_string(tip_radius_m) + R"(, "objects": [)" + slab + "}, " + body +
           "]";
  }

  TemporaryFolder folder_;
};

const std::string kBox = R"("box": {"size_m": [0.04, 0.04, 0.04]})";
const std::string kBall = R"("sphere": {"radius_m": 0.02})";

// Puts the tip `above_m` above the place where the god object touches the slab.
void press(BodyRun& run, const Vector3d& at_m, double tip_radius_m, double above_m) {
  for (int i = 0; i <= 40; ++i)
    run.tick({at_m + Vector3d(0, 0, tip_radius_m + above_m + .002 * (40 - i) / 40)});
}

TEST_F(Pinned, ABodyThatComesDownObliquelyGoesOnAlongTheWall) {
  for (const std::string& shape : {kBox, kBall})
    for (const double radius_m : {0.0, .004})
      for (const double above_m : {-.001, .0005}) {
        const Vector3d tip(.004, -.003, 0);
        BodyRun run(
            scene(radius_m, slab(.4), body(shape, {0, 0, kHalf_m + 2 * radius_m + .012}, {.1, 0, -.3})),
            {tip + Vector3d(0, 0, radius_m + above_m + .002)});
        press(run, tip, radius_m, above_m);
        const Vector3d before = kMass_kg * run.velocity_m_s(0);
        Vector3d hand = Vector3d::Zero();
        double fastest = 0;
        while (run.time_s() < .08) {
          run.tick();
          hand += run.period_s() * run.force_N(0);
          fastest = std::max(fastest, run.velocity_m_s(0).norm());
        }
        // The wall has no friction and takes nothing along it.
        const Vector3d change = kMass_kg * run.velocity_m_s(0) - before;
        const double along = (change + hand).head<2>().norm();
        const std::string name = shape.substr(1, 3) + ", tip of " + std::to_string(1e3 * radius_m) +
                                 " mm at " + std::to_string(1e3 * above_m) + " mm";
        figure("pinned against a mesh by a " + name + ": lost along the wall, mN s", 1e3 * along,
               "< 0.4 of 40");
        figure("pinned against a mesh: momentum off the wall, mN s", 1e3 * kMass_kg * run.velocity_m_s(0).z(),
               "> -4; it came with -120");
        EXPECT_LT(along, 4e-4) << name;
        EXPECT_GT(run.velocity_m_s(0).z(), -.01) << name;
        EXPECT_LT(fastest, .32) << name;
      }
}

// The slab is a body too, so all momentum is seen: body, slab and hand.
TEST_F(Pinned, BodySlabAndHandShareAllMomentum) {
  for (const double slab_kg : {.2, 3.0})
    for (const double radius_m : {0.0, .004})
      for (const double aside_m : {0.0, .012}) {
        const Vector3d tip(aside_m, .3 * aside_m, 0);
        BodyRun run(
            scene(radius_m,
                  slab(.12) + R"(, "body": {"motion": "free", "mass_kg": )" + std::to_string(slab_kg) + "}",
                  body(kBox, {0, 0, kHalf_m + 2 * radius_m + .006}, {.05, 0, -.3})),
            {tip + Vector3d(0, 0, radius_m + .0025)});
        press(run, tip, radius_m, .0005);
        const auto momentum = [&] {
          return Vector3d(slab_kg * run.velocity_m_s(0) + kMass_kg * run.velocity_m_s(1));
        };
        const auto energy = [&] {
          double sum = 0;
          for (const std::size_t i : {0U, 1U}) {
            const Vector3d spin = run.rotation(i).conjugate() * run.body(i).spin_rad_s.cast<double>();
            const Vector3d size = i == 0 ? Vector3d(.12, .12, .02) : Vector3d::Constant(2 * kHalf_m);
            const double kg = i == 0 ? slab_kg : kMass_kg;
            const Vector3d inertia =
                kg / 12 * (Vector3d::Constant(size.squaredNorm()) - size.cwiseAbs2().eval());
            sum += .5 * kg * run.velocity_m_s(i).squaredNorm() + .5 * inertia.dot(spin.cwiseAbs2());
          }
          return sum;
        };
        const Vector3d before = momentum();
        const double energy_before = energy();
        Vector3d hand = Vector3d::Zero();
        double moved = 0;
        double most_J = 0;
        while (run.time_s() < .06) {
          run.tick();
          hand += run.period_s() * run.force_N(0);
          moved = std::max(moved, slab_kg * run.velocity_m_s(0).norm());
          most_J = std::max(most_J, energy());
        }
        const double lost = (momentum() + hand - before).norm();
        const std::string name = std::to_string(slab_kg) + " kg, tip of " + std::to_string(1e3 * radius_m) +
                                 " mm, " + std::to_string(1e3 * aside_m) + " mm aside";
        figure("pinned against a slab of " + name + ": momentum lost, mN s", 1e3 * lost, "< 0.1");
        figure("pinned: what the slab got, mN s", 1e3 * moved, "> 30 of 120");
        figure("pinned: most energy, mJ", 1e3 * most_J, "<= " + std::to_string(1e3 * energy_before));
        EXPECT_LT(lost, 1e-4) << name;
        EXPECT_GT(moved, .03) << name;
        EXPECT_LT(most_J, 1.002 * energy_before) << name;
      }
}

}  // namespace
}  // namespace thimble::test
