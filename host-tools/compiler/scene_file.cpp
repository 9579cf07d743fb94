#include "host-tools/compiler/scene_file.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/compiler/json_document.h"
#include "host-tools/compiler/scene_pose.h"
#include "host-tools/compiler/scene_value.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 20U;
constexpr std::size_t kMaxNameBytes = 64;
constexpr double kMaxFriction = static_cast<double>(control::kMaxFriction);
constexpr double kMaxStiffness = static_cast<double>(control::kMaxStiffness_N_m);
constexpr double kMaxDamping = static_cast<double>(control::kMaxDamping_N_s_m);
constexpr double kMinScale = 1.0e-9;
constexpr double kMaxScale = 1.0e9;

constexpr std::array<std::string_view, 7> kSceneKeys{
    "$schema", "thimble_scene", "name", "description", "materials", "objects", "gravity_m_s2"};
constexpr std::array<std::string_view, 5> kObjectKeys{"name", "shape", "pose", "material", "body"};
constexpr auto kShapeKeys =
    std::to_array<std::string_view>({"plane", "sphere", "box", "cylinder", "capsule", "mesh", "height_field",
                                     "vector_field", "potential_field", "needle", "tissue"});
constexpr std::array<std::string_view, 4> kVolumes{"vector_field", "potential_field", "needle", "tissue"};
constexpr std::array<std::string_view, 2> kPlaneKeys{"normal", "offset_m"};
constexpr std::array<std::string_view, 1> kSphereKeys{"radius_m"};
constexpr std::array<std::string_view, 1> kBoxKeys{"size_m"};
constexpr std::array<std::string_view, 2> kCylinderKeys{"radius_m", "height_m"};
constexpr std::array<std::string_view, 2> kCapsuleKeys{"radius_m", "height_m"};
constexpr std::array<std::string_view, 4> kMeshKeys{"file", "scale", "crease_deg", "side"};
constexpr std::array<std::string_view, 9> kMaterialKeys{
    "stiffness_N_m", "damping_N_s_m",  "static_friction", "dynamic_friction", "friction_mode",
    "click",         "brake_friction", "texture",         "stiffness_map"};
constexpr auto kTable = std::to_array<SceneKeys>({{"scene", kSceneKeys},
                                                  {"object", kObjectKeys},
                                                  {"shape", kShapeKeys},
                                                  {"plane", kPlaneKeys},
                                                  {"sphere", kSphereKeys},
                                                  {"box", kBoxKeys},
                                                  {"cylinder", kCylinderKeys},
                                                  {"capsule", kCapsuleKeys},
                                                  {"mesh", kMeshKeys},
                                                  {"height_field", kHeightFieldKeys},
                                                  {"needle", kNeedleKeys},
                                                  {"layer", kLayerKeys},
                                                  {"tissue", kTissueKeys},
                                                  {"vector_field", kVectorFieldKeys},
                                                  {"subvolume", kSubvolumeKeys},
                                                  {"ball", kBallKeys},
                                                  {"potential_field", kPotentialFieldKeys},
                                                  {"solid", kSolidKeys},
                                                  {"inclusion", kInclusionKeys},
                                                  {"region", kRegionKeys},
                                                  {"pose", kPoseKeys},
                                                  {"material", kMaterialKeys},
                                                  {"click", kClickKeys},
                                                  {"texture", kTextureKeys},
                                                  {"stiffness_map", kStiffnessMapKeys},
                                                  {"body", kBodyKeys},
                                                  {"slide_control", kSlideControlKeys},
                                                  {"turn_control", kTurnControlKeys},
                                                  {"slide_detents", kSlideDetentKeys},
                                                  {"turn_detents", kTurnDetentKeys},
                                                  {"slide_switch", kSlideSwitchKeys},
                                                  {"turn_switch", kTurnSwitchKeys}});

