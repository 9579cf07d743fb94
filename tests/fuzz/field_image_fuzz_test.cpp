// Hostile fields in scene images: every out-of-range number is refused by name, and accepted images render
// finite forces.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "control/scene/limits.h"
#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "tests/fuzz/image.h"
#include "tests/fuzz/wander.h"
#include "tests/support/figure.h"
#include "tests/support/sanitizers.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using control::ImageStatus;
using control::SceneView;

constexpr int kFieldMutants = kUnderSanitizers ? 1'000 : 10'000;

// Each kind of field, both surfaces that push and both laws.
const Bytes& field_image() {
  static const Bytes bytes = host::compile_scene_text(R"({"thimble_scene": 1, "name": "fields", "objects": [
{"name": "by hand", "shape": {"vector_field": {"subvolumes": [
  {"sides": [{"normal": [1, 0, 0], "offset_m": 0.01}], "plane": {"normal": [0, 0, 1], "offset_m": -0.01}},
  {"ball": {"centre_m": [0.03, 0, 0], "radius_m": 0.02}}]}},
  "pose": {"rotation_deg": [10, 20, 30]}, "material": {"stiffness_N_m": 1000, "damping_N_s_m": 2}},
{"name": "cube", "shape": {"vector_field": {"box": {"size_m": [0.02, 0.03, 0.04]}}}, "material": {"stiffness_N_m": 500}},
{"name": "soft", "shape": {"potential_field": {"shape": {"sphere": {"radius_m": 0.013}}, "step_m": 0.006, "source_per_m": 200}},
  "pose": {"position_m": [-0.02, 0, 0.01]}, "material": {"stiffness_N_m": 500, "damping_N_s_m": 2}},
{"name": "sharp", "shape": {"potential_field": {"shape": {"box": {"size_m": [0.03, 0.026, 0.026]}}, "step_m": 0.006,
  "law": "energy", "source_N_m": 40}}, "pose": {"position_m": [0, 0.03, 0]}, "material": {"stiffness_N_m": 500}},
{"name": "wind", "shape": {"force_field": {"constant_N": [1, 2, 3], "stiffness_N_m": [0, 100, 0], "damping_N_s_m": [1, 1, 1],
  "curl_N_s_m": [0, 0, 5], "size_m": [0.2, 0.2, 0.2]}}},
{"name": "cup", "shape": {"force_field": {"mass": {"mass_kg": 0.2, "stiffness_N_m": 100, "damping_N_s_m": 1}}}}]})",
                                                      "seed", ".")
                                 .image;
  return bytes;
}

TEST(FieldImage, MutantsAreRefusedOrLivedWith) {
  mutants_are_refused_or_lived_with("fields", field_image(), kFieldMutants, 7);
}

using Field = std::function<const void*(const scene::Object&)>;

// The image with one field of one object changed; `field` points into it.
template <typename Value>
Bytes field_with(unsigned object, const Field& field, Value value) {
  return changed(field_image(), field(*scene::GetScene(field_image().data())->objects()->Get(object)), value);
}

