#include "host-tools/compiler/scene_shape.h"

#include <array>
#include <cmath>

#include "control/scene/shape_table.h"
#include "host-tools/compiler/to_scene.h"
#include "host-tools/keys/key_values.h"

namespace thimble::host {
namespace {

// A struct of the image.
template <typename Image>
auto writes(const Image& image) {
  return [image](flatbuffers::FlatBufferBuilder& builder) { return builder.CreateStruct(image).Union(); };
}

SceneShape read_plane(const Value& value) {
  const ScenePart part(value, "plane");
  return PrimitiveShape{
      writes(scene::Plane(to_scene(part.direction("normal")), static_cast<float>(part.number("offset_m"))))};
}

SceneShape read_sphere(const Value& value) {
  const double r = ScenePart(value, "sphere").number("radius_m");
  return PrimitiveShape{writes(scene::Sphere(static_cast<float>(r))), Eigen::Vector3d::Constant(.4 * r * r)};
}

SceneShape read_box(const Value& value) {
  const Eigen::Vector3d size = ScenePart(value, "box").vector("size_m");
  const Eigen::Vector3d s = size.cwiseAbs2();
  return PrimitiveShape{writes(scene::Box(to_scene(Eigen::Vector3d(size / 2.0)))),
                        Eigen::Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y()) / 12.0};
}

Eigen::Vector3d cylinder_inertia(double radius_m, double height_m) {
  const double r2 = radius_m * radius_m;
  const double across = r2 / 4.0 + height_m * height_m / 12.0;
  return {across, across, r2 / 2.0};
}

SceneShape read_cylinder(const Value& value) {
  const ScenePart part(value, "cylinder");
  const double r = part.number("radius_m");
  const double h = part.number("height_m");
  return PrimitiveShape{writes(scene::Cylinder(static_cast<float>(r), static_cast<float>(h / 2.0))),
                        cylinder_inertia(r, h), r};
}

SceneShape read_capsule(const Value& value) {
  const ScenePart part(value, "capsule");
  const double r = part.number("radius_m");
  const double h = part.number("height_m");
  const double cylinder = h / (h + 4.0 / 3.0 * r);  // shares of the mass
  const double ball = 1.0 - cylinder;
  const Eigen::Vector3d middle = cylinder_inertia(r, h);
  // Two half balls, their centres of mass 3 r / 8 beyond the cylinder's ends: 83/320 r^2 about those.
  const double arm = h / 2.0 + 3.0 / 8.0 * r;
  const double across = cylinder * middle.x() + ball * (83.0 / 320.0 * r * r + arm * arm);
  return PrimitiveShape{writes(scene::Capsule(static_cast<float>(r), static_cast<float>(h / 2.0))),
                        {across, across, cylinder * middle.z() + ball * .4 * r * r}};
}

SceneShape read_cone(const Value& value) {
  const ScenePart part(value, "cone");
  const double r = part.number("radius_m");
  const double h = part.number("height_m");
  const double across = 3.0 / 20.0 * r * r + 3.0 / 80.0 * h * h;
  return PrimitiveShape{writes(scene::Cone(static_cast<float>(r), static_cast<float>(h))),
                        {across, across, .3 * r * r}};
}

SceneShape read_mesh(const Value& value) {
  const ScenePart part(value, "mesh");
  MeshShape mesh;
  mesh.file = part.text("file");
  mesh.scale_m = part.number("scale");
  if (part.has("crease_deg")) mesh.options.crease_deg = part.number("crease_deg");
  constexpr std::array<MeshSide, 3> kSides{MeshSide::kOutside, MeshSide::kInside, MeshSide::kBoth};
  mesh.options.side = kSides.at(part.word("side"));
  mesh.place = part.at("file").place();
  return mesh;
}

SceneShape read_force_field(const Value& value) {
  const ScenePart part(value, "force_field");
  const auto number = [](const ScenePart& of, std::string_view key) {
    return static_cast<float>(of.number(key));
  };
  const Eigen::Vector3d size_m =
      part.has("size_m") ? part.vector("size_m") : Eigen::Vector3d::Constant(2.0 * kMaxCoordinate);
  const double trial = part.number("trial");
  if (trial != std::floor(trial)) part.at("trial").wrong("a whole number");
  std::array<float, 3> mass{};
  const Eigen::Vector3d curl_N_s_m = part.vector("curl_N_s_m");
  if (part.has("mass")) {
    if (!curl_N_s_m.isZero())
      part.at("mass").fail("senseless-key", "stands beside a curl_N_s_m",
                           "give each a force field of its own");
    const ScenePart hung(part.at("mass"), "hung_mass");
    mass = {number(hung, "mass_kg"), number(hung, "stiffness_N_m"), number(hung, "damping_N_s_m")};
  }
  return PrimitiveShape{writes(scene::ForceField(
      to_scene(part.vector("constant_N")), to_scene(part.vector("stiffness_N_m")),
      to_scene(part.vector("damping_N_s_m")), to_scene(curl_N_s_m), to_scene(Eigen::Vector3d(size_m / 2.0)),
      mass[0], mass[1], mass[2], static_cast<std::uint32_t>(trial)))};
}

template <auto kRead>
SceneShape read_as(const Value& value) {
  return kRead(value);
}

// Returns the kind of the shape's keys.
FileKind& add_primitive(std::vector<SceneShapeRow>& rows, scene::Shape kind, SceneShape (*read)(const Value&),
                        std::string_view word, const char* what, std::string_view text = {}) {
  const bool may_move = control::shape_row(kind).mobility == control::Mobility::kMovable;
  rows.push_back({word, kind, may_move, read});
  return rows.back().keys.emplace(FileKind{word, what, text});
}

std::vector<SceneShapeRow> shape_rows() {
  using enum scene::Shape;
  using namespace keys;
  const Range kFieldForce = from(-control::kMaxFieldForce_N, control::kMaxFieldForce_N, "N");
  const Range kStiffness = from(0, control::kMaxStiffness_N_m, "N/m");
  const Range kDamping = from(0, control::kMaxDamping_N_s_m, "N s/m");
  const Range kCurl = from(-control::kMaxDamping_N_s_m, control::kMaxDamping_N_s_m, "N s/m");
  std::vector<SceneShapeRow> rows;
  add_primitive(rows, Plane, read_plane, "plane", "a plane", "Solid where normal . p <= offset_m.")
      .required("normal", direction(), "Direction towards the free side, of any length but zero.")
      .optional("offset_m", number(kCoordinate).by_default(0));
  add_primitive(rows, Sphere, read_sphere, "sphere", "a sphere").required("radius_m", number(kLength));
  add_primitive(rows, Box, read_box, "box", "a box")
      .required("size_m", vector(kLength), "Full edge lengths along x, y and z; the centre is the origin.");
  add_primitive(rows, Cylinder, read_cylinder, "cylinder", "a cylinder",
                "Axis z, flat caps; the centre is the origin.")
      .required("radius_m", number(kLength))
      .required("height_m", number(kLength));
  add_primitive(
      rows, Capsule, read_capsule, "capsule", "a capsule",
      "Axis z; height_m is the length of the cylindrical part, between the centres of the round caps.")
      .required("radius_m", number(kLength))
      .required("height_m", number(kLength));
  add_primitive(rows, Cone, read_cone, "cone", "a cone",
                "Axis z, the apex up; the origin is the centre of mass: the base is at z = -height_m / 4.")
      .required("radius_m", number(kLength))
      .required("height_m", number(kLength));
  rows.push_back({"mesh", Mesh, true, read_mesh});
  rows.push_back({"height_field", Mesh, false, read_as<read_height_field>});
  rows.push_back({"vector_field", VectorField, false, read_as<read_vector_field>});
  rows.push_back({"potential_field", PotentialField, false, read_as<read_potential_field>});
  rows.push_back({"needle", Needle, false, read_as<read_needle>});
  rows.push_back({"tissue", Tissue, false, read_as<read_tissue>});
  add_primitive(
      rows, ForceField, read_force_field, "force_field", "a force field",
      "Forces on a tip that is inside, whatever it touches, in the object's frame. It needs no material.")
      .optional("constant_N", vector(kFieldForce).by_default(0, 0, 0))
      .optional("stiffness_N_m", vector(kStiffness).by_default(0, 0, 0),
                "Along each axis, towards the origin: [0, K, K] is a channel along x.")
      .optional("damping_N_s_m", vector(kDamping).by_default(0, 0, 0),
                "Against the velocity along each axis.")
      .optional("curl_N_s_m", vector(kCurl).by_default(0, 0, 0),
                "Curl times velocity (cross product): perpendicular to the velocity.")
      .optional("mass", part("hung_mass"))
      .optional("size_m", vector(kLength), "Full edge lengths; without them the field is everywhere.")
      .optional("trial", number(from(0, control::kMaxTrial)).by_default(0),
                "A whole number. The field acts while the parameter `trial` has this value; 0: always.");
  return rows;
}

}  // namespace

std::span<const SceneShapeRow> scene_shapes() {
  static const std::vector<SceneShapeRow> kRows = shape_rows();
  return kRows;
}

std::vector<std::string_view> shape_words() {
  std::vector<std::string_view> words;
  for (const SceneShapeRow& row : scene_shapes()) words.push_back(row.word);
  return words;
}

std::vector<std::string_view> movable_shape_words() {
  std::vector<std::string_view> words;
  for (const SceneShapeRow& row : scene_shapes())
    if (row.may_move) words.push_back(row.word);
  return words;
}

}  // namespace thimble::host
