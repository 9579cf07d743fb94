// Hostile surfaces in scene images: every out-of-range number is refused by name, and accepted images render
// finite forces.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
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
#include "tests/support/temporary_folder.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::test {
namespace {

using control::ImageStatus;
using control::SceneView;

constexpr int kSurfaceMutants = kUnderSanitizers ? 1'000 : 10'000;

// An octahedron with texture coordinates: its faces join.
class GemFolder : public TemporaryFolder {
 public:
  GemFolder() {
    write("gem.obj",
          "v 0.015 0 0\nv -0.015 0 0\nv 0 0.015 0\nv 0 -0.015 0\nv 0 0 0.015\nv 0 0 -0.015\n"
          "vt 1 0\nvt -1 0\nvt 0 1\nvt 0 -1\nvt 0.5 0.5\nvt -0.5 -0.5\n"
          "f 1/1 3/3 5/5\nf 3/3 2/2 5/5\nf 2/2 4/4 5/5\nf 4/4 1/1 5/5\n"
          "f 3/3 1/1 6/6\nf 2/2 3/3 6/6\nf 4/4 2/2 6/6\nf 1/1 4/4 6/6\n");
  }
};

// Each effect, on a shape of each kind that can have it.
const Bytes& surface_image() {
  static const Bytes bytes = host::compile_scene_text(R"({"thimble_scene": 1, "name": "surfaces", "objects": [
{"name": "floor", "shape": {"plane": {"normal": [0, 0, 1], "offset_m": -0.02}}, "material": {"stiffness_N_m": 1000,
  "static_friction": 0.4, "click": {"amplitude_N": 1, "frequency_Hz": 200, "decay_per_s": 80}, "brake_friction": 0.2,
  "texture": {"kind": "height", "tile_m": [0.01, 0.01], "height_m": 0.001, "heights": [[0, 1, 0], [2, 1, 3], [1, 1, 4]]},
  "stiffness_map": {"stiffness_N_m": [[300, 500], [400, 600]], "damping_N_s_m": [[1, 2], [3, 4]], "cell_m": 0.01}}},
{"name": "ball", "shape": {"sphere": {"radius_m": 0.02}}, "pose": {"position_m": [0.04, 0.04, 0]}, "material": {"stiffness_N_m": 1000,
  "stiffness_map": {"stiffness_N_m": [[300, 500], [400, 600]], "cell_m": 0.01}}},
{"name": "can", "shape": {"cylinder": {"radius_m": 0.01, "height_m": 0.02}}, "pose": {"position_m": [-0.04, -0.04, 0]},
  "material": {"stiffness_N_m": 1000,
  "texture": {"kind": "normal", "tile_m": [0.01, 0.01], "height_m": 0.001, "heights": [[0, 1], [2, 1]]}}},
{"name": "crate", "shape": {"box": {"size_m": [0.03, 0.02, 0.01]}}, "pose": {"position_m": [-0.04, 0.04, 0], "rotation_deg": [10, 20, 30]},
  "material": {"stiffness_N_m": 1000, "static_friction": 0.3,
  "texture": {"kind": "lateral", "tile_m": [0.01, 0.01], "height_m": 0.001, "heights": [[0, 1], [2, 1]]}}},
{"name": "gem", "shape": {"mesh": {"file": "gem.obj"}}, "pose": {"position_m": [0.04, -0.04, 0]}, "material": {"stiffness_N_m": 1000,
  "texture": {"kind": "height", "mapping": "triplanar", "tile_m": [0.01, 0.01], "height_m": 0.001, "heights": [[0, 1], [2, 1]]}}},
{"name": "wrapped gem", "shape": {"mesh": {"file": "gem.obj", "crease_deg": 180}}, "pose": {"position_m": [0, 0.04, 0]},
  "material": {"stiffness_N_m": 1000,
  "texture": {"kind": "lateral", "mapping": "uv", "tile_m": [0.01, 0.01], "height_m": 0.001, "heights": [[0, 1], [2, 1]]}}}]})",
                                                      "seed", GemFolder().path())
                                 .image;
  return bytes;
}

