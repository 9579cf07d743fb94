// The frames from which a picture elsewhere is drawn: they carry the true state, of one tick, at a bounded rate.
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/figure.h"
#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/tester.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;

constexpr float kSpeed_m_s = 0.02F;   // of the ball, along x
constexpr float kSpin_rad_s = -0.5F;  // of the ball, about z
constexpr float kSlide_m_s = 0.01F;   // of the slider
constexpr float kOnAt_m = 0.005F;
constexpr float kSkin_m = -0.005F;

std::vector<std::byte> finish(FlatBufferBuilder& builder, const std::vector<Offset<scene::Object>>& objects) {
  const auto all = builder.CreateVector(objects);
  scene::FinishSceneBuffer(builder, scene::CreateScene(builder, builder.CreateString("picture"), all));
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  return {bytes.begin(), bytes.end()};
}

const scene::Material kMaterial(500, 0, 0, 0, scene::FrictionMode::StickSlip);

// A ball that flies and spins, a slider with a switch, a needle's way with two layers.
std::vector<std::byte> moving_image() {
  FlatBufferBuilder builder;
  const scene::Vec3 zero(0, 0, 0);
  const scene::Vec3 inertia(1e-5F, 1e-5F, 1e-5F);
  const scene::Vec3 x(1, 0, 0);
  const auto ball = [&](float y_m) {
    const scene::Sphere sphere(0.005F);
    return std::pair(scene::Pose(scene::Vec3(-0.1F, y_m, 0.05F), scene::Quat(1, 0, 0, 0)),
                     builder.CreateStruct(sphere).Union());
  };
  const scene::Vec3 velocity(kSpeed_m_s, 0, 0);
  const scene::Vec3 spin(0, 0, kSpin_rad_s);
  const auto flying = scene::CreateBody(builder, scene::Motion::Free, 0.1F, &inertia, 0, &velocity, &spin, 0,
                                        0, 0, &x, &zero);
  scene::ControlBuilder control(builder);
  control.add_low(-0.2F);
  control.add_high(0.2F);
  control.add_on_at(kOnAt_m);
  control.add_off_at(kOnAt_m - 0.001F);
  control.add_has_switch(true);
  const auto slider_control = control.Finish();
  const scene::Vec3 slide(kSlide_m_s, 0, 0);
  const auto sliding = scene::CreateBody(builder, scene::Motion::Slide, 0.1F, &inertia, 0, &slide, &zero, 0,
                                         0, 0, &x, &zero, slider_control);
  std::vector<Offset<scene::Object>> objects;
  const auto [ball_pose, ball_shape] = ball(0.04F);
  objects.push_back(scene::CreateObject(builder, builder.CreateString("ball"), scene::Shape::Sphere,
                                        ball_shape, &ball_pose, &kMaterial, 0, flying));
  const auto [slider_pose, slider_shape] = ball(-0.04F);
  objects.push_back(scene::CreateObject(builder, builder.CreateString("slider"), scene::Shape::Sphere,
                                        slider_shape, &slider_pose, &kMaterial, 0, sliding));
  const std::vector<scene::Layer> layers{{0.003F, 500, 0.5F, 0.1F, 0}, {0.02F, 500, 100, 0, 0}};
  const auto way = scene::CreateNeedle(builder, builder.CreateVectorOfStructs(layers));
  const scene::Pose skin(scene::Vec3(0, 0, kSkin_m), scene::Quat(1, 0, 0, 0));
  objects.push_back(scene::CreateObject(builder, builder.CreateString("way"), scene::Shape::Needle,
                                        way.Union(), &skin, &kMaterial));
  return finish(builder, objects);
}

std::vector<std::byte> tissue_image() {
  FlatBufferBuilder builder;
  const scene::Tissue tissue(0.05F, 0.05F, 0.006F, 100.0F, 0.5F);
  const scene::Pose skin(scene::Vec3(0, 0, kSkin_m), scene::Quat(1, 0, 0, 0));
  const auto shape = builder.CreateStruct(tissue).Union();
  return finish(builder, {scene::CreateObject(builder, builder.CreateString("pad"), scene::Shape::Tissue,
                                              shape, &skin, &kMaterial)});
}

