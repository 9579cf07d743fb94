#include "host-tools/compiler/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <utility>

#include "control/scene/limits.h"
#include "host-tools/compiler/json_document.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using nlohmann::json;
using Keys = std::span<const std::string_view>;

constexpr std::size_t kMaxSceneBytes = std::size_t{1} << 20U;
constexpr std::size_t kMaxNameBytes = 64;
constexpr double kMaxCoordinate = static_cast<double>(control::kMaxCoordinate_m);
constexpr double kMaxFriction = static_cast<double>(control::kMaxFriction);
constexpr double kMaxStiffness = static_cast<double>(control::kMaxStiffness_N_m);
constexpr double kMaxDamping = static_cast<double>(control::kMaxDamping_N_s_m);
constexpr double kMinLength = 1.0e-5;
constexpr double kMinScale = 1.0e-9;
constexpr double kMaxScale = 1.0e9;

constexpr std::array<std::string_view, 6> kSceneKeys{"$schema",     "thimble_scene", "name",
                                                     "description", "materials",     "objects"};
constexpr std::array<std::string_view, 4> kObjectKeys{"name", "shape", "pose", "material"};
constexpr std::array<std::string_view, 6> kShapeKeys{"plane", "sphere", "box", "cylinder", "capsule", "mesh"};
constexpr std::array<std::string_view, 2> kPlaneKeys{"normal", "offset_m"};
constexpr std::array<std::string_view, 1> kSphereKeys{"radius_m"};
constexpr std::array<std::string_view, 1> kBoxKeys{"size_m"};
constexpr std::array<std::string_view, 2> kCylinderKeys{"radius_m", "height_m"};
constexpr std::array<std::string_view, 2> kCapsuleKeys{"radius_m", "height_m"};
constexpr std::array<std::string_view, 4> kMeshKeys{"file", "scale", "crease_deg", "side"};
constexpr std::array<std::string_view, 2> kPoseKeys{"position_m", "rotation_deg"};
constexpr std::array<std::string_view, 5> kMaterialKeys{"stiffness_N_m", "damping_N_s_m", "static_friction",
                                                        "dynamic_friction", "friction_mode"};
constexpr std::array<SceneKeys, 11> kKinds{{{"scene", kSceneKeys},
                                            {"object", kObjectKeys},
                                            {"shape", kShapeKeys},
                                            {"plane", kPlaneKeys},
                                            {"sphere", kSphereKeys},
                                            {"box", kBoxKeys},
                                            {"cylinder", kCylinderKeys},
                                            {"capsule", kCapsuleKeys},
                                            {"mesh", kMeshKeys},
                                            {"pose", kPoseKeys},
                                            {"material", kMaterialKeys}}};

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, changed});
    }
  }
  return row[b.size()];
}

template <typename Words>
std::string listed(const Words& words) {
  std::string text;
  for (const auto& word : words) {
    text += (text.empty() ? "\"" : ", \"") + std::string(word) + "\"";
  }
  return text;
}

// "did you mean ...?" when one of the words is close, and the list of them all.
template <typename Words>
std::string suggestion(std::string_view given, const Words& words) {
  std::string_view best;
  std::size_t least = given.size() / 3 + 2;
  for (const std::string_view word : words) {
    const std::size_t distance = edit_distance(given.substr(0, 100), word);
    // Half a key ("stiffness" for "stiffness_N_m") is close too.
    const bool stem = given.size() >= 4 && word.starts_with(given);
    if (distance < least || (stem && best.empty())) {
      least = std::min(least, distance);
      best = word;
    }
  }
  const std::string all = words.empty() ? "there is none" : "allowed: " + listed(words);
  return best.empty() ? all : "did you mean \"" + std::string(best) + "\"? " + all;
}

struct Range {
  double least;
  double most;
  bool least_excluded = false;
  const char* unit = "";
};

std::string number(double value) { return json(value).dump(); }

std::string describe(const Range& range) {
  return std::string("a number ") + (range.least_excluded ? "above " : "from ") + number(range.least) +
         (range.least_excluded ? " and at most " : " to ") + number(range.most) +
         (*range.unit != '\0' ? " " : "") + range.unit;
}

// One value of the document and where it is.
class Value {
 public:
  Value(const JsonDocument& document, const json& value, std::string pointer)
      : document_(document), value_(value), pointer_(std::move(pointer)) {}

