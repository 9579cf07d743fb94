// Hostile images of control elements: each out-of-range number is refused by name, and accepted elements stay
// finite, between their stops and within their bounds of speed for any tip motion.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
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

constexpr int kControlMutants = kUnderSanitizers ? 1'000 : 4'000;

const Bytes& control_image() {
  static const Bytes bytes =
      host::compile_scene_text(R"({ "thimble_scene": 1, "name": "controls", "objects": [
{ "name": "fader", "shape": { "box": { "size_m": [0.02, 0.02, 0.02] } }, "material": { "stiffness_N_m": 500, "static_friction": 0.5 },
  "body": { "motion": "slide", "mass_kg": 0.05, "axis": [1, 0, 0], "restitution": 0.5, "control": {
    "stiffness_N_m": 20, "rest_m": -0.001, "damping_N_s_m": 0.5, "friction_N": 0.2, "low_m": -0.02, "high_m": 0.03,
    "detents": { "pitch_m": 0.005, "phase_m": 0.001, "force_N": 0.8 }, "curve_m_N": [[0, 0.5], [0.01, 1.5], [0.02, 1]],
    "switch": { "on_at_m": 0.02, "off_at_m": 0.01 } } } },
{ "name": "knob", "shape": { "cylinder": { "radius_m": 0.02, "height_m": 0.01 } }, "pose": { "position_m": [0, 0, -0.02] },
  "material": { "stiffness_N_m": 500, "static_friction": 1 },
  "body": { "motion": "turn", "mass_kg": 0.05, "axis": [0, 0, 1], "pivot_m": [0, 0.005, 0], "control": {
    "stiffness_N_m_rad": 0.1, "rest_deg": 9, "damping_N_m_s_rad": 0.0001, "friction_N_m": 0.002, "low_deg": -180, "high_deg": 45,
    "detents": { "pitch_deg": 30, "phase_deg": 15, "torque_N_m": 0.03 }, "curve_deg_N_m": [[-10, 0.5], [10, -0.5]],
    "switch": { "on_at_deg": -30, "off_at_deg": -10 } } } } ] })",
                               "seed.scene.json", ".")
          .image;
  return bytes;
}

const scene::Control& control_of(const scene::Scene& scene, unsigned object) {
  return *scene.objects()->Get(object)->body()->control();
}

// A table's float, by its vtable slot: where it stands in the image that is being changed.
void set(Bytes& bytes, unsigned object, flatbuffers::voffset_t field, float value) {
  const auto& table =
      reinterpret_cast<const flatbuffers::Table&>(control_of(*scene::GetScene(bytes.data()), object));
  const std::uint8_t* place = table.GetAddressOf(field);
  ASSERT_NE(place, nullptr);
  std::memcpy(bytes.data() + (place - reinterpret_cast<const std::uint8_t*>(bytes.data())), &value,
              sizeof value);
}

