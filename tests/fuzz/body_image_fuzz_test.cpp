// Hostile images of bodies: each out-of-range number is refused by name, and accepted images stay finite and
// within their bounds of speed and position for any tip motion.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "control/renderer.h"
#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "tests/fuzz/image.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using control::ImageStatus;
using control::SceneView;

constexpr int kBodyMutants = kUnderSanitizers ? 500 : 3'000;

const Bytes& body_image() {
  static const Bytes bytes =
      host::compile_scene_text(R"({ "thimble_scene": 1, "name": "bodies", "gravity_m_s2": [0, 0, -9.81],
"materials": { "m": { "stiffness_N_m": 500, "damping_N_s_m": 1, "static_friction": 0.5, "dynamic_friction": 0.4 } }, "objects": [
{ "name": "floor", "shape": { "plane": { "normal": [0, 0, 1], "offset_m": -0.03 } }, "material": "m" },
{ "name": "block", "shape": { "box": { "size_m": [0.02, 0.02, 0.02] } }, "material": "m",
  "body": { "motion": "free", "mass_kg": 0.05, "spin_rad_s": [1, 2, 3], "restitution": 0.5, "angular_damping_N_m_s": 1e-5 } },
{ "name": "ball", "shape": { "sphere": { "radius_m": 0.01 } }, "material": "m", "pose": { "position_m": [0.03, 0, 0] },
  "body": { "motion": "translate", "mass_kg": 0.05, "velocity_m_s": [1, 2, 3], "spring_N_m": 10, "damping_N_s_m": 0.1 } },
{ "name": "puck", "shape": { "cylinder": { "radius_m": 0.01, "height_m": 0.01 } }, "material": "m", "pose": { "position_m": [-0.03, 0, 0] },
  "body": { "motion": "plane", "mass_kg": 0.05 } },
{ "name": "lump", "shape": { "sphere": { "radius_m": 0.01 } }, "pose": { "position_m": [0, -0.03, 0] },
  "material": { "stiffness_N_m": 500, "stiffness_map": { "stiffness_N_m": [[100, 200], [300, 400]], "cell_m": 0.01 } },
  "body": { "motion": "free", "mass_kg": 0.05 } },
{ "name": "pill", "shape": { "capsule": { "radius_m": 0.01, "height_m": 0.01 } }, "material": "m", "pose": { "position_m": [0, 0.03, 0] },
  "body": { "motion": "free", "mass_kg": 0.05 } },
{ "name": "hat", "shape": { "cone": { "radius_m": 0.01, "height_m": 0.02 } }, "material": "m", "pose": { "position_m": [0.02, 0.03, 0] },
  "body": { "motion": "free", "mass_kg": 0.05 } } ] })",
                               "seed.scene.json", ".")
          .image;
  return bytes;
}

Bytes body_with(const void* (*place)(const scene::Scene&), float value) {
  return changed(body_image(), place(*scene::GetScene(body_image().data())), value);
}

template <flatbuffers::voffset_t kField, int kOffset = 0>
const void* field_of_block(const scene::Scene& scene) {
  const auto& table = reinterpret_cast<const flatbuffers::Table&>(*scene.objects()->Get(1)->body());
  return table.GetAddressOf(kField) + kOffset;
}

TEST(BodyImage, EachNumberOutOfItsRangeIsRefusedByName) {
  using B = scene::Body;
  struct Case {
    const void* (*place)(const scene::Scene&);
    std::vector<float> bad;
  };
  const std::vector<Case> cases{
      {field_of_block<B::VT_MASS_KG>, {0.0F, -1.0F, 1.0e-4F, 1001.0F}},
      {field_of_block<B::VT_INERTIA_KG_M2>, {0.0F, -1.0F, 1.0e7F}},
      {field_of_block<B::VT_INERTIA_KG_M2, 8>, {0.0F, 1.0e7F}},
      {field_of_block<B::VT_RESTITUTION>, {-0.1F, 1.1F}},
      {field_of_block<B::VT_VELOCITY_M_PER_S>, {11.0F, -11.0F}},
      {field_of_block<B::VT_SPIN_RAD_PER_S, 4>, {101.0F, -101.0F}},
      {field_of_block<B::VT_ANGULAR_DAMPING_N_M_S>, {-1.0F, 1001.0F}},
      {field_of_block<B::VT_AXIS, 8>, {0.0F, 2.0F}},
      {field_of_block<B::VT_PIVOT_M>, {11.0F}},
      {[](const scene::Scene& s) -> const void* {
         return s.objects()->Get(4)->surface()->stiffness_map()->stiffness_n_per_m()->Data() + 4;
       },
       {-1.0F, 5.1e4F}},  // at 50 g, 5e4 N/m is the most
      {[](const scene::Scene& s) -> const void* { return s.gravity_m_per_s2(); }, {11.0F}},
  };
  int tried = 0;
  for (const Case& each : cases) {
    std::vector<float> bad = each.bad;
    bad.push_back(std::numeric_limits<float>::quiet_NaN());
    bad.push_back(std::numeric_limits<float>::infinity());
    for (const float value : bad) {
      SceneView view;
      EXPECT_EQ(SceneView::check(body_with(each.place, value), view), ImageStatus::kBadNumber)
          << tried << " " << value;
      ++tried;
    }
  }
  figure("numbers of a body out of range", tried, "each refused as bad_number");
}

TEST(BodyImage, WhatIsAcceptedStaysInItsBounds) {
  Random random(9);
  int accepted = 0;
  int astray = 0;
  for (int mutant = 0; mutant < kBodyMutants; ++mutant) {
    Bytes bytes = body_image();
    for (std::uint64_t flip = 0; flip < 1 + random.below(6); ++flip)
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1U << random.below(8));
    SceneView view;
    if (SceneView::check(bytes, view) != ImageStatus::kOk) continue;
    ++accepted;
    static control::Renderer renderer;
    renderer.bind(view);
    std::array<control::Tip, 2> tips;
    std::array<control::Touch, 2> touches;
    for (int tick = 0; tick < 200; ++tick) {
      for (control::Tip& tip : tips)
        tip.position_m += (random.below(8) == 0 ? 1e-2F : 3e-4F) * random.direction().cast<float>();
      renderer.tick(tips, 2.5e-4F, touches);
      bool sound = touches[0].force_N.allFinite() && touches[1].god_object_m.allFinite();
      for (const control::BodyState& body : renderer.bodies()) {
        sound = sound && body.velocity_m_s.norm() <= 1.001F * control::kMaxBodySpeed_m_s + 100.0F * 20.0F &&
                body.spin_rad_s.norm() <= 1.001F * control::kMaxSmallBodySpin_rad_s &&
                body.position_m.cwiseAbs().maxCoeff() <= 3.0F * control::kMaxCoordinate_m &&
                std::abs(body.rotation.norm() - 1.0F) < 1e-3F;
      }
      if (!sound) {
        ++astray;
        break;
      }
    }
  }
  figure("mutants of bodies accepted and played for 200 ticks", accepted, "> 100");
  figure("of them, not finite or out of bounds", astray, "0");
  EXPECT_GT(accepted, 100);
  EXPECT_EQ(astray, 0);
}

}  // namespace
}  // namespace thimble::test
