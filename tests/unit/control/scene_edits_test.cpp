// A scene is replaced by an edited one while a fingertip presses on something: what is the same in both is felt on.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>
#include <utility>

#include "control/renderer.h"
#include "host-tools/compiler/compile.h"
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
      finger.renderer.bind(after.view(), Binding::kKeepPlaces);
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
  const auto after_edit = [&](double z_m, Binding binding = Binding::kKeepPlaces) {
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
  finger.renderer.bind(ball.view(), Binding::kKeepPlaces);
  finger.tick({0.005, 0, 0});
  EXPECT_EQ(finger.renderer.inside(0), 1U);
  EXPECT_EQ(finger.force_N().norm(), 0.0);
}

// A button, a drawer with detents, a dial, a block on the floor and one that flies; what is edited is beside them, and before them in the file.
SceneImage scene_with_bodies(double edited_x_m, bool one_more, double drawer_m = 0.0) {
  const std::string another =
      R"({"name": "another", "material": "rough", "shape": {"sphere": {"radius_m": 0.01}},
     "pose": {"position_m": [0.1, 0.1, 0.02]}, "body": {"motion": "free", "mass_kg": 0.1}},)";
  const std::string text = R"({"thimble_scene": 1, "name": "bodies", "gravity_m_s2": [0, 0, -9.81],
  "materials": {"rough": {"stiffness_N_m": 700, "damping_N_s_m": 0.5, "static_friction": 0.6, "dynamic_friction": 0.45}},
  "objects": [)" + (one_more ? another : "") +
                           R"(
    {"name": "edited", "material": "rough", "shape": {"box": {"size_m": [0.01, 0.01, 0.01]}},
     "pose": {"position_m": [)" +
                           std::to_string(edited_x_m) + R"(, -0.1, 0.02]}},
    {"name": "floor", "material": "rough", "shape": {"plane": {"normal": [0, 0, 1]}}},
    {"name": "button", "material": "rough", "shape": {"cylinder": {"radius_m": 0.009, "height_m": 0.01}}, "pose": {"position_m": [0, 0, 0.05]},
     "body": {"motion": "slide", "mass_kg": 0.02, "axis": [0, 0, -1], "control": {"damping_N_s_m": 0.5, "low_m": 0, "high_m": 0.0035,
       "curve_m_N": [[0, 0.3], [0.0015, 2], [0.0022, 0.8], [0.0035, 1.6]], "switch": {"on_at_m": 0.002, "off_at_m": 0.001}}}},
    {"name": "drawer", "material": "rough", "shape": {"box": {"size_m": [0.02, 0.02, 0.02]}},
     "pose": {"position_m": [)" +
                           std::to_string(0.05 + drawer_m) + R"(, 0, 0.02]},
     "body": {"motion": "slide", "mass_kg": 0.05, "axis": [1, 0, 0], "control": {"damping_N_s_m": 0.5, "friction_N": 0.2,
       "low_m": -0.02, "high_m": 0.02, "detents": {"pitch_m": 0.005, "force_N": 0.8}}}},
    {"name": "dial", "material": "rough", "shape": {"box": {"size_m": [0.044, 0.008, 0.014]}},
     "pose": {"position_m": [-0.06, 0, 0.02], "rotation_deg": [0, 0, 20]},
     "body": {"motion": "turn", "mass_kg": 0.04, "axis": [0, 0, 1], "control": {"damping_N_m_s_rad": 0.0005, "friction_N_m": 0.001,
       "detents": {"pitch_deg": 15, "torque_N_m": 0.015}}}},
    {"name": "block", "material": "rough", "shape": {"box": {"size_m": [0.03, 0.03, 0.03]}}, "pose": {"position_m": [0, 0.08, 0.015]},
     "body": {"motion": "free", "mass_kg": 0.1}},
    {"name": "thrown", "material": "rough", "shape": {"box": {"size_m": [0.01, 0.02, 0.03]}}, "pose": {"position_m": [0.2, 0.2, 0.6]},
     "body": {"motion": "free", "mass_kg": 0.05, "velocity_m_s": [0.2, 0, 0.5], "spin_rad_s": [1, 6, 2]}}]})";
  return SceneImage(host::compile_scene_text(text, "bodies.scene.json", ".").image);
}

