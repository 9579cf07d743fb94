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
#include <utility>
#include <vector>

#include "host-tools/compiler/compiled_parts.h"
#include "host-tools/viewer/protocol.h"

namespace thimble::host {

using ImageBytes = std::shared_ptr<const std::vector<std::byte>>;

// A scene file in memory, and its image.
struct OpenScene {
  std::filesystem::path file;
  std::string file_text;  // as it was read, or written since
  std::map<std::pair<std::size_t, std::string>, double>
      changed_materials;  // by object and key, not yet in the file
  std::string name;
  std::vector<std::string> objects;  // their names
  ImageBytes image;
  std::uint32_t crc = 0;                       // of the image
  std::shared_ptr<const CompiledParts> parts;  // which a change of a material leaves as they are
};

// Reads and compiles.
[[nodiscard]] OpenScene open_scene(const std::filesystem::path& file);
// The same of a file that has changed since: what is like before is not computed again, and changes that are not saved are kept for the objects
// that there still are, by their names.
[[nodiscard]] OpenScene reopen_scene(const OpenScene& before);

// The object gets this value; as with_material() of scene_text.h. Error kUsage: there is no such object.
void set_material(OpenScene& scene, const MaterialMessage& change);
// What is changed in one and not saved, in the other too: by the names of objects, as far as it has them.
void carry_changes(const OpenScene& from, OpenScene& to);
// Compiles what set_material() made of it; the scene is untouched when that fails.
void compile_changes(OpenScene& scene);
// The text of the file with the changes: only the numbers that were changed differ from it.
[[nodiscard]] std::string changed_text(const OpenScene& scene);
// Writes it, whole or not at all. Error kRefused: somebody else has changed the file since it was read.
void save_scene(OpenScene& scene);

// Whether a file has other bytes than those known. An editor may still be writing, or have put the file away to replace it: what has
// changed is read when it has stayed the same from one look to the next, and once.
class FileWatch {
 public:
  [[nodiscard]] bool has_changed(const std::filesystem::path& file, const std::string& known);

 private:
  struct Stamp {
    std::filesystem::path file;
    std::filesystem::file_time_type time;
    std::uintmax_t bytes = 0;
    bool operator==(const Stamp&) const = default;
  };
  Stamp seen_;  // by the last look
  Stamp read_;
};

// Under which a book lists the file: "ring" of ring.scene.json.
[[nodiscard]] std::string name_of(const std::filesystem::path& file);

// "objects" of the scene message: names and materials, as the image has them.
[[nodiscard]] Json scene_json(const std::vector<std::byte>& image, std::uint32_t crc);

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
  struct Compiled {
    std::filesystem::file_time_type file_time;
    OpenScene scene;
  };
  std::map<std::filesystem::path, Compiled> compiled_;
};

// Where scenes are looked for: beside this one (empty: none), and where this program's own are.
[[nodiscard]] std::vector<std::filesystem::path> scene_folders(const std::filesystem::path& scene);

}  // namespace thimble::host
