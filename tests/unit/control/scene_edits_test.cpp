// A scene is replaced by an edited one while a fingertip presses on something: what is the same in both is felt on.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <utility>

#include "control/renderer.h"
#include "tests/support/meshes.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using control::Binding;

constexpr float kTick_s = 1.0F / 4000;

// One fingertip.
class Press {
 public:
  explicit Press(const SceneImage& scene) { renderer.bind(scene.view()); }
  void move(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, int ticks) {
    for (int i = 1; i <= ticks; ++i) tick(from_m + (to_m - from_m) * i / ticks);
  }
  void tick(const Eigen::Vector3d& tip_m) {
    tips_[0].position_m = tip_m.cast<float>();
    renderer.tick(tips_, kTick_s, touches_);
  }
  [[nodiscard]] Eigen::Vector3d force_N() const { return touches_[0].force_N.cast<double>(); }

  control::Renderer renderer;

 private:
  std::array<control::Tip, 1> tips_;
  std::array<control::Touch, 1> touches_;
};

// A box, a sphere, a coarse and a shaded mesh on a plane, and far away what is edited: where it is, and how many there are.
SceneImage scene_with(double edited_x_m, int more, double tip_radius_m) {
  const Material smooth{.stiffness_N_m = 500};
  const Material rough{.stiffness_N_m = 800, .static_friction = 0.7F, .dynamic_friction = 0.5F};
  SceneBuilder builder;
  if (tip_radius_m > 0) builder.tip_radius(tip_radius_m);
  for (int i = 0; i < more; ++i) builder.sphere(0.004, rough, {.position_m = {0.3, 0.02 * i, 0.1}});
  builder.box({0.04, 0.04, 0.04}, rough, {.position_m = {edited_x_m, 0.2, 0.02}})
      .plane(Eigen::Vector3d::UnitZ(), 0.0, rough)
      .sphere(0.02, smooth, {.position_m = {-0.1, 0, 0.02}})
      .box({0.04, 0.04, 0.04}, rough, {.position_m = {0, 0, 0.02}})
      .mesh(icosphere(2, 0.02), rough, {}, {.position_m = {0.1, 0, 0.02}})
      .mesh(icosphere(2, 0.02), smooth, {.crease_deg = 40}, {.position_m = {0.2, 0, 0.02}});
  return builder.image();
}

// Presses at random places of each object, and drags a little; then the other object moves, and others are added before it.
TEST(SceneEdits, ElsewhereLeaveTheForceAsItIs) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> share(-1, 1);
  int in_contact = 0;
  double worst = 0;
  for (const double radius_m : {0.0, 0.004}) {
    const SceneImage before = scene_with(0.1, 0, radius_m);
    const SceneImage after = scene_with(0.16, 3, radius_m);
    for (int press = 0; press < 200; ++press) {
      const Eigen::Vector3d centre_m(0.1 * (press % 4 - 1), 0, 0.02);
      Eigen::Vector3d from_m(share(random), share(random), 0.1 + std::abs(share(random)));
      from_m = centre_m + 0.045 * from_m.normalized();
      const Eigen::Vector3d to_m = from_m + (centre_m - from_m) * (0.6 + 0.2 * share(random));
      const Eigen::Vector3d drag_m = 0.003 * Eigen::Vector3d(share(random), share(random), 0);
      Press finger(before);
      finger.tick(from_m);
      finger.move(from_m, to_m, 100);
      finger.move(to_m, to_m + drag_m, 30);
      for (int i = 0; i < 20; ++i) finger.tick(to_m + drag_m);
      const Eigen::Vector3d force_N = finger.force_N();
      if (force_N.norm() < 0.2) continue;
      ++in_contact;
      finger.renderer.bind(after.view(), Binding::kKeepGodObjects);
      for (int i = 0; i < 20; ++i) finger.tick(to_m + drag_m);
      EXPECT_EQ(finger.renderer.inside(0), 0U) << "press " << press << ", radius " << radius_m;
      worst = std::max(worst, (finger.force_N() - force_N).norm() / force_N.norm());
      EXPECT_LT((finger.force_N() - force_N).norm(), 0.1 * force_N.norm())
          << "press " << press << ", radius " << radius_m;
    }
  }
  std::printf("%d presses in contact; the force changes by at most %.2f of it\n", in_contact, worst);
  EXPECT_GT(in_contact, 200);
}

TEST(SceneEdits, OfWhatIsTouchedAreFeltWhereItIsNow) {
  const auto floor = [](double z_m) {
    return SceneBuilder().plane(Eigen::Vector3d::UnitZ(), z_m, {.stiffness_N_m = 500}).image();
  };
  const auto after_edit = [&](double z_m, Binding binding = Binding::kKeepGodObjects) {
    const SceneImage scene = floor(0.0);
    const SceneImage edited = floor(z_m);
    Press finger(scene);
    finger.tick({0, 0, 0.01});
    finger.tick({0, 0, -0.005});
    EXPECT_NEAR(finger.force_N().z(), 2.5, 1e-3);
    finger.renderer.bind(edited.view(), binding);
    finger.tick({0, 0, -0.005});
    return std::pair(finger.force_N().z(), finger.renderer.inside(0));
  };
  EXPECT_NEAR(after_edit(-0.002).first, 500 * 0.003, 1e-3);
  EXPECT_EQ(after_edit(-0.02), std::pair(0.0, std::uint64_t{0}));
  EXPECT_EQ(after_edit(0.003), std::pair(0.0, std::uint64_t{1}))
      << "it came over the finger, and does not throw it out";
  EXPECT_EQ(after_edit(-0.002, Binding::kStart), std::pair(0.0, std::uint64_t{1})) << "from the start";
}

// A fingertip in free space begins at the tip, as everywhere else.
TEST(SceneEdits, OfFreeSpaceBeginAtTheTip) {
  const SceneImage empty = SceneBuilder().sphere(0.01, {}, {.position_m = {1, 0, 0}}).image();
  const SceneImage ball = SceneBuilder().sphere(0.01, {}).image();
  Press finger(empty);
  finger.tick({0.02, 0, 0});
  finger.tick({0.005, 0, 0});
  finger.renderer.bind(ball.view(), Binding::kKeepGodObjects);
  finger.tick({0.005, 0, 0});
  EXPECT_EQ(finger.renderer.inside(0), 1U);
  EXPECT_EQ(finger.force_N().norm(), 0.0);
}

}  // namespace
}  // namespace thimble::test