// Presses, pulls and turns, then edits beside a hand that goes on: what moves goes on as without the edit, and so does the force. The bodies
// are compared by the distance of three of their points.
TEST(SceneEdits, LeaveWhatMovesWhereItIs) {
  struct Pull {
    const char* name;
    Eigen::Vector3d above_m, to_m, past_m;
  };
  const std::array pulls = {
      Pull{"button", {0, 0, 0.06}, {0, 0, 0.0505}, {0, 0, 0.0495}},
      Pull{"drawer", {0.035, 0, 0.02}, {0.0413, 0, 0.02}, {0.048, 0, 0.02}},
      Pull{"dial", {-0.045, -0.01, 0.02}, {-0.045, 0.004, 0.02}, {-0.047, 0.008, 0.02}},
      Pull{"block", {-0.02, 0.08, 0.015}, {-0.0125, 0.08, 0.015}, {0.005, 0.08, 0.015}}};
  const SceneImage before = scene_with_bodies(-0.1, false);
  const SceneImage after = scene_with_bodies(-0.12, true);
  for (const Pull& pull : pulls) {
    Press edited(before);
    Press left_alone(before);
    for (Press* finger : {&edited, &left_alone}) {
      finger->tick(pull.above_m);
      finger->move(pull.above_m, pull.to_m, 400);
    }
    ASSERT_GT(edited.force_N().norm(), 0.2) << pull.name;
    const Press untouched(before);
    float moved_m = 0;  // of what is touched, and turns of the dial by its arm of 2 cm
    for (std::size_t body = 0; body < 4; ++body) {
      const control::BodyState& now = edited.renderer.bodies()[body];
      const control::BodyState& start = untouched.renderer.bodies()[body];
      moved_m +=
          (now.position_m - start.position_m).norm() + 0.02F * now.rotation.angularDistance(start.rotation);
    }
    EXPECT_GT(moved_m, 2e-4F) << pull.name;
    edited.renderer.bind(after.view(), Binding::kKeepPlaces);
    double farthest_m = 0;
    double most_N = 0;
    for (int i = 1; i <= 400; ++i) {
      const Eigen::Vector3d tip_m = pull.to_m + (pull.past_m - pull.to_m) * i / 400;
      edited.tick(tip_m);
      left_alone.tick(tip_m);
      const auto with = edited.renderer.bodies().subspan(1);
      const auto without = left_alone.renderer.bodies();
      ASSERT_EQ(with.size(), without.size());
      for (std::size_t body = 0; body < with.size(); ++body) {
        EXPECT_EQ(with[body].object, without[body].object + 1);
        EXPECT_EQ(with[body].on, without[body].on) << pull.name;
        for (int axis = 0; axis < 3; ++axis) {
          const Vec3 point_m = 0.02F * Vec3::Unit(axis);
          farthest_m = std::max(
              farthest_m, static_cast<double>((with[body].position_m + with[body].rotation * point_m -
                                               without[body].position_m - without[body].rotation * point_m)
                                                  .norm()));
        }
      }
      if (i > 20) most_N = std::max(most_N, (edited.force_N() - left_alone.force_N()).norm());
    }
    std::printf("%s, moved by %.2g m: %.2g m and %.2g N from what it is without the edit, of %.2g N\n",
                pull.name, static_cast<double>(moved_m), farthest_m, most_N, left_alone.force_N().norm());
    // The contacts are found again in the tick of the edit. What they give a block of 0.1 kg in it, 1 N for 0.25 ms from the finger and 0.6 N
    // from the floor, is missing: 4 mm/s, or 0.4 mm here.
    EXPECT_LT(farthest_m, 0.0006) << pull.name;
    EXPECT_LT(most_N, 0.08 * left_alone.force_N().norm()) << pull.name;
  }
}