TEST(ControlImage, EachNumberOutOfItsRangeIsRefusedByName) {
  using C = scene::Control;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  struct Case {
    flatbuffers::voffset_t field;
    std::vector<float> bad;
  };
  const std::vector<Case> cases{{C::VT_STIFFNESS, {-1.0F, 2.0e5F}},
                                {C::VT_REST, {-101.0F, 101.0F}},
                                {C::VT_DAMPING, {-0.1F, 1001.0F}},
                                {C::VT_FRICTION, {-0.1F, 101.0F}},
                                {C::VT_LOW, {0.001F, -101.0F}},
                                {C::VT_HIGH, {-0.001F, 101.0F}},
                                {C::VT_DETENT_PITCH, {-0.001F, 1.0e-5F, 101.0F}},
                                {C::VT_DETENT_PHASE, {-101.0F, 101.0F}},
                                {C::VT_DETENT_EFFORT, {-0.1F, 101.0F}},
                                {C::VT_ON_AT, {-101.0F, 101.0F}},
                                {C::VT_OFF_AT, {-101.0F, 101.0F}}};
  for (const unsigned object : {0U, 1U}) {
    for (const Case& c : cases) {
      std::vector<float> bad = c.bad;
      bad.insert(bad.end(), {nan, infinite, -infinite});
      for (const float value : bad) {
        Bytes bytes = control_image();
        set(bytes, object, c.field, value);
        SceneView view;
        EXPECT_EQ(SceneView::check(bytes, view), ImageStatus::kBadNumber) << c.field << " " << value;
      }
    }
    // Points of the curve: not finite, too far, and a step back.
    for (const float value : {nan, infinite, 101.0F}) {
      for (const std::size_t offset : {0U, 4U}) {
        Bytes bytes = control_image();
        const auto* point = reinterpret_cast<const std::byte*>(
            control_of(*scene::GetScene(bytes.data()), object).curve()->Get(1));
        std::memcpy(bytes.data() + (point - bytes.data()) + offset, &value, sizeof value);
        SceneView view;
        EXPECT_EQ(SceneView::check(bytes, view), ImageStatus::kBadNumber) << value;
      }
    }
    Bytes falls = control_image();
    const auto* point = reinterpret_cast<const std::byte*>(
        control_of(*scene::GetScene(falls.data()), object).curve()->Get(1));
    const float back = -1.0F;
    std::memcpy(falls.data() + (point - falls.data()), &back, sizeof back);
    SceneView view;
    EXPECT_EQ(SceneView::check(falls, view), ImageStatus::kBadNumber);
    // Too stiff for a tick: for 0.05 kg above 5e4 N/m, for 2 x 10^-5 kg m2 far below.
    Bytes stiff = control_image();
    set(stiff, object, C::VT_STIFFNESS, 6.0e4F);
    EXPECT_EQ(SceneView::check(stiff, view), ImageStatus::kBadNumber);
  }
}

TEST(ControlImage, MutantsAreRefusedOrStayBetweenTheirStops) {
  Random random(7);
  static control::Renderer renderer;
  int accepted = 0, wrong = 0;
  for (int mutant = 0; mutant < kControlMutants; ++mutant) {
    Bytes bytes = control_image();
    // Numbers of a control most of the time, anything now and then.
    if (random.below(4) == 0) {
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1U << random.below(8));
    } else {
      using C = scene::Control;
      constexpr flatbuffers::voffset_t kFields[] = {
          C::VT_STIFFNESS,     C::VT_REST,  C::VT_DAMPING,      C::VT_FRICTION,
          C::VT_LOW,           C::VT_HIGH,  C::VT_DETENT_PITCH, C::VT_DETENT_PHASE,
          C::VT_DETENT_EFFORT, C::VT_ON_AT, C::VT_OFF_AT};
      for (std::uint64_t n = 1 + random.below(3); n > 0; --n) {
        const auto value = static_cast<float>(std::pow(10.0, random.uniform(-6.0, 3.0)) *
                                              (random.below(4) == 0 ? -1.0 : 1.0));
        set(bytes, static_cast<unsigned>(random.below(2)), kFields[random.below(std::size(kFields))], value);
      }
    }
    SceneView view;
    if (SceneView::check(bytes, view) != ImageStatus::kOk) continue;
    ++accepted;
    renderer.bind(view);
    Eigen::Vector3d p(0.0, 0.0, 0.03);
    bool sound = true;
    for (int tick = 0; tick < 400 && sound; ++tick) {
      p += (random.below(8) == 0 ? 3e-3 : 4e-4) * (0.03 * random.direction() - p).normalized();
      control::Tip tip;
      tip.position_m = p.cast<float>();
      control::Touch touch;
      renderer.tick(std::span(&tip, 1), 2.5e-4F, std::span(&touch, 1));
      sound = touch.force_N.allFinite() && touch.god_object_m.allFinite();
      for (const control::BodyState& body : renderer.bodies()) {
        const scene::Object& object = *view.scene()->objects()->Get(body.object);
        sound = sound && std::isfinite(body.q) && body.position_m.allFinite() &&
                body.rotation.coeffs().allFinite();
        if (object.body()->control() == nullptr) continue;
        const scene::Control& c = *object.body()->control();
        sound = sound && body.q >= c.low() && body.q <= c.high() && (c.has_switch() || !body.on);
      }
    }
    wrong += sound ? 0 : 1;
  }
  figure("mutants of controls accepted, of " + std::to_string(kControlMutants), accepted, "> a tenth");
  figure("accepted ones that left their stops or were not finite", wrong, "0");
  EXPECT_GT(accepted, kControlMutants / 10);
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace thimble::test
