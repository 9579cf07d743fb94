#include "host-tools/viewer/open_scene.h"

#include <algorithm>

#include "host-tools/compiler/scene_text.h"
#include "thimble_scene_schema/scene_generated.h"

namespace thimble::host {

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

const std::string& text_before_changes(const OpenScene& scene) {
  return scene.draft ? *scene.draft : scene.file_text;
}

std::string changed_text(const OpenScene& scene) {
  std::string text = text_before_changes(scene);
  for (const auto& [what, value] : scene.changed_materials)
    text = with_material(text, what.first, what.second, value);
  return text;
}

bool has_changes(const OpenScene& scene) {
  return scene.draft.has_value() || !scene.changed_materials.empty();
}

std::string name_of(const std::filesystem::path& file) {
  const std::string name = file.filename().string();
  return name.ends_with(kSceneSuffix) ? name.substr(0, name.size() - kSceneSuffix.size()) : name;
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

}  // namespace thimble::host