// One that the edit puts somewhere else is there, at rest.
TEST(SceneEdits, OfAMovingObjectPutItThere) {
  const SceneImage before = scene_with_bodies(-0.1, false);
  const SceneImage after = scene_with_bodies(-0.1, false, 0.03);
  Press finger(before);
  finger.move({0.035, 0, 0.02}, {0.05, 0, 0.02}, 400);
  ASSERT_GT(finger.renderer.bodies()[1].q, 0.002F);
  const Vec3 thrown_m = finger.renderer.bodies()[4].position_m;
  finger.renderer.bind(after.view(), Binding::kKeepPlaces);
  EXPECT_EQ(finger.renderer.bodies()[1].q, 0.0F);
  EXPECT_NEAR(finger.renderer.bodies()[1].position_m.x(), 0.08F, 1e-6F);
  EXPECT_EQ(finger.renderer.bodies()[4].position_m, thrown_m);
  finger.renderer.bind(after.view(), Binding::kStart);
  EXPECT_EQ(finger.renderer.bodies()[4].position_m, Vec3(0.2F, 0.2F, 0.6F));
}

// Two that turn about one place, as a ring about a knob, and a third that spins: each goes on as itself, in its new mass and behind its new stop.
TEST(SceneEdits, OfAMovingObjectLeaveItsMotion) {
  const auto scene = [](double ring_kg, double block_kg, double stop_deg, bool with_switch) {
    const std::string dial =
        R"("material": "rough", "shape": {"box": {"size_m": [0.02, 0.01, 0.01]}}, "pose": {"position_m": [0, 0, 0]},
      "body": {"motion": "turn", "axis": [0, 0, 1], "spin_rad_s": [0, 0, )";
    const std::string text =
        R"({"thimble_scene": 1, "name": "dials", "materials": {"rough": {"stiffness_N_m": 700}}, "objects": [
      {"name": "knob", )" +
        dial + R"(0], "mass_kg": 0.05}},
      {"name": "ring", )" +
        dial + "5], \"mass_kg\": " + std::to_string(ring_kg) + R"(, "control": {"high_deg": )" +
        std::to_string(stop_deg) + (with_switch ? R"(, "switch": {"on_at_deg": 10, "off_at_deg": 5})" : "") +
        R"(}}},
      {"name": "block", "material": "rough", "shape": {"box": {"size_m": [0.01, 0.02, 0.03]}}, "pose": {"position_m": [0.2, 0, 0]},
       "body": {"motion": "free", "spin_rad_s": [0, 0, 4], "mass_kg": )" +
        std::to_string(block_kg) + "}}]}";
    return SceneImage(host::compile_scene_text(text, "dials.scene.json", ".").image);
  };
  const SceneImage before = scene(0.05, 0.1, 170, true);
  Press finger(before);
  for (int i = 0; i < 400; ++i) finger.tick({0, 0, 0.1});
  const std::array<control::BodyState, 3> was = {finger.renderer.bodies()[0], finger.renderer.bodies()[1],
                                                 finger.renderer.bodies()[2]};
  ASSERT_GT(std::abs(was[1].q - was[0].q), 0.01F);
  ASSERT_GT(was[1].q, 0.2F);
  ASSERT_TRUE(was[1].on);
  const SceneImage after = scene(0.2, 0.001, 90, false);
  finger.renderer.bind(after.view(), Binding::kKeepPlaces);
  for (std::size_t body = 0; body < was.size(); ++body) {
    EXPECT_EQ(finger.renderer.bodies()[body].q, was[body].q) << body;
    EXPECT_EQ(finger.renderer.bodies()[body].spin_rad_s, was[body].spin_rad_s) << body;
  }
  finger.tick({0, 0, 0.1});
  EXPECT_FALSE(finger.renderer.bodies()[1].on) << "it has no switch any more";
  EXPECT_NEAR(finger.renderer.bodies()[2].spin_rad_s.z(), was[2].spin_rad_s.z(), 0.01F)
      << "a hundredth of the mass";
  const SceneImage stopped = scene(0.2, 0.001, 10, false);
  finger.renderer.bind(stopped.view(), Binding::kKeepPlaces);
  EXPECT_EQ(finger.renderer.bodies()[1].q, 0.0F) << "the stop is before where it was";
}

// Tissues, and as volume 1 the way of a needle, whose skin is below them and without end; the last tissue is where the
// first one is, and recovers more slowly. `left_out`: without this one; `more`: with others before and between them;
// `moved`: this one is somewhere else.
SceneImage scene_with_volumes(int left_out, bool more, int moved, double tip_radius_m = 0.0) {
  const std::string tissue =
      R"("tissue": {"size_m": [0.06, 0.06], "relaxed_stiffness_N_m": 150, "recovery_s": 0.4, "contact_radius_m": 0.008})";
  const std::string slow =
      R"("tissue": {"size_m": [0.06, 0.06], "relaxed_stiffness_N_m": 250, "recovery_s": 2, "contact_radius_m": 0.008})";
  const std::string needle = R"("needle": {"layers": [
      {"thickness_m": 0.004, "stiffness_N_m": 600, "tear_N": 1.2, "friction_N": 0.15, "viscosity_N_s_m2": 10},
      {"thickness_m": 0.02, "stiffness_N_m": 250, "tear_N": 0.4, "friction_N": 0.2, "viscosity_N_s_m2": 5}]})";
  std::string objects;
  const auto add = [&objects](const std::string& name, const std::string& shape, double x_m,
                              double z_m = 0.0) {
    objects += R"({"name": ")" + name + R"(", "shape": {)" + shape + R"(}, "pose": {"position_m": [)" +
               std::to_string(x_m) + ", 0, " + std::to_string(z_m) + R"(], "rotation_deg": [0, 10, 0]},
      "material": {"stiffness_N_m": 600, "damping_N_s_m": 1, "static_friction": 0.4, "dynamic_friction": 0.3}},)";
  };
  if (more) add("another needle", needle, 0, -0.5);
  for (int i = 0; i < 5; ++i) {
    if (i == left_out) continue;
    if (i == 2 && more) add("another tissue", tissue, -0.2);
    const double x_m = 0.1 * (i % 4) + (i == moved ? 0.005 : 0.0);
    add("volume " + std::to_string(i), i == 4 ? slow : i == 1 ? needle : tissue, x_m, i == 1 ? -0.1 : 0.0);
  }
  objects += R"({"name": "far", "shape": {"sphere": {"radius_m": 0.01}}, "pose": {"position_m": [1, 0, 0]},
    "material": {"stiffness_N_m": 600}})";
  return SceneImage(host::compile_scene_text(R"({"thimble_scene": 1, "name": "volumes", "tip_radius_m": )" +
                                                 std::to_string(tip_radius_m) + R"(, "objects": [)" +
                                                 objects + "]}",
                                             "volumes.scene.json", ".")
                        .image);
}