// What came over the link.
struct Heard {
  int poses = 0, pictures = 0;
  std::map<std::uint8_t, link::BodyPosition> position;  // by object
  std::map<std::uint8_t, link::BodyRotation> rotation;
  link::ControlElementState control;
  link::NeedleState needle;
  link::TissueState tissue;
  std::map<std::uint8_t, link::Pose> pose;  // by arm
  std::map<std::uint8_t, link::GodObject> god;
  std::map<int, link::ContactPlane> plane;  // by index, of arm 0
  int gods = 0, planes = 0, paired = 0;
  int needles = 0, tissues = 0, controls = 0;

  void take(const link::CanFrame& frame) {
    link::Pose tip;
    link::GodObject held;
    link::ContactPlane lies_on;
    link::BodyPosition at;
    link::BodyRotation turned;
    if (link::from_frame(frame, 1, tip)) ++poses, pose[tip.arm] = tip;
    if (link::from_frame(frame, 1, held)) {
      ++gods, god[held.arm] = held;
      if (held.sequence == pose[held.arm].sequence) ++paired;
    }
    if (link::from_frame(frame, 1, lies_on)) ++pictures, ++planes, plane[lies_on.index] = lies_on;
    if (link::from_frame(frame, 1, at)) ++pictures, position[at.object] = at;
    if (link::from_frame(frame, 1, turned)) ++pictures, rotation[turned.object] = turned;
    if (link::from_frame(frame, 1, control)) ++pictures, ++controls;
    if (link::from_frame(frame, 1, needle)) ++pictures, ++needles;
    if (link::from_frame(frame, 1, tissue)) ++pictures, ++tissues;
  }
};

void arm_over(Bench& bench, const std::vector<std::byte>& image) {
  ASSERT_EQ(bench.controller->load_scene(image), firmware::StoreStatus::kOk);
  bench.home();
  bench.arm();
}

void listen(Bench& bench, Heard& heard, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    bench.tick();
    link::CanFrame frame;
    constexpr int kMostFrames = 64;
    for (int n = 0; n < kMostFrames && bench.controller->next_frame(frame, bench.inputs.time_us); ++n)
      heard.take(frame);
  }
}

TEST(Picture, CarriesTheTrueStateOfOneTick) {
  Bench bench;
  arm_over(bench, moving_image());
  Heard heard;
  const int kTicks = 3000;
  listen(bench, heard, kTicks);
  const float armed_s = (kTicks + 1) / 4000.0F;

  ASSERT_TRUE(heard.position.contains(0) && heard.position.contains(1) && heard.rotation.contains(0));
  const link::BodyPosition& ball = heard.position[0];
  const float t = (ball.x_m + 0.1F) / kSpeed_m_s;
  figure("age of the last picture, s", static_cast<double>(armed_s - t),
         "below 0.05: a picture every second record");
  EXPECT_GT(armed_s - t, -1e-3F);
  EXPECT_LT(armed_s - t, 0.05F);
  EXPECT_NEAR(ball.y_m, 0.04F, 3e-5F);
  EXPECT_NEAR(ball.z_m, 0.05F, 3e-5F);
  const link::BodyRotation& turned = heard.rotation[0];
  EXPECT_NEAR(turned.z, std::sin(kSpin_rad_s * armed_s / 2), 0.05F * 0.5F);
  EXPECT_EQ(turned.x, 0.0F);

  // Every frame with the same sequence is of the same tick: three coordinates that run at known speeds agree about the time.
  std::map<std::uint8_t, float> time_s;  // by sequence, from the ball
  int agreed = 0;
  for (int i = 0; i < 4000; ++i) {
    bench.tick();
    link::CanFrame frame;
    while (bench.controller->next_frame(frame, bench.inputs.time_us)) {
      link::BodyPosition at;
      link::BodyRotation rotation;
      link::ControlElementState control;
      if (link::from_frame(frame, 1, at) && at.object == 0)
        time_s[at.sequence] = (at.x_m + 0.1F) / kSpeed_m_s;
      if (link::from_frame(frame, 1, rotation) && rotation.object == 0 &&
          time_s.contains(rotation.sequence)) {
        EXPECT_NEAR(2 * std::asin(rotation.z) / kSpin_rad_s, time_s[rotation.sequence], 2e-3F);
        ++agreed;
      }
      if (link::from_frame(frame, 1, control) && time_s.contains(control.sequence)) {
        EXPECT_EQ(control.object, 1);
        EXPECT_NEAR(control.q / kSlide_m_s, time_s[control.sequence], 2e-3F);
        const bool clear = std::abs(control.q - kOnAt_m) > 1e-4F;
        EXPECT_TRUE(!clear || control.on == (control.q > kOnAt_m));
        ++agreed;
      }
    }
  }
  figure("frames that agree about their picture's tick", agreed, "above 80");
  EXPECT_GT(agreed, 80);
}

