// What a session asks of the scenes: those to choose from, and the work on the one that runs. The desk has files and a thread that compiles
// (scene_book.h), a page has a worker.
//
// Called by the session's thread. Errors are those of the compiler (kBadInput), and kNotFound for a name that is not known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "host-tools/viewer/open_scene.h"

namespace thimble::host {

struct SceneJob {
  enum class Kind {
    kPicked,  // scene.file is opened
    kEdited,  // the changed materials of the scene are compiled
    kDraft,   // the draft of the scene is compiled
    kReread,  // its file has changed: it is read again, and the changes that are not saved are kept
  };
  Kind kind = Kind::kPicked;
  OpenScene scene;
};

class Scenes {
 public:
  Scenes() = default;
  Scenes(const Scenes&) = delete;
  Scenes& operator=(const Scenes&) = delete;
  virtual ~Scenes() = default;

  [[nodiscard]] virtual std::filesystem::path find(const std::string& name) = 0;
  // The scene whose image has this CRC, of those that are called `name` inside.
  [[nodiscard]] virtual std::optional<OpenScene> with_crc(const std::string& name, std::uint32_t crc) = 0;
  // Whether it knows a scene that it did not know when it was last asked.
  [[nodiscard]] virtual bool knows_more() { return false; }

  // Compiles beside what else goes on, one job at a time.
  virtual void begin(SceneJob job) = 0;
  [[nodiscard]] virtual bool is_done() = 0;
  [[nodiscard]] virtual OpenScene take() = 0;  // of the job that is done; throws what it threw

  // Whether the file has other bytes than those known, and has settled.
  [[nodiscard]] virtual bool has_changed(const std::filesystem::path& file, const std::string& known) = 0;
  // A new file beside that of the scene. Error kRefused: there is another one of that name.
  virtual void put(const OpenScene& scene, const FileMessage& file) = 0;
  // Its draft and its changed materials into its file. replaces: also a file that has changed since it was read.
  virtual void save(OpenScene& scene, bool replaces) = 0;
};

}  // namespace thimble::host