TEST(SurfaceImage, MutantsAreRefusedOrLivedWith) {
  mutants_are_refused_or_lived_with("surfaces", surface_image(), kSurfaceMutants, 6);
}

// The image with one field changed; `field` points into it.
template <typename Value>
Bytes surface_with(const std::function<const void*(const scene::Surface&)>& field, Value value,
                   unsigned object = 0) {
  return changed(surface_image(),
                 field(*scene::GetScene(surface_image().data())->objects()->Get(object)->surface()), value);
}

TEST(SurfaceImage, EachFieldOutOfItsRangeIsRefusedByName) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  using S = const scene::Surface&;
  const auto click = [](std::size_t offset) {
    return [offset](S s) -> const void* { return part(s.click(), offset); };
  };
  // A scalar of a table has no address in the interface: by its offset in the vtable.
  const auto texture = [](flatbuffers::voffset_t field) {
    return [field](S s) -> const void* {
      const auto* table = reinterpret_cast<const flatbuffers::Table*>(s.texture());
      return table->GetAddressOf(field);
    };
  };
  const auto map = [](flatbuffers::voffset_t field) {
    return [field](S s) -> const void* {
      const auto* table = reinterpret_cast<const flatbuffers::Table*>(s.stiffness_map());
      return table->GetAddressOf(field);
    };
  };
  const auto brake = [](S s) -> const void* {
    return reinterpret_cast<const flatbuffers::Table*>(&s)->GetAddressOf(scene::Surface::VT_BRAKE_FRICTION);
  };
  const auto height = [](S s) -> const void* { return s.texture()->height_m()->Data() + 4; };
  const auto stiffness = [](S s) -> const void* {
    return s.stiffness_map()->stiffness_n_per_m()->Data() + 4;
  };
  const auto damping = [](S s) -> const void* { return s.stiffness_map()->damping_n_s_per_m()->Data() + 4; };
  struct Case {
    std::string what;
    Bytes bytes;
    ImageStatus expected;
  };
  using T = scene::Texture;
  using M = scene::StiffnessMap;
  const std::vector<Case> cases = {
      {"click's amplitude not a number", surface_with(click(0), nan), ImageStatus::kBadNumber},
      {"click's amplitude over its limit", surface_with(click(0), 2.0F * control::kMaxClick_N),
       ImageStatus::kBadNumber},
      {"click's frequency zero", surface_with(click(4), 0.0F), ImageStatus::kBadNumber},
      {"click's decay negative", surface_with(click(8), -1.0F), ImageStatus::kBadNumber},
      {"brake negative", surface_with(brake, -0.1F), ImageStatus::kBadNumber},
      {"brake not a number", surface_with(brake, nan), ImageStatus::kBadNumber},
      {"texture of kind 7", surface_with(texture(T::VT_KIND), std::uint8_t{7}, 2), ImageStatus::kBadNumber},
      {"texture of more columns than heights", surface_with(texture(T::VT_COLUMNS), std::uint16_t{4}),
       ImageStatus::kBadIndex},
      {"texture of too many heights", surface_with(texture(T::VT_ROWS), std::uint16_t{65535}),
       ImageStatus::kTooManySamples},
      {"texture without columns", surface_with(texture(T::VT_COLUMNS), std::uint16_t{0}),
       ImageStatus::kBadIndex},
      {"tile of no size", surface_with(texture(T::VT_TILE_U_M), 0.0F), ImageStatus::kBadNumber},
      {"tile too fine", surface_with(texture(T::VT_TILE_V_M), 1.0e-5F), ImageStatus::kBadNumber},
      {"height not a number", surface_with(height, nan), ImageStatus::kBadNumber},
      {"height over its limit", surface_with(height, -20.0F * control::kMaxRelief_m),
       ImageStatus::kBadNumber},
      {"map of more rows than numbers", surface_with(map(M::VT_ROWS), std::uint16_t{3}),
       ImageStatus::kBadIndex},
      {"map of too many numbers", surface_with(map(M::VT_COLUMNS), std::uint16_t{65535}),
       ImageStatus::kTooManySamples},
      {"cell of no size", surface_with(map(M::VT_CELL_M), 0.0F), ImageStatus::kBadNumber},
      {"origin infinite", surface_with(map(M::VT_ORIGIN_M), std::numeric_limits<float>::infinity()),
       ImageStatus::kBadNumber},
      {"direction of length 2", surface_with(map(M::VT_U), 2.0F), ImageStatus::kBadNumber},
      {"direction not a number", surface_with(map(M::VT_V), nan), ImageStatus::kBadNumber},
      {"stiffness negative", surface_with(stiffness, -1.0F), ImageStatus::kBadNumber},
      {"stiffness over its limit", surface_with(stiffness, 2.0F * control::kMaxStiffness_N_m),
       ImageStatus::kBadNumber},
      {"damping not a number", surface_with(damping, nan), ImageStatus::kBadNumber}};
  int wrong = 0;
  for (const Case& test : cases) {
    SceneView view;
    const ImageStatus status = SceneView::check(test.bytes, view);
    EXPECT_EQ(status, test.expected) << test.what << ": " << control::name(status);
    if (status != test.expected) ++wrong;
  }
  figure("fields of surfaces out of range not refused by name, of " + std::to_string(cases.size()), wrong,
         "0");
}

