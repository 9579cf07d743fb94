// The scene compiler: a scene file in, a scene image out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "host-tools/compiler/mesh.h"

namespace thimble::host {

struct SceneReport {
  struct Object {
    std::string name;
    std::string shape;  // the scene file's word: "plane", "mesh", ...
    MeshReport mesh;    // of meshes and height fields; zeros for other shapes
  };
  std::string name;
  double tip_radius_m = 0;
  std::vector<Object> objects;
  std::size_t bytes = 0;
  std::vector<std::filesystem::path> files;  // that the scene file names
  std::vector<std::string> warnings;         // open sheets, dropped triangles, flipped winding ...
};

struct CompiledScene {
  std::vector<std::byte> image;  // starts at a multiple of 16
  SceneReport report;
};

// Reads the scene file and every mesh it names. The same input gives the same bytes. Error kBadInput,
// with file, line and JSON pointer.
[[nodiscard]] CompiledScene compile_scene(const std::filesystem::path& scene_file);

// The same for text that is not in a file (tests, imports): `name` stands in messages, `folder` is what paths
// are relative to.
[[nodiscard]] CompiledScene compile_scene_text(const std::string& text, const std::string& name,
                                               const std::filesystem::path& folder);

}  // namespace thimble::host
