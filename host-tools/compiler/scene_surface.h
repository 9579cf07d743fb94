// The effects of a surface in the scene file: click, brake, texture and stiffness map of a material, read and written.
// Every key, unit, range and default is documented in docs/scene-format.md. Used by the scene reader and compile_scene.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host-tools/compiler/height_grid.h"
#include "host-tools/compiler/mesh.h"
#include "host-tools/compiler/scene_value.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

// Numbers in the scene file itself, or the file that has them.
struct GridSource {
  HeightGrid inline_grid;  // used when there is no file
  std::string file;        // relative to the scene file
  Range range{};           // of each number
  std::string place;       // "file:line: /pointer" for messages
};

struct SceneClick {
  double amplitude_N;
  double frequency_Hz;
  double decay_per_s;
};

enum class TexturePattern : std::uint8_t { kNone, kCosCos, kRidges, kNoise };

struct SceneTexture {
  scene::TextureKind kind;
  std::array<double, 2> tile_m;
  double height_m;  // from the lowest point to the highest
  TextureMapping mapping = TextureMapping::kAuto;
  TexturePattern pattern = TexturePattern::kNone;
  GridSource heights;  // without a pattern
  std::string place;
};

struct SceneStiffnessMap {
  GridSource stiffness_N_m;
  std::optional<GridSource> damping_N_s_m;
  double cell_m;
  Eigen::Vector3d origin_m;
  Eigen::Vector3d u;  // of unit length, like v
  Eigen::Vector3d v;
  bool conservative;
  std::string place;
};

struct SceneSurface {
  std::optional<SceneClick> click;
  double brake_friction = 0.0;
  std::optional<SceneTexture> texture;
  std::optional<SceneStiffnessMap> stiffness_map;

  std::string place;  // of the material

  [[nodiscard]] bool any() const { return click || brake_friction > 0.0 || texture || stiffness_map; }
};

[[nodiscard]] SceneSurface read_surface(const ScenePart& material);

// The object that has the surface: some effects depend on its shape.
struct Wearer {
  std::string_view name;
  std::string_view shape_word;
  scene::Shape kind{};
  double unrolled_radius_m = 0.0;  // of a side round which a texture is wrapped, as a cylinder's
};

// Reads the files it names, under `folder`. Throws Error (kBadInput).
[[nodiscard]] flatbuffers::Offset<scene::Surface> write_surface(flatbuffers::FlatBufferBuilder& builder,
                                                                const SceneSurface& surface,
                                                                const Wearer& wearer,
                                                                const std::filesystem::path& folder,
                                                                std::vector<std::string>& warnings);

}  // namespace thimble::host