  [[noreturn]] void fail(const std::string& slug, const std::string& cause, const std::string& remedy) const {
    throw Error(ExitCode::kBadInput, slug, document_.place(pointer_) + " " + cause, remedy);
  }
  [[noreturn]] void wrong(const std::string& allowed) const {
    std::string given = value_.dump(-1, ' ', false, json::error_handler_t::replace);
    if (given.size() > 60) {
      given = given.substr(0, 57) + "...";
    }
    fail("bad-value", "is " + given + ", allowed is " + allowed, "give " + allowed);
  }

  [[nodiscard]] const json& raw() const { return value_; }
  [[nodiscard]] std::string place() const { return document_.place(pointer_); }

  // This value as an object with these keys, of which no other may occur.
  const Value& object(const char* what, Keys keys) const {
    if (!value_.is_object()) {
      wrong(std::string("an object (") + what + ") with the keys " + listed(keys));
    }
    for (const auto& [key, child] : value_.items()) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) {
        Value(document_, child, pointer_ + "/" + pointer_step(key))
            .fail("unknown-key", std::string("is not a key of ") + what + "; " + suggestion(key, keys),
                  "correct the key");
      }
    }
    return *this;
  }

  [[nodiscard]] bool has(std::string_view key) const { return value_.contains(key); }
  [[nodiscard]] Value at(std::string_view key) const {
    if (!has(key)) {
      fail("missing-key", "has no \"" + std::string(key) + "\"", "add \"" + std::string(key) + "\"");
    }
    return {document_, value_.at(std::string(key)), pointer_ + "/" + pointer_step(std::string(key))};
  }
  [[nodiscard]] Value at(std::size_t index) const {
    return {document_, value_.at(index), pointer_ + "/" + std::to_string(index)};
  }

  [[nodiscard]] double as_number(const Range& range) const {
    const double value = value_.is_number() ? value_.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!(range.least_excluded ? value > range.least : value >= range.least) || !(value <= range.most)) {
      wrong(describe(range));
    }
    return value;
  }
  [[nodiscard]] Eigen::Vector3d as_vector(const Range& range) const {
    if (!value_.is_array() || value_.size() != 3) {
      wrong("an array of three numbers [x, y, z]");
    }
    return {at(std::size_t{0}).as_number(range), at(std::size_t{1}).as_number(range),
            at(std::size_t{2}).as_number(range)};
  }
  [[nodiscard]] std::string as_text(std::size_t most_bytes) const {
    if (!value_.is_string() || value_.get_ref<const std::string&>().empty() ||
        value_.get_ref<const std::string&>().size() > most_bytes) {
      wrong("a string of 1 to " + std::to_string(most_bytes) + " bytes");
    }
    return value_.get<std::string>();
  }
  // The index of the word among those allowed.
  template <std::size_t kCount>
  [[nodiscard]] std::size_t as_word(const std::array<std::string_view, kCount>& words) const {
    const auto found = value_.is_string()
                           ? std::find(words.begin(), words.end(), value_.get_ref<const std::string&>())
                           : words.end();
    if (found == words.end()) {
      wrong("one of " + listed(words));
    }
    return static_cast<std::size_t>(found - words.begin());
  }

  [[nodiscard]] double number_or(std::string_view key, const Range& range, double otherwise) const {
    return has(key) ? at(key).as_number(range) : otherwise;
  }

 private:
  const JsonDocument& document_;
  const json& value_;
  std::string pointer_;
};

constexpr Range kLength{kMinLength, kMaxCoordinate, false, "m"};
constexpr Range kCoordinate{-kMaxCoordinate, kMaxCoordinate, false, "m"};

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
  } else {
    object.shape = read_mesh(shape);
  }
}

void read_pose(const Value& value, SceneObject& object) {
  value.object("a pose", kPoseKeys);
  if (value.has("position_m")) {
    object.position_m = value.at("position_m").as_vector(kCoordinate);
  }
  if (value.has("rotation_deg")) {
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    const Vector3d angles =
        value.at("rotation_deg").as_vector({-360.0, 360.0, false, "degrees"}) * (std::numbers::pi / 180.0);
    object.rotation = AngleAxisd(angles.z(), Vector3d::UnitZ()) * AngleAxisd(angles.y(), Vector3d::UnitY()) *
                      AngleAxisd(angles.x(), Vector3d::UnitX());
    object.rotation.normalize();
  }
}

}  // namespace

std::span<const SceneKeys> scene_keys() { return kKinds; }

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
    if (value.has("pose")) {
      read_pose(value.at("pose"), object);
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
    file.objects.push_back(std::move(object));
  }
  return file;
}

}  // namespace thimble::host
