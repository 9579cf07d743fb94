// The scene compiler: a scene file in, a scene image out.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "host-tools/compiler/compiled_parts.h"
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
  std::shared_ptr<const CompiledParts> parts;  // that a further compilation need not compute again
};

// Reads the scene file and every mesh it names. The same input gives the same bytes, on every machine. SceneErrors (kBadInput): all errors of
// the text, or all of the objects and their files, each with file, line and JSON pointer.
[[nodiscard]] CompiledScene compile_scene(const std::filesystem::path& scene_file);

// The same for text that is not in a file (tests, imports): `name` stands in messages, `folder` is what paths
// are relative to. known: parts of another compilation, of this scene with other materials; they do not change the image.
[[nodiscard]] CompiledScene compile_scene_text(const std::string& text, const std::string& name,
                                               const std::filesystem::path& folder,
                                               const CompiledParts* known = nullptr);

}  // namespace thimble::host