SceneMaterial read_material(const Value& value) {
  value.object("a material", kMaterialKeys);
  constexpr Range kFriction{0.0, kMaxFriction};
  SceneMaterial material{};
  material.stiffness_N_m = value.at("stiffness_N_m").as_number({0.0, kMaxStiffness, true, "N/m"});
  material.damping_N_s_m = value.number_or("damping_N_s_m", {0.0, kMaxDamping, false, "N s/m"}, 0.0);
  material.static_friction = value.number_or("static_friction", kFriction, 0.0);
  material.dynamic_friction = value.number_or("dynamic_friction", kFriction, material.static_friction);
  if (material.dynamic_friction > material.static_friction) {
    value.at("dynamic_friction")
        .wrong("at most static_friction, which is " + number(material.static_friction));
  }
  constexpr std::array<std::string_view, 2> kModes{"stick_slip", "steady"};
  const bool steady = value.has("friction_mode") && value.at("friction_mode").as_word(kModes) == 1;
  material.friction_mode = steady ? scene::FrictionMode::Steady : scene::FrictionMode::StickSlip;
  material.surface = read_surface(value);
  return material;
}

PlaneShape read_plane(const Value& value) {
  value.object("a plane", kPlaneKeys);
  const Value normal = value.at("normal");
  constexpr Range kAnyNumber{-1.0e9, 1.0e9};
  PlaneShape plane{normal.as_vector(kAnyNumber), value.number_or("offset_m", kCoordinate, 0.0)};
  if (plane.normal.norm() < 1.0e-6) {
    normal.wrong("a direction, of any length but zero");
  }
  plane.normal.normalize();
  return plane;
}

MeshShape read_mesh(const Value& value) {
  value.object("a mesh", kMeshKeys);
  MeshShape mesh;
  mesh.file = value.at("file").as_text(4096);
  mesh.scale_m = value.number_or("scale", {kMinScale, kMaxScale, false, "metres per file unit"}, 1.0);
  if (value.has("crease_deg")) {
    mesh.options.crease_deg = value.at("crease_deg").as_number({0.0, 180.0, false, "degrees"});
  }
  constexpr std::array<std::string_view, 3> kSides{"outside", "inside", "both"};
  constexpr std::array<MeshSide, 3> kMeaning{MeshSide::kOutside, MeshSide::kInside, MeshSide::kBoth};
  mesh.options.side = value.has("side") ? kMeaning.at(value.at("side").as_word(kSides)) : MeshSide::kOutside;
  mesh.place = value.at("file").place();
  return mesh;
}

void read_shape(const Value& value, SceneObject& object) {
  value.object("a shape", kShapeKeys);
  if (value.raw().size() != 1) {
    value.wrong("an object with exactly one of " + listed(kShapeKeys));
  }
  object.shape_word = value.raw().begin().key();
  const Value shape = value.at(object.shape_word);
  if (object.shape_word == "plane") {
    object.shape = read_plane(shape);
  } else if (object.shape_word == "sphere") {
    shape.object("a sphere", kSphereKeys);
    object.shape = SphereShape{shape.at("radius_m").as_number(kLength)};
  } else if (object.shape_word == "box") {
    shape.object("a box", kBoxKeys);
    object.shape = BoxShape{shape.at("size_m").as_vector(kLength)};
  } else if (object.shape_word == "cylinder") {
    shape.object("a cylinder", kCylinderKeys);
    object.shape =
        CylinderShape{shape.at("radius_m").as_number(kLength), shape.at("height_m").as_number(kLength)};
  } else if (object.shape_word == "capsule") {
    shape.object("a capsule", kCapsuleKeys);
    object.shape =
        CapsuleShape{shape.at("radius_m").as_number(kLength), shape.at("height_m").as_number(kLength)};
  } else if (object.shape_word == "height_field") {
    object.shape = read_height_field(shape);
  } else if (object.shape_word == "needle") {
    object.shape = read_needle(shape);
  } else if (object.shape_word == "tissue") {
    object.shape = read_tissue(shape);
  } else if (object.shape_word == "vector_field") {
    object.shape = read_vector_field(shape);
  } else if (object.shape_word == "potential_field") {
    object.shape = read_potential_field(shape);
  } else {
    object.shape = read_mesh(shape);
  }
}

void read_object_body(const Value& value, SceneObject& object, std::size_t& bodies) {
  constexpr std::array<std::string_view, 5> kMassive{"sphere", "box", "cylinder", "capsule", "mesh"};
  if (std::find(kMassive.begin(), kMassive.end(), object.shape_word) == kMassive.end()) {
    value.fail("no-mass", "belongs to a " + object.shape_word + ", which has no volume to move",
               "give a body to one of the shapes sphere, box, cylinder, capsule and mesh");
  }
  if (++bodies > control::kMaxBodies) {
    value.fail("too-many-bodies",
               "is the scene's body number " + std::to_string(bodies) + ", at most " +
                   std::to_string(control::kMaxBodies) + " are allowed",
               "leave some objects where they are");
  }
  object.body = read_body(value);
}

}  // namespace

