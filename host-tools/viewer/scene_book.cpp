#include "host-tools/viewer/scene_book.h"

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "host-tools/client/device.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_text.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"

namespace thimble::host {
namespace {

namespace fs = std::filesystem;

void compile_into(OpenScene& scene, const std::string& text) {
  CompiledScene compiled =
      compile_scene_text(text, scene.file.string(), scene.file.parent_path(), scene.parts.get());
  scene.crc = crc32(compiled.image);
  scene.image = std::make_shared<const std::vector<std::byte>>(std::move(compiled.image));
  scene.parts = std::move(compiled.parts);
  scene.name = compiled.report.name;
  scene.objects.clear();
  for (const SceneReport::Object& object : compiled.report.objects) scene.objects.push_back(object.name);
}

// known: of the same file as it was before, if any.
OpenScene open(const fs::path& file, const OpenScene* known) {
  std::error_code none;
  OpenScene scene;
  scene.file = file;
  if (known != nullptr) scene.parts = known->parts;
  if (!fs::is_regular_file(file, none)) {  // a FIFO would wait
    throw Error(ExitCode::kBadInput, "missing-scene", file.string() + ": the scene file cannot be opened",
                "give the path of a scene file, such as scenes/asteroid/asteroid.scene.json");
  }
  scene.file_text = read_input(file);
  compile_into(scene, scene.file_text);
  return scene;
}

}  // namespace

OpenScene open_scene(const fs::path& file) { return open(file, nullptr); }

OpenScene reopen_scene(const OpenScene& before) {
  OpenScene scene = open(before.file, &before);
  carry_changes(before, scene);
  if (!scene.changed_materials.empty()) compile_changes(scene);
  return scene;
}

void compile_changes(OpenScene& scene) { compile_into(scene, changed_text(scene)); }

void save_scene(OpenScene& scene, bool replaces) {
  std::error_code none;
  if (!replaces && (!fs::is_regular_file(scene.file, none) || read_input(scene.file) != scene.file_text)) {
    throw Error(ExitCode::kRefused, "scene-changed",
                scene.file.string() + " has been changed by another program since it was read",
                "correct the file if it has errors, and wait until it runs; then save again");
  }
  std::string text = changed_text(scene);
  OutputFile out(scene.file);
  out.stream() << text;
  out.commit();
  scene.file_text = std::move(text);
  scene.draft.reset();
  scene.changed_materials.clear();
}

void put_file(const OpenScene& scene, const FileMessage& file) {
  const fs::path path = scene.file.parent_path() / file.name;
  std::error_code none;
  if (fs::exists(fs::symlink_status(path, none))) {
    if (fs::is_regular_file(path, none) && read_input(path) == file.bytes) return;
    throw Error(ExitCode::kRefused, "file-exists", path.string() + " is another file",
                "rename the file that is added");
  }
  OutputFile out(path);
  out.stream() << file.bytes;
  out.commit();
}

bool FileWatch::has_changed(const fs::path& file, const std::string& known) {
  std::error_code time_error;
  std::error_code size_error;
  const Stamp now{file, fs::last_write_time(file, time_error), fs::file_size(file, size_error)};
  const bool is_there = !time_error && !size_error;
  const bool has_settled = now == seen_;
  seen_ = now;
  if (!is_there || !has_settled || now == read_) return false;
  read_ = now;
  try {
    return read_input(file) != known;
  } catch (const Error&) {  // put away between the two
    return false;
  }
}

std::map<std::string, fs::path> SceneBook::list() const {
  std::map<std::string, fs::path> found;
  const auto look = [&found](const fs::path& folder) {
    std::vector<fs::path> folders;
    std::error_code none;
    for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
      const std::string name = at->path().filename().string();
      if (name.size() > kSceneSuffix.size() && name.ends_with(kSceneSuffix)) {
        if (at->is_regular_file(none)) found.emplace(name_of(at->path()), at->path());
      } else if (at->is_directory(none) && !name.starts_with(".")) {
        folders.push_back(at->path());
      }
      none.clear();
    }
    std::ranges::sort(folders);
    return folders;
  };
  for (const fs::path& folder : folders_) {
    for (const fs::path& below : look(folder)) look(below);
  }
  return found;
}

fs::path SceneBook::find(const std::string& name) const {
  const auto scenes = list();
  const auto found = scenes.find(name);
  if (found == scenes.end()) {
    throw Error(ExitCode::kNotFound, "no-such-scene", "there is no scene of that name",
                "pick one of /scenes.json; `--scenes FOLDER` adds those of a folder");
  }
  return found->second;
}

std::optional<OpenScene> SceneBook::with_crc(const std::string& name, std::uint32_t crc) {
  for (const auto& [key, file] : list()) {
    std::error_code none;
    const auto file_time = fs::last_write_time(file, none);
    const auto known = compiled_.find(file);
    if (known == compiled_.end() || known->second.file_time != file_time) {
      try {
        const Json document = Json::parse(without_comments(read_input(file)), nullptr, false);
        if (!document.is_object() || document.value("name", Json()) != Json(name)) continue;
        compiled_[file] = {file_time, open_scene(file)};
      } catch (const Error&) {
        continue;  // it cannot be read, or does not compile
      }
    }
    const OpenScene& scene = compiled_[file].scene;
    if (scene.crc == crc && scene.name == name) return scene;
  }
  return std::nullopt;
}

// In another thread, so that telemetry continues. One job at a time, because the destructor of a future of std::async waits.
void SceneFiles::begin(SceneJob job) {
  work_ = std::async(std::launch::async, [job = std::move(job)]() mutable {
    if (job.kind == SceneJob::Kind::kPicked) return open_scene(job.scene.file);
    if (job.kind == SceneJob::Kind::kReread) return reopen_scene(job.scene);
    compile_changes(job.scene);
    return std::move(job.scene);
  });
}

bool SceneFiles::is_done() {
  return work_.valid() && work_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

std::vector<fs::path> scene_folders(const fs::path& scene) {
  std::vector<fs::path> folders;
  std::error_code none;
  if (!scene.empty()) {
    const fs::path folder = fs::absolute(scene, none).parent_path();
    folders.push_back(folder);
    // The other scenes stand beside scenes/NAME.
    if (folder.filename().string() + std::string(kSceneSuffix) == scene.filename().string())
      folders.push_back(folder.parent_path());
  }
  const fs::path program = fs::read_symlink("/proc/self/exe", none).parent_path();
  if (!program.empty()) {
    for (const fs::path& own : {program / "../share/thimble/scenes", program / "../../../scenes"}) {
      if (fs::is_directory(own, none)) folders.push_back(fs::weakly_canonical(own, none));
    }
  }
  return folders;
}

}  // namespace thimble::host
