// A scene that differs only in its materials replaces the bound one: contacts and moved objects are kept.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "control/renderer.h"
#include "control/scene/same_shapes.h"
#include "host-tools/compiler/compile.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using control::Binding;

SceneImage slab_and_ball(double stiffness_N_m, double friction = 0.0, double slab_m = 0.04,
                         double mass_kg = 0.1) {
  const std::string text =
      R"({"thimble_scene": 1, "name": "two", "objects": [
        {"name": "slab", "shape": {"box": {"size_m": [0.04, 0.04, )" +
      std::to_string(slab_m) + R"(]}}, "material": {"stiffness_N_m": )" + std::to_string(stiffness_N_m) +
      R"(, "damping_N_s_m": 0, "static_friction": )" + std::to_string(friction) +
      R"(, "dynamic_friction": 0}},
        {"name": "ball", "shape": {"sphere": {"radius_m": 0.01}}, "pose": {"position_m": [0.1, 0, 0]},
         "material": {"stiffness_N_m": 500}, "body": {"motion": "translate", "mass_kg": )" +
      std::to_string(mass_kg) + R"(, "velocity_m_s": [0.05, 0, 0]}}]})";
  return SceneImage(host::compile_scene_text(text, "two.scene.json", ".").image);
}

bool same(const SceneImage& a, const SceneImage& b) {
  return control::differs_in_materials_only(a.bytes(), a.view(), b.bytes(), b.view());
}

TEST(Materials, OnlyTheyMayDiffer) {
  const SceneImage scene = slab_and_ball(500);
  EXPECT_TRUE(same(scene, slab_and_ball(500)));
  EXPECT_TRUE(same(scene, slab_and_ball(900)));
  EXPECT_TRUE(same(slab_and_ball(900, 0.5), scene));
  EXPECT_FALSE(same(scene, slab_and_ball(500, 0.0, 0.05)));
  EXPECT_FALSE(same(scene, slab_and_ball(500, 0.0, 0.04, 0.2)));
  control::SceneView none;
  EXPECT_FALSE(control::differs_in_materials_only(scene.bytes(), scene.view(), scene.bytes(), none));
  const SceneImage plane = SceneBuilder().plane(Eigen::Vector3d::UnitZ(), 0.0, {}).image();
  EXPECT_FALSE(same(scene, plane));
}

TEST(Materials, ChangeUnderTheFinger) {
  const SceneImage soft = slab_and_ball(500);
  const SceneImage stiff = slab_and_ball(900);
  constexpr float kTick_s = 1.0F / 4000;
  control::Renderer renderer;
  renderer.bind(soft.view());
  std::array<control::Tip, 1> tips;
  std::array<control::Touch, 1> touches;
  tips[0].position_m = {0, 0, 0.025F};
  renderer.tick(tips, kTick_s, touches);
  tips[0].position_m = {0, 0, 0.018F};
  for (int i = 0; i < 400; ++i) renderer.tick(tips, kTick_s, touches);
  EXPECT_NEAR(touches[0].force_N.z(), 500 * 0.002F, 1e-3F);
  const Vec3 ball_m = renderer.bodies()[0].position_m;
  EXPECT_NEAR(ball_m.x(), 0.105F, 1e-4F);

  renderer.bind(stiff.view(), Binding::kKeepState);
  EXPECT_EQ(renderer.bodies()[0].position_m, ball_m);
  renderer.tick(tips, kTick_s, touches);
  EXPECT_NEAR(touches[0].force_N.z(), 900 * 0.002F, 1e-3F);
  EXPECT_NEAR(touches[0].god_object_m.z(), 0.02F, 1e-6F);
  EXPECT_GT(renderer.bodies()[0].position_m.x(), ball_m.x()) << "it flies on";

  renderer.bind(soft.view());
  renderer.tick(tips, kTick_s, touches);
  EXPECT_EQ(touches[0].contacts, 0) << "a new scene begins without contacts";
  EXPECT_NEAR(renderer.bodies()[0].position_m.x(), 0.1F, 1e-4F);
}

SceneImage ball(const std::string& name, double radius_m) {
  return SceneImage(
      host::compile_scene_text(R"({"thimble_scene": 1, "name": ")" + name +
                                   R"(", "objects": [{"name": "ball", "shape": {"sphere": {"radius_m": )" +
                                   std::to_string(radius_m) + R"(}}, "material": {"stiffness_N_m": 500}}]})",
                               "ball.scene.json", ".")
          .image);
}

TEST(Materials, AnotherNameIsAnotherScene) {
  const SceneImage before = ball("one", 0.01), edited = ball("one", 0.02), other = ball("two", 0.01);
  const auto binding = [&](const SceneImage& after) {
    return control::binding_of(before.bytes(), before.view(), after.bytes(), after.view());
  };
  EXPECT_EQ(binding(before), Binding::kKeepState);
  EXPECT_EQ(binding(edited), Binding::kKeepPlaces);
  EXPECT_EQ(binding(other), Binding::kStart);
  EXPECT_EQ(control::binding_of({}, {}, before.bytes(), before.view()), Binding::kStart);
}

TEST(Planes, AreThoseThatTheGodObjectLiesOn) {
  const SceneImage scene = slab_and_ball(500);
  control::Renderer renderer;
  renderer.bind(scene.view());
  std::array<control::Tip, 1> tips;
  std::array<control::Touch, 1> touches;
  std::array<Vec3, control::kMaxContacts> normals;
  tips[0].position_m = {0, 0, 0.025F};
  renderer.tick(tips, 1.0F / 4000, touches);
  EXPECT_EQ(renderer.contact_normals(0, normals), 0U);
  tips[0].position_m = {0, 0, 0.018F};
  renderer.tick(tips, 1.0F / 4000, touches);
  ASSERT_EQ(renderer.contact_normals(0, normals), 1U);
  EXPECT_EQ(normals[0], Vec3(0, 0, 1));
}

}  // namespace
}  // namespace thimble::test