TEST(Picture, ShowsTheNeedle) {
  Bench bench;
  arm_over(bench, moving_image());
  bench.ticks(900);
  Heard heard;
  listen(bench, heard, 200);
  EXPECT_FALSE(heard.needle.inside) << "above the skin";
  bench.move({0.002, 0.001, 0.0}, 200);
  bench.move({0.002, 0.001, -0.0055}, 400);
  listen(bench, heard, 200);
  EXPECT_EQ(heard.needle.object, 2);
  EXPECT_TRUE(heard.needle.inside);
  EXPECT_EQ(heard.needle.torn, 0);
  EXPECT_NEAR(heard.needle.depth_m, 0.0005F, 1e-4F) << "the hand trembles by two counts";
  EXPECT_NEAR(heard.needle.x_m, 0.002F, 5e-5F);
  EXPECT_NEAR(heard.needle.y_m, 0.001F, 5e-5F);
  bench.move({0.002, 0.001, -0.0095}, 800);
  listen(bench, heard, 200);
  EXPECT_TRUE(heard.needle.inside);
  EXPECT_EQ(heard.needle.torn, 1);
  EXPECT_NEAR(heard.needle.depth_m, 0.0045F, 5e-5F);
}

TEST(Picture, ShowsTheDimple) {
  Bench bench;
  bench.let_jump();
  arm_over(bench, tissue_image());
  bench.ticks(900);
  bench.move({0.01, -0.02, 0.0}, 400);
  bench.move({0.01, -0.02, -0.008}, 400);
  Heard heard;
  listen(bench, heard, 4000);
  EXPECT_TRUE(heard.tissue.pressed);
  EXPECT_EQ(heard.tissue.arm, 0);
  EXPECT_NEAR(heard.tissue.x_m, 0.01F, 5e-5F);
  EXPECT_NEAR(heard.tissue.y_m, -0.02F, 5e-5F);
  EXPECT_NEAR(heard.tissue.depth_m, 0.003F, 5e-5F) << "it follows the tip";
  bench.move({0.01, -0.02, 0.0}, 4);
  listen(bench, heard, 200);
  EXPECT_FALSE(heard.tissue.pressed);
  const float left = heard.tissue.depth_m;
  figure("dimple just let go, mm", static_cast<double>(1e3F * left), "near 3 (1 - 100 / 500) = 2.4");
  EXPECT_NEAR(left, 0.0024F, 0.00025F);
  listen(bench, heard, 2000);
  EXPECT_NEAR(heard.tissue.depth_m, left * std::exp(-1.0F), 0.05F * left)
      << "half a second is its time constant";
}

// In free space no frame more than before; in contact the god object on the surface, and the surface's normal.
TEST(Picture, ShowsTheGodObjectAndItsPlane) {
  Bench bench;
  bench.start();
  bench.move({0, 0, 0.005}, 200);
  Heard free;
  listen(bench, free, 400);
  EXPECT_EQ(free.gods + free.planes, 0);
  bench.move({0.01, 0, 0.005}, 200);
  bench.move({0.01, 0, -0.003}, 400);
  Heard held;
  listen(bench, held, 400);
  EXPECT_GE(held.poses, 10);
  EXPECT_EQ(held.gods, held.poses);
  EXPECT_EQ(held.paired, held.poses);
  EXPECT_NEAR(held.god[0].z_m, 0.0F, 1e-5F);
  EXPECT_NEAR(held.god[0].x_m, 0.01F, 5e-5F);
  EXPECT_NEAR(held.pose[0].z_m, -0.003F, 5e-5F);
  EXPECT_GE(held.planes, 5);
  ASSERT_EQ(held.plane.size(), 1U);
  EXPECT_EQ(held.plane[0].arm, 0);
  EXPECT_EQ(held.plane[0].count, 1);
  EXPECT_NEAR(held.plane[0].z, 1.0F, 1e-4F);
  EXPECT_NEAR(held.plane[0].x, 0.0F, 1e-4F);
  bench.move({0.01, 0, 0.005}, 400);
  listen(bench, free, 80);  // what was on its way
  Heard left;
  listen(bench, left, 400);
  EXPECT_EQ(left.gods + left.planes, 0);
}

