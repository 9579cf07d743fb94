// Hostile images of needle layers and tissues: each out-of-range number is refused by name, and accepted
// images stay finite and return no more energy than they received.
#include <gtest/gtest.h>

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

constexpr int kTissueMutants = kUnderSanitizers ? 1'000 : 4'000;

const Bytes& tissue_image() {
  static const Bytes bytes = host::compile_scene_text(R"({ "thimble_scene": 1, "name": "soft", "objects": [
{ "name": "way", "material": { "stiffness_N_m": 600, "damping_N_s_m": 1 }, "shape": { "needle": { "layers": [
  { "thickness_m": 0.002, "stiffness_N_m": 800, "tear_N": 1.5, "friction_N": 0.2, "viscosity_N_s_m2": 10 },
  { "thickness_m": 0.004, "stiffness_N_m": 0, "tear_N": 0 },
  { "thickness_m": 0.01, "stiffness_N_m": 300, "tear_N": 0.6, "friction_N": 0.1, "viscosity_N_s_m2": 5 } ] } } },
{ "name": "pad", "material": { "stiffness_N_m": 400, "static_friction": 0.5, "dynamic_friction": 0.4 },
  "shape": { "tissue": { "size_m": [0.08, 0.06], "contact_radius_m": 0.006, "relaxed_stiffness_N_m": 150, "recovery_s": 0.3 } } } ] })",
                                                      "seed.scene.json", ".")
                                 .image;
  return bytes;
}

// The floats of a layer and of the tissue, as the image holds them.
constexpr std::size_t kFloats = 5;
const std::byte* start_of(const Bytes& bytes, bool of_tissue, unsigned layer = 0) {
  const scene::Scene& scene = *scene::GetScene(bytes.data());
  const void* place =
      of_tissue ? static_cast<const void*>(scene.objects()->Get(1)->shape_as_Tissue())
                : static_cast<const void*>(scene.objects()->Get(0)->shape_as_Needle()->layers()->Get(layer));
  return static_cast<const std::byte*>(place);
}
void set(Bytes& bytes, const std::byte* start, std::size_t field, float value) {
  std::memcpy(bytes.data() + (start - bytes.data()) + 4 * field, &value, sizeof value);
}

TEST(TissueImage, EachNumberOutOfItsRangeIsRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  // In the order of control/scene/scene.fbs.
  const std::vector<std::vector<float>> layer{
      {0.0F, -1.0F, 11.0F}, {-1.0F, 0.0F, 2e5F}, {-0.1F, 101.0F}, {-0.1F, 101.0F}, {-1.0F, 2e4F}};
  const std::vector<std::vector<float>> tissue{
      {0.0F, 11.0F}, {-0.1F, 11.0F}, {0.0F, 11.0F}, {0.0F, 0.39F, 401.0F}, {0.0F, 0.0009F, 3601.0F}};
  int tried = 0;
  for (const bool of_tissue : {false, true}) {
    for (std::size_t field = 0; field < kFloats; ++field) {
      std::vector<float> bad = (of_tissue ? tissue : layer)[field];
      bad.insert(bad.end(), {nan, infinite, -infinite});
      for (const float value : bad) {
        Bytes bytes = tissue_image();
        set(bytes, start_of(bytes, of_tissue), field, value);
        SceneView view;
        EXPECT_EQ(SceneView::check(bytes, view), ImageStatus::kBadNumber)
            << of_tissue << " " << field << " " << value;
        ++tried;
      }
    }
  }
  Bytes gap = tissue_image();
  set(gap, start_of(gap, false, 1), 2, 1.0F);
  SceneView view;
  EXPECT_EQ(SceneView::check(gap, view), ImageStatus::kBadNumber) << "a gap that tears";
  figure("numbers out of range tried", tried, "each refused by name");
}

TEST(TissueImage, MutantsAreRefusedOrStayFiniteAndPassive) {
  Random random(11);
  static control::Renderer renderer;
  int accepted = 0, wrong = 0, gave = 0;
  for (int mutant = 0; mutant < kTissueMutants; ++mutant) {
    Bytes bytes = tissue_image();
    if (random.below(4) == 0) {
      bytes[random.below(bytes.size())] ^= static_cast<std::byte>(1U << random.below(8));
    } else {
      for (std::uint64_t n = 1 + random.below(3); n > 0; --n) {
        const auto value = static_cast<float>(std::pow(10.0, random.uniform(-6.0, 4.0)));
        set(bytes, start_of(bytes, random.below(2) == 0, static_cast<unsigned>(random.below(3))),
            random.below(kFloats), value);
      }
    }
    SceneView view;
    if (SceneView::check(bytes, view) != ImageStatus::kOk) continue;
    ++accepted;
    renderer.bind(view);
    Eigen::Vector3d p(0.0, 0.0, 0.001);
    Eigen::Vector3d last = p;
    Eigen::Vector3d last_force = Eigen::Vector3d::Zero();
    double work = 0, most_N = 0;
    bool sound = true;
    for (int tick = 0; tick < 400 && sound; ++tick) {
      p += (random.below(8) == 0 ? 2e-3 : 2e-4) * (0.02 * random.direction() - p).normalized();
      control::Tip tip;
      tip.position_m = p.cast<float>();
      tip.velocity_m_s = ((p - last) * 4000.0).cast<float>();
      control::Touch touch;
      renderer.tick(std::span(&tip, 1), 2.5e-4F, std::span(&touch, 1));
      sound = touch.force_N.allFinite() && touch.god_object_m.allFinite() && touch.contacts <= 3;
      const Eigen::Vector3d force = touch.force_N.cast<double>();
      work += 0.5 * (force + last_force).dot(p - last);
      most_N = std::max(most_N, force.norm());
      last = p;
      last_force = force;
    }
    wrong += sound ? 0 : 1;
    gave += work > 2e-3 * most_N ? 1 : 0;  // at most the longest step at the greatest force
  }
  figure("mutants of soft things accepted, of " + std::to_string(kTissueMutants), accepted, "> a tenth");
  figure("accepted ones that were not finite", wrong, "0");
  figure("accepted ones that gave the hand energy", gave, "0");
  EXPECT_GT(accepted, kTissueMutants / 10);
  EXPECT_EQ(wrong, 0);
  EXPECT_EQ(gave, 0);
}

}  // namespace
}  // namespace thimble::test