TEST(FieldImage, EachFieldOutOfItsRangeIsRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  constexpr unsigned kHand = 0;
  constexpr unsigned kCube = 1;
  constexpr unsigned kSoft = 2;
  using O = const scene::Object&;
  const auto subvolume = [](O o, unsigned i = 0) { return o.shape_as_VectorField()->subvolumes()->Get(i); };
  const Field side = [=](O o) -> const void* { return subvolume(o)->sides()->Get(0); };
  const Field side_offset = [=](O o) -> const void* { return part(subvolume(o)->sides()->Get(0), 12); };
  const Field plane = [=](O o) -> const void* { return subvolume(o)->plane(); };
  const Field plane_offset = [=](O o) -> const void* { return part(subvolume(o)->plane(), 12); };
  const Field centre = [=](O o) -> const void* { return subvolume(o, 1)->centre_m(); };
  const Field radius = [=](O o) { return scalar(subvolume(o, 1), scene::Subvolume::VT_RADIUS_M); };
  const Field sides = [=](O o) -> const void* { return subvolume(o)->sides(); };
  const Field lo = [](O o) -> const void* { return o.shape_as_VectorField()->lo_m(); };
  const Field hi = [](O o) -> const void* { return part(o.shape_as_VectorField()->hi_m(), 8); };
  const auto field = [](O o) { return o.shape_as_PotentialField(); };
  const Field count = [=](O o) -> const void* { return field(o)->count()->Data(); };
  const Field counts = [=](O o) -> const void* { return field(o)->count(); };
  const Field origin = [=](O o) -> const void* { return field(o)->origin_m(); };
  const Field step = [=](O o) { return scalar(field(o), scene::PotentialField::VT_STEP_M); };
  const Field law = [=](O o) { return scalar(field(o), scene::PotentialField::VT_LAW); };
  const Field coefficient = [=](O o) -> const void* { return part(field(o)->coefficients()->Data(), 40); };
  const Field stiffness = [](O o) -> const void* { return o.material(); };
  constexpr unsigned kSharp = 3;
  constexpr unsigned kWind = 4;
  constexpr unsigned kCup = 5;
  // Of the n-th number of a force field.
  const auto wind = [](std::size_t n) -> Field {
    return [n](O o) -> const void* { return part(o.shape_as_ForceField(), 4 * n); };
  };
  struct Case {
    std::string what;
    Bytes bytes;
    ImageStatus expected;
  };
  const std::vector<Case> cases = {
      {"side's normal not a number", field_with(kHand, side, nan), ImageStatus::kBadNumber},
      {"side's normal of length 0", field_with(kHand, side, std::array<float, 3>{}), ImageStatus::kBadNumber},
      {"side's offset infinite", field_with(kHand, side_offset, infinite), ImageStatus::kBadNumber},
      {"plane's normal of length 2", field_with(kHand, plane, std::array<float, 3>{0.0F, 0.0F, 2.0F}),
       ImageStatus::kBadNumber},
      {"plane's offset not a number", field_with(kHand, plane_offset, nan), ImageStatus::kBadNumber},
      {"plane's offset 21 m", field_with(kHand, plane_offset, 21.0F), ImageStatus::kBadNumber},
      {"ball's centre not a number", field_with(kHand, centre, nan), ImageStatus::kBadNumber},
      {"ball's radius negative", field_with(kHand, radius, -0.01F), ImageStatus::kBadNumber},
      {"ball's radius not a number", field_with(kHand, radius, nan), ImageStatus::kBadNumber},
      {"sides beyond the image", field_with(kHand, sides, 0x00FFFFFFU), ImageStatus::kNotAScene},
      {"box not a number", field_with(kCube, lo, nan), ImageStatus::kBadNumber},
      {"box 11 m away", field_with(kCube, hi, 11.0F), ImageStatus::kBadNumber},
      {"stiffness zero", field_with(kCube, stiffness, 0.0F), ImageStatus::kBadNumber},
      {"count 3", field_with(kSoft, count, std::uint16_t{3}), ImageStatus::kBadIndex},
      {"count too large for the coefficients", field_with(kSoft, count, std::uint16_t{12}),
       ImageStatus::kBadIndex},
      {"counts beyond the limit", field_with(kSoft, count, std::array<std::uint16_t, 3>{200, 200, 200}),
       ImageStatus::kTooManySamples},
      {"counts that overflow", field_with(kSoft, count, std::array<std::uint16_t, 3>{65535, 65535, 65535}),
       ImageStatus::kTooManySamples},
      {"two counts", field_with(kSoft, counts, 2U), ImageStatus::kBadIndex},
      {"origin infinite", field_with(kSoft, origin, infinite), ImageStatus::kBadNumber},
      {"step zero", field_with(kSoft, step, 0.0F), ImageStatus::kBadNumber},
      {"step not a number", field_with(kSoft, step, nan), ImageStatus::kBadNumber},
      {"step 11 m", field_with(kSoft, step, 11.0F), ImageStatus::kBadNumber},
      {"law 7", field_with(kSharp, law, std::uint8_t{7}), ImageStatus::kBadNumber},
      {"coefficient not a number", field_with(kSoft, coefficient, nan), ImageStatus::kBadNumber},
      {"constant force over its limit", field_with(kWind, wind(1), 101.0F), ImageStatus::kBadNumber},
      {"stiffness of a field below zero", field_with(kWind, wind(3), -1.0F), ImageStatus::kBadNumber},
      {"damping of a field below zero", field_with(kWind, wind(8), -1.0F), ImageStatus::kBadNumber},
      {"curl not a number", field_with(kWind, wind(9), nan), ImageStatus::kBadNumber},
      {"box of a field below zero", field_with(kWind, wind(12), -1.0F), ImageStatus::kBadNumber},
      {"mass too small", field_with(kCup, wind(15), 1.0e-5F), ImageStatus::kBadNumber},
      {"mass below zero", field_with(kCup, wind(15), -1.0F), ImageStatus::kBadNumber},
      {"spring of a mass infinite", field_with(kCup, wind(16), infinite), ImageStatus::kBadNumber},
      {"damper of a mass below zero", field_with(kCup, wind(17), -1.0F), ImageStatus::kBadNumber},
      {"trial 256", field_with(kWind, wind(18), std::uint32_t{256}), ImageStatus::kBadNumber},
      {"coefficient over its limit", field_with(kSoft, coefficient, 2.0F * control::kMaxPotential),
       ImageStatus::kBadNumber}};
  int wrong = 0;
  for (const Case& test : cases) {
    SceneView view;
    const ImageStatus status = SceneView::check(test.bytes, view);
    EXPECT_EQ(status, test.expected) << test.what << ": " << control::name(status) << ", not "
                                     << control::name(test.expected);
    wrong += status != test.expected ? 1 : 0;
  }
  figure("numbers of fields out of range not refused by name, of " + std::to_string(cases.size()), wrong,
         "0");
}

}  // namespace
}  // namespace thimble::test
