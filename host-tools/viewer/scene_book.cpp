#include "host-tools/viewer/scene_book.h"

#include <algorithm>
#include <system_error>

#include "host-tools/client/device.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_text.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".scene.json";

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

void set_material(OpenScene& scene, const MaterialMessage& change) {
  if (change.object >= scene.objects.size()) {
    throw Error(ExitCode::kUsage, "no-such-object",
                "the scene has no object " + std::to_string(change.object), "reload the page");
  }
  scene.changed_materials[{change.object, change.key}] = change.value;
}

void carry_changes(const OpenScene& from, OpenScene& to) {
  for (const auto& [what, value] : from.changed_materials) {
    const auto same = std::ranges::find(to.objects, from.objects[what.first]);
    if (same != to.objects.end())
      set_material(to, {static_cast<std::size_t>(same - to.objects.begin()), what.second, value});
  }
}

std::string changed_text(const OpenScene& scene) {
  std::string text = scene.file_text;
  for (const auto& [what, value] : scene.changed_materials)
    text = with_material(text, what.first, what.second, value);
  return text;
}

void compile_changes(OpenScene& scene) { compile_into(scene, changed_text(scene)); }

void save_scene(OpenScene& scene) {
  std::error_code none;
  if (!fs::is_regular_file(scene.file, none) || read_input(scene.file) != scene.file_text) {
    throw Error(ExitCode::kRefused, "scene-changed",
                scene.file.string() + " has been changed by another program since it was read",
                "correct the file if it has errors, and wait until it runs; then save again");
  }
  std::string text = changed_text(scene);
  OutputFile out(scene.file);
  out.stream() << text;
  out.commit();
  scene.file_text = std::move(text);
  scene.changed_materials.clear();
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

std::string name_of(const fs::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(kSuffix) ? name.substr(0, name.size() - kSuffix.size()) : name;
}

Json scene_json(const std::vector<std::byte>& image, std::uint32_t crc) {
  const scene::Scene* scene = scene::GetScene(image.data());
  Json json = {{"type", "scene"}, {"name", scene->name()->str()}, {"crc", crc}};
  json["objects"] = Json::array();
  for (const scene::Object* object : *scene->objects()) {
    const scene::Material& m = *object->material();
    json["objects"].push_back({{"name", object->name()->str()},
                               {"material",
                                {{"stiffness", exact(m.stiffness_n_per_m())},
                                 {"damping", exact(m.damping_n_s_per_m())},
                                 {"static_friction", exact(m.static_friction())},
                                 {"dynamic_friction", exact(m.dynamic_friction())}}}});
  }
  return json;
}

std::map<std::string, fs::path> SceneBook::list() const {
  std::map<std::string, fs::path> found;
  const auto look = [&found](const fs::path& folder) {
    std::vector<fs::path> folders;
    std::error_code none;
    for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
      const std::string name = at->path().filename().string();
      if (name.size() > kSuffix.size() && name.ends_with(kSuffix)) {
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

std::vector<fs::path> scene_folders(const fs::path& scene) {
  std::vector<fs::path> folders;
  std::error_code none;
  if (!scene.empty()) {
    const fs::path folder = fs::absolute(scene, none).parent_path();
    folders.push_back(folder);
    // The other scenes stand beside scenes/NAME.
    if (folder.filename().string() + std::string(kSuffix) == scene.filename().string())
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