// What the corners of a mesh have for a texture.
template <typename Value>
ImageStatus status_of_mesh_with(unsigned object, const std::function<const void*(const scene::Mesh&)>& field,
                                Value value) {
  const scene::Mesh& mesh = *scene::GetScene(surface_image().data())->objects()->Get(object)->shape_as_Mesh();
  SceneView view;
  return SceneView::check(changed(surface_image(), field(mesh), value), view);
}

TEST(SurfaceImage, EachNumberOfAMeshesTextureIsChecked) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr unsigned kBlended = 4, kWrapped = 5;
  using M = const scene::Mesh&;
  const auto weight = [](std::size_t i) {
    return [i](M m) -> const void* { return m.texture_weights()->Data() + 4 * i; };
  };
  const auto point = [](std::size_t offset) {
    return [offset](M m) -> const void* { return part(m.texture_points()->Get(1), offset); };
  };
  const auto corner = [](M m) -> const void* { return m.texture_corners()->Data() + 8; };
  const auto weights_size = [](M m) -> const void* { return m.texture_weights()->Data() - 4; };
  const auto corners_size = [](M m) -> const void* { return m.texture_corners()->Data() - 4; };
  EXPECT_EQ(status_of_mesh_with(kBlended, weight(3), 0x00010000U), ImageStatus::kOk);
  EXPECT_EQ(status_of_mesh_with(kBlended, weight(3), 0x8000FFFFU), ImageStatus::kBadNumber);
  EXPECT_EQ(status_of_mesh_with(kBlended, weight(3), 0xFFFFFFFFU), ImageStatus::kBadNumber);
  EXPECT_EQ(status_of_mesh_with(kBlended, weight(4), 0xFFFFFFFFU), ImageStatus::kBadNumber);
  EXPECT_EQ(status_of_mesh_with(kBlended, weights_size, 23U), ImageStatus::kBadIndex);
  EXPECT_EQ(status_of_mesh_with(kWrapped, corners_size, 23U), ImageStatus::kBadIndex);
  EXPECT_EQ(status_of_mesh_with(kWrapped, corner, 6U), ImageStatus::kBadIndex);
  for (const std::size_t at : {0U, 4U, 8U, 12U, 16U, 20U, 24U, 28U, 32U})
    EXPECT_EQ(status_of_mesh_with(kWrapped, point(at), nan), ImageStatus::kBadNumber) << at;
  EXPECT_EQ(status_of_mesh_with(kWrapped, point(0), 2.0F * control::kMaxCoordinate_m),
            ImageStatus::kBadNumber);
  EXPECT_EQ(status_of_mesh_with(kWrapped, point(8), 2.0F * control::kMaxTextureGradient),
            ImageStatus::kBadNumber);
  EXPECT_EQ(status_of_mesh_with(kWrapped, point(32), 1.5F), ImageStatus::kBadNumber);
}

}  // namespace
}  // namespace thimble::test
