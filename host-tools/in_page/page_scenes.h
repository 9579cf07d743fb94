// The scenes of a session in a page: a worker of the page has the files and compiles (compiler.cpp).
#pragma once

#include <map>
#include <string>
#include <utility>

#include "host-tools/viewer/scenes.h"

namespace thimble::host {

class PageScenes final : public Scenes {
 public:
  [[nodiscard]] std::filesystem::path find(const std::string& name) override {
    return name + std::string(kSceneSuffix);
  }
  [[nodiscard]] std::optional<OpenScene> with_crc(const std::string& name, std::uint32_t crc) override;
  [[nodiscard]] bool knows_more() override { return std::exchange(knows_more_, false); }
  void begin(SceneJob job) override;
  [[nodiscard]] bool is_done() override { return result_.has_value(); }
  [[nodiscard]] OpenScene take() override;
  // The page tells what has changed by itself.
  [[nodiscard]] bool has_changed(const std::filesystem::path& /*file*/,
                                 const std::string& /*known*/) override {
    return false;
  }
  void put(const OpenScene& /*scene*/, const FileMessage& /*file*/) override {
  }  // the page gives files to its compiler
  void save(OpenScene& scene, bool replaces) override;

  // Of the job that was begun last. head: the JSON of compiler.cpp, with "text": that of the file.
  void deliver(std::string_view head, std::string_view image);
  // A scene that no job was begun for. head: with "file", too, and "draft" where the image is of another text than that of the file.
  void learn(std::string_view head, std::string_view image);

 private:
  struct Result {
    Json head;
    std::vector<std::byte> image;
  };
  [[nodiscard]] static Result result_of(std::string_view head, std::string_view image);
  const OpenScene& keep(OpenScene scene, const Result& result);

  SceneJob job_;
  std::optional<Result> result_;
  std::map<std::uint32_t, OpenScene> opened_;  // by the CRC of the image
  bool knows_more_ = false;
};

}  // namespace thimble::host