// Armed inside a ball: told in every picture until the tip has left it, with its name, and not felt until then.
TEST(Picture, TellsWhichSolidsTheTipHasToLeave) {
  FlatBufferBuilder builder;
  const scene::Pose home(scene::Vec3(0, 0, 0), scene::Quat(1, 0, 0, 0));
  const scene::Pose away(scene::Vec3(0, 0, -1), scene::Quat(1, 0, 0, 0));
  const auto ball = builder.CreateStruct(scene::Sphere(0.01F)).Union();
  const auto far_ball = builder.CreateStruct(scene::Sphere(0.01F)).Union();
  const std::vector<std::byte> image =
      finish(builder, {scene::CreateObject(builder, builder.CreateString("far"), scene::Shape::Sphere,
                                           far_ball, &away, &kMaterial),
                       scene::CreateObject(builder, builder.CreateString("the lamp"), scene::Shape::Sphere,
                                           ball, &home, &kMaterial)});
  Bench bench;
  arm_over(bench, image);
  const auto told = [&] {
    std::map<int, int> objects;
    for (int i = 0; i < 400; ++i) {
      bench.tick();
      link::CanFrame frame;
      link::Inside inside;
      while (bench.controller->next_frame(frame, bench.inputs.time_us)) {
        if (!link::from_frame(frame, 1, inside)) continue;
        EXPECT_EQ(inside.arm, 0);
        ++objects[inside.object];
      }
    }
    return objects;
  };
  bench.ticks(1000);
  EXPECT_EQ(bench.shown().arm[0].inside, 2U);
  EXPECT_EQ(bench.shown().arm[0].contacts, 0);
  const std::map<int, int> within = told();
  ASSERT_EQ(within.size(), 1U);
  EXPECT_GE(within.at(1), 8) << "of 10 pictures";
  Tester tester(bench);
  bench.alive = true;
  EXPECT_EQ(tester.text(link::kDidInside), "0 01 the lamp\n");
  bench.move({0, 0, 0.012}, 400);
  EXPECT_EQ(bench.shown().arm[0].inside, 0U);
  told();  // what was on its way
  EXPECT_TRUE(told().empty());
  EXPECT_EQ(tester.text(link::kDidInside), "");
  bench.move({0, 0, 0.008}, 400);
  EXPECT_EQ(bench.shown().arm[0].contacts, 1) << "it is felt from outside";
}

TEST(Picture, IsBoundedAndStarvesNothing) {
  Bench bench;
  arm_over(bench, moving_image());
  Heard heard;
  listen(bench, heard, 8000);
  figure("frames of the picture for each record", static_cast<double>(heard.pictures) / heard.poses,
         "at most 4");
  EXPECT_EQ(heard.poses, 200) << "every record still comes";
  EXPECT_LE(heard.pictures, 4 * heard.poses);
  EXPECT_GT(heard.pictures, 3 * heard.poses);

  // A link that takes one frame in 15 ticks: poses and forces go first, and a picture is never half of two ticks (above).
  Heard slow;
  for (int i = 0; i < 8000; ++i) {
    bench.tick();
    link::CanFrame frame;
    if (i % 15 == 0 && bench.controller->next_frame(frame, bench.inputs.time_us)) slow.take(frame);
  }
  figure("poses of 200 that a slow link still carries", slow.poses, "above 190");
  EXPECT_GT(slow.poses, 190);
  EXPECT_GT(slow.pictures, 20);

  Bench plain;  // nothing moves: no such frame
  plain.start();
  Heard silent;
  listen(plain, silent, 4000);
  EXPECT_EQ(silent.pictures, 0);
}

}  // namespace
}  // namespace thimble::test