// A finger in tissue and a needle in its hole, while volumes beside them go, come and move: the force is that without the edit, to the bit.
TEST(SceneEdits, LeaveATissueDentedAndANeedleInItsHole) {
  const SceneImage before = scene_with_volumes(-1, false, -1);
  for (int touched = 0; touched < 4; ++touched) {
    const double skin_m = touched == 1 ? -0.1 : 0.0;
    const Eigen::Vector3d above_m(0.1 * touched, 0, skin_m + 0.01);
    const Eigen::Vector3d in_m(0.1 * touched, 0.001, skin_m - 0.009);
    const Eigen::Vector3d out_m(0.1 * touched + 0.003, 0, skin_m + 0.01);
    for (int edited = -1; edited < 5; ++edited) {
      for (const bool more : {false, true}) {
        for (const bool moves : {false, true}) {
          if (edited == touched || (touched == 0 && edited == 4)) continue;  // both are touched there
          const SceneImage after = scene_with_volumes(moves ? -1 : edited, more, moves ? edited : -1);
          Press edits(before);
          Press leaves(before);
          for (Press* finger : {&edits, &leaves}) {
            finger->tick(above_m);
            finger->move(above_m, in_m, 200);
          }
          ASSERT_GT(leaves.force_N().norm(), 0.3) << touched;
          edits.renderer.bind(after.view(), Binding::kKeepPlaces);
          for (int i = 1; i <= 400; ++i) {
            const Eigen::Vector3d tip_m = in_m + (out_m - in_m) * std::max(0, i - 100) / 300;
            edits.tick(tip_m);
            leaves.tick(tip_m);
            ASSERT_EQ(edits.force_N(), leaves.force_N()) << touched << ", " << edited << ", tick " << i;
          }
        }
      }
    }
    // One that is edited itself begins anew, and with a tip of another radius all do: a tip that is in it has done no work.
    for (const SceneImage& after :
         {scene_with_volumes(4, false, touched), scene_with_volumes(-1, false, -1, 0.004)}) {
      Press finger(before);
      finger.tick(above_m);
      finger.move(above_m, in_m, 200);
      finger.renderer.bind(after.view(), Binding::kKeepPlaces);
      finger.tick(in_m);
      EXPECT_LT(finger.force_N().norm(), 0.3) << touched;
    }
    // And so does each in another scene, or in this one from its start.
    Press starts(before);
    starts.tick(above_m);
    starts.move(above_m, in_m, 200);
    starts.renderer.bind(before.view(), Binding::kStart);
    starts.tick(in_m);
    EXPECT_LT(starts.force_N().norm(), 0.3) << touched;
  }
}

