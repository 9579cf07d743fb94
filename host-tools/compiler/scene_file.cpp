#include "host-tools/compiler/scene_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

#include "control/scene/limits.h"
#include "control/scene/shape_table.h"
#include "host-tools/compiler/scene_errors.h"
#include "host-tools/compiler/scene_pose.h"
#include "host-tools/compiler/scene_value.h"
#include "host-tools/error.h"
#include "host-tools/keys/check.h"

namespace thimble::host {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 20U;

SceneMaterial read_material(const Value& value) {
  const ScenePart part(value, "material");
  SceneMaterial material{};
  material.stiffness_N_m = part.number("stiffness_N_m");
  material.damping_N_s_m = part.number("damping_N_s_m");
  material.static_friction = part.number("static_friction");
  material.dynamic_friction =
      part.has("dynamic_friction") ? part.number("dynamic_friction") : material.static_friction;
  if (material.dynamic_friction > material.static_friction) {
    part.at("dynamic_friction")
        .wrong("at most static_friction, which is " + number(material.static_friction));
  }
  constexpr std::array<scene::FrictionMode, 2> kModes{scene::FrictionMode::StickSlip,
                                                      scene::FrictionMode::Steady};
  material.friction_mode = kModes.at(part.word("friction_mode"));
  material.surface = read_surface(part);
  return material;
}

void read_shape(const Value& value, SceneObject& object) {
  object.shape_word = ScenePart(value, "shape").only_key();
  const SceneShapeRow& row =
      *std::ranges::find(scene_shapes(), std::string_view(object.shape_word), &SceneShapeRow::word);
  object.kind = row.kind;
  object.shape = row.read(value.at(object.shape_word));
}

void read_object_body(const Value& value, SceneObject& object, std::size_t& bodies) {
  const std::vector<std::string_view> movable = movable_shape_words();
  if (std::ranges::find(movable, object.shape_word) == movable.end()) {
    value.fail("no-mass", "belongs to a " + object.shape_word + ", which has no volume to move",
               "give a body to one of the shapes " + listed(movable));
  }
  if (++bodies > control::kMaxBodies) {
    value.fail("too-many-bodies",
               "is the scene's body number " + std::to_string(bodies) + ", at most " +
                   std::to_string(control::kMaxBodies) + " are allowed",
               "leave some objects where they are");
  }
  object.body = read_body(value);
}

using Materials = std::map<std::string, SceneMaterial, std::less<>>;

Materials read_materials(const ScenePart& scene) {
  Materials materials;
  if (!scene.has("materials")) return materials;
  const Value all = scene.at("materials");
  if (!all.raw().is_object()) all.wrong("an object of materials by name");
  for (const auto& [key, unused] : all.raw().items()) materials.emplace(key, read_material(all.at(key)));
  return materials;
}

SceneMaterial material_of(const Value& value, const Materials& materials) {
  if (!value.raw().is_string()) return read_material(value);
  const auto given = value.raw().get<std::string>();
  const auto found = materials.find(given);
  if (found != materials.end()) return found->second;
  std::vector<std::string_view> names;
  for (const auto& [name, unused] : materials) names.emplace_back(name);
  value.fail("unknown-material",
             "is \"" + given + "\", which is not among /materials; " + suggestion(given, names),
             "name a material of the scene's \"materials\", or write one here");
}

// What is counted over all objects.
struct Counts {
  std::size_t bodies = 0;
  std::size_t volumes = 0;
};

SceneObject read_object(const Value& value, const Materials& materials, const SceneFile& file,
                        Counts& counts) {
  const ScenePart part(value, "object");
  SceneObject object;
  object.name = part.text("name");
  if (std::ranges::find(file.objects, object.name, &SceneObject::name) != file.objects.end()) {
    part.at("name").fail("repeated-name",
                         "is \"" + object.name + "\", which an earlier object is called already",
                         "give each object a name of its own");
  }
  read_shape(part.at("shape"), object);
  if (control::is_volume(object.kind) && ++counts.volumes > control::kMaxVolumes) {
    part.at("shape").fail("too-many-volumes",
                          "is the scene's volume number " + std::to_string(counts.volumes) + ", at most " +
                              std::to_string(control::kMaxVolumes) + " are allowed",
                          "leave some out");
  }
  if (part.has("pose")) read_pose(part.at("pose"), object.position_m, object.rotation);
  if (object.kind != scene::Shape::ForceField || part.has("material"))
    object.material = material_of(part.at("material"), materials);
  if (const auto* tissue = std::get_if<TissueShape>(&object.shape))
    check_against_material(*tissue, part.at("shape").at("tissue"), object.material.stiffness_N_m);
  if (part.has("body")) read_object_body(part.at("body"), object, counts.bodies);
  return object;
}

SceneFile read_scene(const board::JsonDocument& document) {
  const Value root(document);
  // The version first: the file of a later version may have any keys.
  if (root.raw().is_object() && root.at("thimble_scene").raw() != json(1)) {
    root.at("thimble_scene")
        .fail("wrong-version",
              "is " + root.at("thimble_scene").raw().dump() + ", this compiler reads version 1",
              "use \"thimble_scene\": 1, or a newer compiler");
  }
  const ScenePart scene(root, "scene");
  SceneFile file;
  file.name = scene.text("name");
  for (const std::string_view note : {"description", "$schema"})
    if (scene.has(note)) static_cast<void>(scene.text(note));
  const Materials materials = read_materials(scene);
  file.gravity_m_s2 = scene.vector("gravity_m_s2");
  file.tip_radius_m = scene.number("tip_radius_m");
  if (file.tip_radius_m > 0.0 && static_cast<float>(file.tip_radius_m) < control::kMinTipRadius_m)
    scene.at("tip_radius_m").wrong("0, or from 0.0001 to 0.01 m");
  const Value objects = scene.list("objects", "too-many-objects", "objects", "merge or remove objects");
  Counts counts;
  for (std::size_t i = 0; i < objects.raw().size(); ++i)
    file.objects.push_back(read_object(objects.at(i), materials, file, counts));
  return file;
}

// All that is wrong in a scene that read_scene() has refused. Throws SceneIssues::Full.
void collect(const board::JsonDocument& document, SceneIssues& issues) {
  const auto attempt = [&issues](const auto& read) {
    try {
      read();
    } catch (const board::JsonError& error) {
      issues.add(to_error(error));
    } catch (const Error& error) {
      issues.add(error);
    }
  };
  const Value root(document);
  if (!root.raw().is_object()) return;
  check_keys(root, scene_kind("scene"), scene_kinds(),
             [&issues](const board::JsonError& error) { issues.add(to_error(error)); });
  Materials materials;
  SceneMaterial unknown{};
  unknown.stiffness_N_m = static_cast<double>(control::kMaxStiffness_N_m);
  if (root.has("materials") && root.at("materials").raw().is_object()) {
    const Value all = root.at("materials");
    for (const auto& each : all.raw().items()) {
      materials[each.key()] = unknown;  // an object may name one that has an error
      attempt([&] { materials[each.key()] = read_material(all.at(each.key())); });
    }
  }
  if (!root.has("objects") || !root.at("objects").raw().is_array()) return;
  const Value objects = root.at("objects");
  SceneFile file;
  Counts counts;
  for (std::size_t i = 0; i < std::min(objects.raw().size(), control::kMaxObjects); ++i) {
    const Value object = objects.at(i);
    SceneObject read;
    if (object.raw().is_object() && object.has("name") && object.at("name").raw().is_string())
      read.name = object.at("name").raw().get<std::string>();  // for those of the same name behind it
    attempt([&] { read = read_object(object, materials, file, counts); });
    if (object.raw().is_object() && object.has("material"))
      attempt([&] { static_cast<void>(material_of(object.at("material"), materials)); });
    file.objects.push_back(std::move(read));
  }
}

}  // namespace

SceneFile read_scene_file(const std::string& text, const std::string& name) {
  if (text.size() > kMaxSceneBytes) {
    throw Error(ExitCode::kBadInput, "scene-file-too-large",
                name + ": the file has " + std::to_string(text.size()) + " bytes, at most " +
                    std::to_string(kMaxSceneBytes) + " are allowed",
                "put meshes into files of their own");
  }
  SceneIssues issues(text, name);
  std::optional<board::JsonDocument> document;
  try {
    document = parse_commented(text, name, "the scene");
    return read_scene(*document);
  } catch (const board::JsonError& error) {
    issues.add(to_error(error));
    if (error.name == "wrong-version") document.reset();  // the other keys are of that version
  } catch (const Error& error) {
    issues.add(error);
  }
  try {
    if (document) collect(*document, issues);
  } catch (const SceneIssues::Full&) {  // enough to correct
  }
  issues.raise();
}

}  // namespace thimble::host
