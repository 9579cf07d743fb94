#include "host-tools/viewer/scene_book.h"

#include <algorithm>
#include <system_error>

#include "host-tools/client/device.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/files/input_file.h"
#include "host-tools/files/output_file.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".scene.json";
constexpr std::size_t kColumns = 120;

void compile_into(OpenScene& scene, std::string text) {
  CompiledScene compiled = compile_scene_text(text, scene.file.string(), scene.file.parent_path());
  scene.text = std::move(text);
  scene.crc = crc32(compiled.image);
  scene.image = std::make_shared<const std::vector<std::byte>>(std::move(compiled.image));
}

void write_pretty(const Json& json, std::size_t indent, std::size_t column, std::string& out) {
  // A line of its own for each member: dump() puts no space behind a comma.
  const auto one_line = [](const auto& self, const Json& value) -> std::string {
    if (!value.is_structured()) return value.dump();
    const bool object = value.is_object();
    std::string text = object ? "{" : "[";
    for (const auto& [key, member] : value.items()) {
      if (text.size() > 1) text += ", ";
      if (object) text += Json(key).dump() + ": ";
      text += self(self, member);
    }
    return text + (object ? "}" : "]");
  };
  const std::string line = one_line(one_line, json);
  if (!json.is_structured() || json.empty() || column + line.size() < kColumns) {
    out += line;
    return;
  }
  const bool object = json.is_object();
  out += object ? "{" : "[";
  bool first = true;
  for (const auto& [key, member] : json.items()) {
    out += first ? "\n" : ",\n";
    first = false;
    out.append(indent + 2, ' ');
    const std::size_t begun = out.size();
    if (object) out += Json(key).dump() + ": ";
    write_pretty(member, indent + 2, indent + 2 + out.size() - begun, out);
  }
  out += '\n';
  out.append(indent, ' ');
  out += object ? '}' : ']';
}

}  // namespace

std::string pretty(const Json& json) {
  std::string out;
  // The scene itself is never one line.
  write_pretty(json, 0, kColumns, out);
  return out + "\n";
}

OpenScene open_scene(const fs::path& file) {
  std::error_code none;
  OpenScene scene;
  scene.file = file;
  scene.file_time = fs::last_write_time(file, none);
  if (!fs::is_regular_file(file, none)) {  // a FIFO would wait
    throw Error(ExitCode::kBadInput, "missing-scene", file.string() + ": the scene file cannot be opened",
                "give the path of a scene file, such as scenes/asteroid/asteroid.scene.json");
  }
  std::string text = read_input(file);
  compile_into(scene, text);  // first, because its error names the place
  scene.document = Json::parse(scene.text, nullptr, false);
  return scene;
}

void set_material(OpenScene& scene, const MaterialMessage& change) {
  Json& objects = scene.document["objects"];
  if (!objects.is_array() || change.object >= objects.size()) {
    throw Error(ExitCode::kUsage, "no-such-object",
                "the scene has no object " + std::to_string(change.object), "reload the page");
  }
  Json& object = objects[change.object];
  Json material = object["material"];
  if (material.is_string()) material = scene.document["materials"][material.get<std::string>()];
  material[change.key] = change.value;
  object["material"] = std::move(material);
  scene.changed = true;
}

void compile_changes(OpenScene& scene) { compile_into(scene, pretty(scene.document)); }

void save_scene(OpenScene& scene) {
  std::error_code none;
  const auto file_time = fs::last_write_time(scene.file, none);
  if (none || file_time != scene.file_time) {
    throw Error(ExitCode::kRefused, "scene-changed",
                scene.file.string() + " has been changed by another program since it was read",
                "pick the scene again, then change and save it");
  }
  OutputFile out(scene.file);
  out.stream() << pretty(scene.document);
  out.commit();
  scene.file_time = fs::last_write_time(scene.file, none);
  scene.changed = false;
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
        const Json document = Json::parse(read_input(file), nullptr, false);
        if (!document.is_object() || document.value("name", Json()) != Json(name)) continue;
        compiled_[file] = open_scene(file);
      } catch (const Error&) {
        continue;  // it cannot be read, or does not compile
      }
    }
    const OpenScene& scene = compiled_[file];
    if (scene.crc == crc && scene.document.value("name", Json()) == Json(name)) return scene;
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
