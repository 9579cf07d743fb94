// The scenes that a viewer knows: the files to choose from, and the running one, whose materials can be changed and saved.
//
// Errors are those of the compiler (kBadInput), and kNotFound for a name that is not in the book.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/viewer/protocol.h"

namespace thimble::host {

using ImageBytes = std::shared_ptr<const std::vector<std::byte>>;

// A scene file in memory, and its image.
struct OpenScene {
  std::filesystem::path file;
  std::filesystem::file_time_type file_time;  // when it was read
  Json document;                              // with the changed materials
  std::string text;                           // what was compiled
  bool changed = false;                       // against the file
  ImageBytes image;
  std::uint32_t crc = 0;  // of the image
};

// Reads and compiles.
[[nodiscard]] OpenScene open_scene(const std::filesystem::path& file);

// The object gets a material of its own with this value. Error kUsage: there is no such object.
void set_material(OpenScene& scene, const MaterialMessage& change);
// Compiles what set_material() made of it; the scene is untouched when that fails.
void compile_changes(OpenScene& scene);
// Writes the file, whole or not at all. Error kRefused: somebody else has changed it since it was read.
void save_scene(OpenScene& scene);

// Under which a book lists the file: "ring" of ring.scene.json.
[[nodiscard]] std::string name_of(const std::filesystem::path& file);

// "objects" of the scene message: names and materials, as the image has them.
[[nodiscard]] Json scene_json(const std::vector<std::byte>& image, std::uint32_t crc);

// JSON as people write it: what fits into a line of 120 columns is one.
[[nodiscard]] std::string pretty(const Json& json);

class SceneBook {
 public:
  explicit SceneBook(std::vector<std::filesystem::path> folders) : folders_(std::move(folders)) {}

  // Every NAME.scene.json in the folders and one level below; of two of one name the first.
  [[nodiscard]] std::map<std::string, std::filesystem::path> list() const;
  [[nodiscard]] std::filesystem::path find(const std::string& name) const;

  // The scene whose image has this CRC, of those that are called `name` inside. What was compiled is kept until its file changes.
  [[nodiscard]] std::optional<OpenScene> with_crc(const std::string& name, std::uint32_t crc);

 private:
  std::vector<std::filesystem::path> folders_;
  std::map<std::filesystem::path, OpenScene> compiled_;
};

// Where scenes are looked for: beside this one (empty: none), and where this program's own are.
[[nodiscard]] std::vector<std::filesystem::path> scene_folders(const std::filesystem::path& scene);

}  // namespace thimble::host