// As many as there can be, all of them moved at once, again and again.
TEST(SceneEdits, OfEveryVolumeAreBound) {
  const auto scene = [](double z_m, double first_up_m = 0.0) {
    std::string objects;
    for (std::size_t i = 0; i < control::kMaxVolumes; ++i)
      objects += std::string(i == 0 ? "" : ",") + R"({"name": "t)" + std::to_string(i) +
                 R"(", "material": {"stiffness_N_m": 600}, "shape": {"tissue": {"size_m": [0.06, 0.06],
          "relaxed_stiffness_N_m": 150, "recovery_s": 0.4, "contact_radius_m": 0.008}}, "pose": {"position_m": [)" +
                 std::to_string(0.1 * static_cast<double>(i)) + ", 0, " +
                 std::to_string(z_m + (i == 0 ? first_up_m : 0.0)) + "]}}";
    return SceneImage(
        host::compile_scene_text(R"({"thimble_scene": 1, "name": "all", "objects": [)" + objects + "]}",
                                 "all.scene.json", ".")
            .image);
  };
  const std::array scenes = {scene(0.0), scene(0.001)};
  Press finger(scenes[0]);
  for (std::size_t edit = 1; edit < 6; ++edit) {
    finger.renderer.bind(scenes[edit % 2].view(), Binding::kKeepPlaces);
    for (std::size_t i = 0; i < control::kMaxVolumes; ++i) {
      const double x_m = 0.1 * static_cast<double>(i);
      const double surface_m = edit % 2 == 1 ? 0.001 : 0.0;
      finger.tick({x_m, 0, 0.01});
      finger.tick({x_m, 0, surface_m - 0.001});
      EXPECT_NEAR(finger.force_N().z(), 0.6, 0.01) << edit << ", " << i;
      finger.move({x_m, 0, 0.01}, {x_m, 0, 0.01}, 2000);  // the dimple recovers
    }
  }
  // Of as many as there can be, only the first one moves: a finger in the last one presses on.
  Press presses(scenes[0]);
  const double x_m = 0.1 * (control::kMaxVolumes - 1);
  presses.tick({x_m, 0, 0.01});
  presses.tick({x_m, 0, -0.005});
  const Eigen::Vector3d force_N = presses.force_N();
  const SceneImage one_moved = scene(0.0, 0.001);
  presses.renderer.bind(one_moved.view(), Binding::kKeepPlaces);
  presses.tick({x_m, 0, -0.005});
  EXPECT_NEAR(presses.force_N().z(), force_N.z(), 0.01 * force_N.z());
}

}  // namespace
}  // namespace thimble::test