std::span<const SceneKeys> scene_keys() { return kTable; }

SceneFile read_scene_file(const std::string& text, const std::string& name) {
  if (text.size() > kMaxSceneBytes) {
    throw Error(ExitCode::kBadInput, "scene-file-too-large",
                name + ": the file has " + std::to_string(text.size()) + " bytes, at most " +
                    std::to_string(kMaxSceneBytes) + " are allowed",
                "meshes belong in files of their own");
  }
  const JsonDocument document(text, name);
  const Value scene(document, document.root(), "");
  // The version first: a later version's file may have any keys.
  if (scene.raw().is_object() && scene.at("thimble_scene").raw() != json(1)) {
    scene.at("thimble_scene")
        .fail("wrong-version",
              "is " + scene.at("thimble_scene").raw().dump() + ", this compiler reads version 1",
              "use \"thimble_scene\": 1, or a newer compiler");
  }
  scene.object("a scene", kSceneKeys);
  SceneFile file;
  file.name = scene.at("name").as_text(kMaxNameBytes);
  for (const std::string_view note : {"description", "$schema"}) {
    if (scene.has(note)) {
      static_cast<void>(scene.at(note).as_text(4096));
    }
  }

  std::map<std::string, SceneMaterial, std::less<>> materials;
  std::vector<std::string> material_names;
  if (scene.has("materials")) {
    const Value all = scene.at("materials");
    if (!all.raw().is_object()) {
      all.wrong("an object of materials by name");
    }
    for (const auto& [key, unused] : all.raw().items()) {
      materials.emplace(key, read_material(all.at(key)));
      material_names.push_back(key);
    }
  }

  if (scene.has("gravity_m_s2")) {
    file.gravity_m_s2 = scene.at("gravity_m_s2").as_vector({-kMaxCoordinate, kMaxCoordinate, false, "m/s2"});
  }

  const Value objects = scene.at("objects");
  if (!objects.raw().is_array()) {
    objects.wrong("an array of objects");
  }
  if (objects.raw().size() > control::kMaxObjects) {
    objects.fail("too-many-objects",
                 "has " + std::to_string(objects.raw().size()) + " objects, at most " +
                     std::to_string(control::kMaxObjects) + " are allowed",
                 "merge or remove objects");
  }
  std::size_t bodies = 0;
  std::size_t volumes = 0;
  for (std::size_t i = 0; i < objects.raw().size(); ++i) {
    const Value value = objects.at(i);
    value.object("an object of the scene", kObjectKeys);
    SceneObject object;
    object.name = value.at("name").as_text(kMaxNameBytes);
    for (const SceneObject& earlier : file.objects) {
      if (earlier.name == object.name) {
        value.at("name").fail("repeated-name",
                              "is \"" + object.name + "\", which an earlier object is called already",
                              "give each object a name of its own");
      }
    }
    read_shape(value.at("shape"), object);
    const bool is_volume = std::find(kVolumes.begin(), kVolumes.end(), object.shape_word) != kVolumes.end();
    if (is_volume && ++volumes > control::kMaxVolumes) {
      value.at("shape").fail("too-many-volumes",
                             "is the scene's volume number " + std::to_string(volumes) + ", at most " +
                                 std::to_string(control::kMaxVolumes) + " are allowed",
                             "leave some out");
    }
    if (value.has("pose")) {
      read_pose(value.at("pose"), object.position_m, object.rotation);
    }
    const Value material = value.at("material");
    if (material.raw().is_string()) {
      const auto found = materials.find(material.raw().get_ref<const std::string&>());
      if (found == materials.end()) {
        const auto given = material.raw().get<std::string>();
        material.fail(
            "unknown-material",
            "is \"" + given + "\", which is not among /materials; " + suggestion(given, material_names),
            "name a material of the scene's \"materials\", or write one here");
      }
      object.material = found->second;
    } else {
      object.material = read_material(material);
    }
    if (const auto* tissue = std::get_if<TissueShape>(&object.shape)) {
      check_against_material(*tissue, value.at("shape").at("tissue"), object.material.stiffness_N_m);
    }
    if (value.has("body")) {
      read_object_body(value.at("body"), object, bodies);
    }
    file.objects.push_back(std::move(object));
  }
  return file;
}

}  // namespace thimble::host
