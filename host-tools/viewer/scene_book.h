// The scenes that a viewer knows: the files to choose from, and the running one, whose materials can be changed and saved.
//
// Errors are those of the compiler (kBadInput), and kNotFound for a name that is not in the book.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host-tools/viewer/open_scene.h"
#include "host-tools/viewer/scenes.h"

namespace thimble::host {

// Reads and compiles.
[[nodiscard]] OpenScene open_scene(const std::filesystem::path& file);
// The same of a file that has changed since: what is like before is not computed again, and changes that are not saved are kept for the objects
// that there still are, by their names.
[[nodiscard]] OpenScene reopen_scene(const OpenScene& before);

// Compiles what set_material() made of it; the scene is untouched when that fails.
void compile_changes(OpenScene& scene);
// Writes it, whole or not at all. Error kRefused: somebody else has changed the file since it was read, and `replaces` is false.
void save_scene(OpenScene& scene, bool replaces = false);

// Error kRefused: there is another file of that name.
void put_file(const OpenScene& scene, const FileMessage& file);

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

// Those of the book, and a thread that compiles.
class SceneFiles final : public Scenes {
 public:
  explicit SceneFiles(SceneBook book) : book_(std::move(book)) {}
  [[nodiscard]] std::filesystem::path find(const std::string& name) override { return book_.find(name); }
  [[nodiscard]] std::optional<OpenScene> with_crc(const std::string& name, std::uint32_t crc) override {
    return book_.with_crc(name, crc);
  }
  void begin(SceneJob job) override;
  [[nodiscard]] bool is_done() override;
  [[nodiscard]] OpenScene take() override { return work_.get(); }
  [[nodiscard]] bool has_changed(const std::filesystem::path& file, const std::string& known) override {
    return watch_.has_changed(file, known);
  }
  void put(const OpenScene& scene, const FileMessage& file) override { put_file(scene, file); }
  void save(OpenScene& scene, bool replaces) override { save_scene(scene, replaces); }

 private:
  SceneBook book_;
  FileWatch watch_;
  std::future<OpenScene> work_;
};

// Where scenes are looked for: beside this one (empty: none), and where this program's own are.
[[nodiscard]] std::vector<std::filesystem::path> scene_folders(const std::filesystem::path& scene);

}  // namespace thimble::host
