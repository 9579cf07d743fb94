// The table of the scene file's keys, a row a key: its name, what its value may be (host-tools/keys/key_values.h) and a
// text for people. The keys of the primitive shapes are in scene_shape.cpp.
#include "host-tools/compiler/scene_keys.h"

#include "control/scene/limits.h"
#include "host-tools/compiler/scene_shape.h"
#include "host-tools/keys/key_values.h"
#include "host-tools/keys/schema.h"

namespace thimble::host {
namespace keys {
namespace {

using Kinds = KeyTable;

constexpr double kMaxTurn_deg = 5729.0;      // just below control::kMaxTurn_rad
constexpr double kMinPitch_deg = 0.0057296;  // just above control::kMinDetentPitch
constexpr double kMaxSource = 1.0e6;
constexpr std::size_t kMaxInclusions = 64;

FileKind& add(Kinds& kinds, std::string_view name, const char* what, std::string_view for_people = {}) {
  kinds.push_back({name, what, for_people});
  return kinds.back();
}

KeyValue path() { return text(4096); }
KeyValue name() { return text(64); }
Range stiffness() { return above(0, control::kMaxStiffness_N_m, "N/m"); }
Range spring() { return from(0, control::kMaxStiffness_N_m, "N/m"); }  // 0: none
Range damping() { return from(0, control::kMaxDamping_N_s_m, "N s/m"); }

void add_scene(Kinds& kinds) {
  add(kinds, "scene", "a scene", "What the fingertip can touch. See docs/scene-format.md.")
      .optional("$schema", path(), "Path of this schema, for editors.")
      .required("thimble_scene", version(), "Version of the format.")
      .required("name", name(), "Name of the scene.")
      .optional("description", path(), "For people.")
      .optional("materials", named_parts("material"), "Materials by name, for objects to refer to.")
      .required("objects", list("object", 0, control::kMaxObjects), "What can be touched.")
      .optional("gravity_m_s2", vector(from(-kMaxCoordinate, kMaxCoordinate, "m/s2")).by_default(0, 0, 0),
                "Acts on objects with a body.")
      .optional("tip_radius_m", number(from(0, control::kMaxTipRadius_m, "m")).by_default(0),
                "The fingertip is a sphere of this radius, at least 0.0001; 0: a point.");

  add(kinds, "object", "an object of the scene")
      .required("name", name(), "Unlike every other object's.")
      .required("shape", part("shape"))
      .optional("pose", part("pose"))
      .optional("material", part_or_name("material"),
                "A material, or the name of one of the scene's materials. Required, but for a force field.")
      .optional("body", part("body"));

  FileKind& shape = add(kinds, "shape", "a shape", "Exactly one shape.");
  for (const std::string_view word : shape_words()) shape.alternative(word, part(word));
}

void add_body(Kinds& kinds) {
  using namespace control;
  const Range velocity = from(-kMaxBodySpeed_m_s, kMaxBodySpeed_m_s, "m/s");
  const Range spin = from(-kMaxBodySpin_rad_s, kMaxBodySpin_rad_s, "rad/s");
  add(kinds, "body", "a body", "The object moves when it is pushed.")
      .required("motion", one_of({"free", "translate", "plane", "slide", "turn"}))
      .required("mass_kg", number(from(kMinMass_kg, kMaxMass_kg, "kg")))
      .optional("centre_m", vector(kCoordinate),
                "The centre of mass, in the object's frame; without it that of the shape at uniform density.")
      .optional("inertia_kg_m2", vector(from(kMinInertia_kg_m2, kMaxInertia_kg_m2, "kg m2")),
                "About the object's axes through the centre of mass.")
      .optional("restitution", number(from(0, 1)).by_default(0),
                "Ratio of the speeds after and before an impact.")
      .optional("velocity_m_s", vector(velocity).by_default(0, 0, 0), "At the start.")
      .optional("spin_rad_s", vector(spin).by_default(0, 0, 0), "At the start.")
      .optional("spring_N_m", number(spring()).by_default(0), "To the initial position.")
      .optional("damping_N_s_m", number(damping()).by_default(0))
      .optional("angular_damping_N_m_s", number(from(0, kMaxAngularDamping_N_m_s, "N m s")).by_default(0))
      .optional("axis", direction().by_default(0, 0, 1), "World frame, of any length but zero.")
      .optional("pivot_m", vector(kCoordinate), "A point of the axis of \"turn\".")
      .optional("control", one_part_of({"slide_control", "turn_control"}));
}

void add_shapes(Kinds& kinds) {
  const Range degrees = from(0, 180, "degrees");
  for (const SceneShapeRow& row : scene_shapes())
    if (row.keys) kinds.push_back(*row.keys);

  add(kinds, "mesh", "a mesh")
      .required("file", path(),
                "Relative to the scene file: OBJ, STL, PLY, OFF, glTF and other formats of assimp, or a "
                "REND386 .plg.")
      .optional("scale", number(from(1.0e-9, 1.0e9, "metres per file unit")).by_default(1))
      .optional("crease_deg", number(degrees),
                "Smooths the surface by force shading; edges sharper than this stay sharp. Without it the "
                "mesh is faceted.")
      .optional("side", one_of({"outside", "inside", "both"}).by_default("outside"),
                "The side of the surface from which it can be touched.");

  add(kinds, "height_field", "a height field",
      "A block whose top is a grid of heights, smooth between its points; the value 0 is at z = 0.")
      .required("file", path(),
                "Relative to the scene file: numbers as CSV, or an image as PNG whose brightness is 0 to 1. "
                "The last row is nearest to the user.")
      .required("size_m", pair(kLength),
                "From the first to the last point along x and y; the centre is the origin.")
      .required("height_m", number(above(0, kMaxCoordinate, "m")),
                "Metres per unit of the values: the height of white, "
                "1 for a CSV in metres, 0.001 for one in mm.")
      .optional("thickness_m", number(kLength).by_default(0.01), "From the lowest point to the flat bottom.")
      .optional("crease_deg", number(degrees).by_default(180),
                "Edges of the top sharper than this stay sharp.");
}

void add_needle_and_tissue(Kinds& kinds) {
  using namespace control;
  const Range tear = from(0, kMaxTear_N, "N");
  add(kinds, "needle", "a needle",
      "The path of a needle: the skin is the object's plane z = 0, and the needle moves along -z. The "
      "material's stiffness holds it to its track.")
      .required("layers", list("layer", 1, kMaxLayers), "From the skin inwards.");

  add(kinds, "layer", "a layer of a needle's way", "One tissue.")
      .optional("name", name(), "For people.")
      .required("thickness_m", number(kLength))
      .required("stiffness_N_m", number(spring()), "Until it tears; 0 is a gap.")
      .required("tear_N", number(tear), "The force at which it tears.")
      .optional("friction_N", number(tear).by_default(0),
                "Coulomb friction of a shaft through the whole layer.")
      .optional("viscosity_N_s_m2", number(from(0, kMaxViscosity_N_s_m2, "N s/m^2")).by_default(0),
                "Viscous friction per metre of shaft in the layer.");

  add(kinds, "tissue", "a tissue", "A soft half space below z = 0 that follows the tip and recovers slowly.")
      .required("size_m", pair(kLength), "Extent along x and y, centred on the origin.")
      .required("contact_radius_m", number(kLength), "Of the round flat tip that presses.")
      .required("relaxed_stiffness_N_m", number(stiffness()),
                "After a long press; at most the material's stiffness, which acts at once.")
      .required("recovery_s", number(from(kMinRecovery_s, kMaxRecovery_s, "s")),
                "Time constant with which a dimple recovers.");
}

void add_vector_field(Kinds& kinds) {
  using namespace control;
  add(kinds, "vector_field", "a vector field",
      "A volume divided into subvolumes, each with a surface that pushes what is in it. Exactly one of "
      "these.")
      .alternative("box", part("box"))
      .alternative("sphere", part("sphere"))
      .alternative("planes", list("plane", 1, kMaxSubvolumeSides),
                   "A convex body, the intersection of their half spaces; the nearest plane pushes.")
      .alternative("subvolumes", list("subvolume", 1, kMaxSubvolumes));

  add(kinds, "subvolume", "a subvolume",
      "The points where all sides hold and which are behind its plane or inside its ball; it has one of "
      "these two.")
      .optional("sides", list("plane", 0, kMaxSubvolumeSides))
      .optional("plane", part("plane"))
      .optional("ball", part("ball"));

  add(kinds, "ball", "a ball")
      .optional("centre_m", vector(kCoordinate).by_default(0, 0, 0))
      .required("radius_m", number(kLength));
}

void add_potential_field(Kinds& kinds) {
  const Range source_of_depth = from(0, kMaxSource, "1/m"), source_of_energy = from(0, kMaxSource, "N/m");
  add(kinds, "potential_field", "a potential field",
      "A potential that the compiler solves: zero on the surface, raised by sources and inclusions.")
      .required("shape", part("solid"))
      .required("step_m", number(from(control::kMinFieldStep_m, 1, "m")),
                "Of the grid; at most 2097152 samples.")
      .optional("law", one_of({"spring", "energy"}).by_default("spring"),
                "spring: the potential is a depth in metres, pressed against the material's stiffness. "
                "energy: it is an energy in joules.")
      .optional("source_per_m", number(source_of_depth).by_default(0),
                "Law spring: minus the Laplacian of the depth.")
      .optional("source_N_m", number(source_of_energy).by_default(0),
                "Law energy: minus the Laplacian of the energy.")
      .optional("inclusions", list("inclusion", 0, kMaxInclusions))
      .optional("regions", list("region", 0, kMaxInclusions));

  add(kinds, "solid", "a shape of closed form", "Exactly one shape.")
      .alternative("sphere", part("sphere"))
      .alternative("box", part("box"))
      .alternative("cylinder", part("cylinder"))
      .alternative("capsule", part("capsule"));

  add(kinds, "inclusion", "an inclusion", "A region inside that is held at a potential.")
      .required("shape", part("solid"))
      .optional("pose", part("pose"))
      .optional("depth_m", number(above(0, 1, "m")), "Law spring: required.")
      .optional("potential_J", number(above(0, 1000, "J")), "Law energy: required.");

  add(kinds, "region", "a region", "A region with additional source.")
      .required("shape", part("solid"))
      .optional("pose", part("pose"))
      .optional("source_per_m", number(source_of_depth), "Law spring: required.")
      .optional("source_N_m", number(source_of_energy), "Law energy: required.");
}

void add_hung_mass(Kinds& kinds) {
  add(kinds, "hung_mass", "a mass",
      "It hangs on the tip by a spring and a damper, and begins at rest where the tip is.")
      .required("mass_kg", number(from(control::kMinMass_kg, control::kMaxMass_kg, "kg")))
      .required("stiffness_N_m", number(stiffness()))
      .optional("damping_N_s_m", number(damping()).by_default(0));
}

void add_pose(Kinds& kinds) {
  add(kinds, "pose", "a pose", "First rotates the object about its origin, then moves it.")
      .optional("position_m", vector(kCoordinate).by_default(0, 0, 0))
      .optional("rotation_deg", vector(from(-360, 360, "degrees")).by_default(0, 0, 0),
                "Roll, pitch, yaw: about x, then y, then z, fixed axes.");
}

void add_surface(Kinds& kinds) {
  using namespace control;
  const Range friction = from(0, kMaxFriction);
  add(kinds, "material", "a material")
      .required("stiffness_N_m", number(stiffness()))
      .optional("damping_N_s_m", number(damping()).by_default(0), "Along the surface's normal.")
      .optional("static_friction", number(friction).by_default(0),
                "Coefficient of friction while the tip sticks.")
      .optional("dynamic_friction", number(friction),
                "While the tip slides: at most static_friction, which is its default.")
      .optional("friction_mode", one_of({"stick_slip", "steady"}).by_default("stick_slip"))
      .optional("click", part("click"))
      .optional("brake_friction", number(friction).by_default(0), "Added to both coefficients of friction.")
      .optional("texture", part("texture"))
      .optional("stiffness_map", part("stiffness_map"));

  add(kinds, "click", "a click", "A decaying transient at contact, proportional to the speed of the impact.")
      .required("amplitude_N", number(from(0, kMaxClick_N, "N")), "For an impact at 0.1 m/s.")
      .required("frequency_Hz", number(from(kMinClickFrequency_Hz, kMaxClickFrequency_Hz, "Hz")))
      .required("decay_per_s", number(from(kMinClickDecay_per_s, kMaxClickDecay_per_s, "1/s")));

  add(kinds, "texture", "a texture",
      "One tile of heights that repeats over the surface; exactly one of pattern, heights and file.")
      .required("kind", one_of({"lateral", "normal", "height"}))
      .required("tile_m", pair(kLength), "Size of the tile along u and v.")
      .required("height_m", number(above(0, kMaxRelief_m, "m")), "From the lowest point to the highest.")
      .optional("mapping", one_of({"auto", "uv", "triplanar"}).by_default("auto"),
                "On a mesh: by the texture coordinates of its file, or along the object's axes.")
      .optional("pattern", one_of({"cos_cos", "ridges", "noise"}))
      .optional("heights", rows(from(-1.0e6, 1.0e6)), "In any unit; the last row is at the least v.")
      .optional("file", path(), "CSV or PNG, relative to the scene file.");

  add(kinds, "stiffness_map", "a stiffness map",
      "Control points of a bicubic B-spline of stiffness and damping over the surface.")
      .required("stiffness_N_m", rows_or_file(stiffness()),
                "Rows of numbers, or the path of a CSV file of them; the last row is at the least v.")
      .optional("damping_N_s_m", rows_or_file(damping()),
                "As many numbers; without them the material's damping holds everywhere.")
      .required("cell_m", number(kLength), "Between neighbouring control points.")
      .optional("origin_m", vector(kCoordinate).by_default(0, 0, 0),
                "The first control point, in the object's frame.")
      .optional("u", direction().by_default(1, 0, 0), "Along the rows.")
      .optional("v", direction().by_default(0, 1, 0), "From row to row.")
      .optional("conservative", flag().by_default(true),
                "Adds the sideways force that makes it a potential.");
}

constexpr std::string_view kDetents = "-T sin(2 pi (q - phase) / pitch).";
constexpr std::string_view kSwitch = "On where q passes on_at, off where it passes off_at on the way back.";
constexpr std::string_view kCurve = "[at, effort against pressing], rising in at, linear between.";

// The rows of add_turn_control() have the same order (scene_control.cpp).
void add_slide_control(Kinds& kinds) {
  using namespace control;
  add(kinds, "slide_control", "a control that slides",
      "A control element that slides along the axis, 0 at the start: spring, damping, friction, stops, "
      "detents, curve and switch.")
      .optional("stiffness_N_m", number(spring()).by_default(0))
      .optional("rest_m", number(kCoordinate).by_default(0))
      .optional("damping_N_s_m", number(damping()).by_default(0))
      .optional("friction_N", number(from(0, kMaxControlEffort, "N")).by_default(0))
      .optional("low_m", number(from(-kMaxCoordinate, 0, "m")).by_default(-kMaxCoordinate))
      .optional("high_m", number(from(0, kMaxCoordinate, "m")).by_default(kMaxCoordinate))
      .optional("detents", part("slide_detents"))
      .optional("curve_m_N", curve(kCoordinate, kMaxCurvePoints, written(kMaxControlEffort)), kCurve)
      .optional("switch", part("slide_switch"));

  add(kinds, "slide_detents", "detents", kDetents)
      .required("pitch_m", number(from(kMinDetentPitch, kMaxCoordinate, "m")))
      .optional("phase_m", number(kCoordinate).by_default(0))
      .required("force_N", number(above(0, kMaxControlEffort, "N")));

  add(kinds, "slide_switch", "a switch", kSwitch)
      .required("on_at_m", number(kCoordinate))
      .required("off_at_m", number(kCoordinate));
}

void add_turn_control(Kinds& kinds) {
  using namespace control;
  const Range turn = from(-kMaxTurn_deg, kMaxTurn_deg, "degrees");
  add(kinds, "turn_control", "a control that turns",
      "A control element that turns about the axis; q is its angle.")
      .optional("stiffness_N_m_rad", number(from(0, kMaxStiffness_N_m, "N m/rad")).by_default(0))
      .optional("rest_deg", number(turn).by_default(0))
      .optional("damping_N_m_s_rad", number(from(0, kMaxDamping_N_s_m, "N m s/rad")).by_default(0))
      .optional("friction_N_m", number(from(0, kMaxControlEffort, "N m")).by_default(0))
      .optional("low_deg", number(from(-kMaxTurn_deg, 0, "degrees")).by_default(-kMaxTurn_deg))
      .optional("high_deg", number(from(0, kMaxTurn_deg, "degrees")).by_default(kMaxTurn_deg))
      .optional("detents", part("turn_detents"))
      .optional("curve_deg_N_m", curve(turn, kMaxCurvePoints, written(kMaxControlEffort)), kCurve)
      .optional("switch", part("turn_switch"));

  add(kinds, "turn_detents", "detents", kDetents)
      .required("pitch_deg", number(from(kMinPitch_deg, kMaxTurn_deg, "degrees")))
      .optional("phase_deg", number(turn).by_default(0))
      .required("torque_N_m", number(above(0, kMaxControlEffort, "N m")));

  add(kinds, "turn_switch", "a switch", kSwitch)
      .required("on_at_deg", number(turn))
      .required("off_at_deg", number(turn));
}

Kinds table() {
  Kinds kinds;
  add_scene(kinds);
  add_body(kinds);
  add_shapes(kinds);
  add_needle_and_tissue(kinds);
  add_vector_field(kinds);
  add_potential_field(kinds);
  add_hung_mass(kinds);
  add_pose(kinds);
  add_surface(kinds);
  add_slide_control(kinds);
  add_turn_control(kinds);
  return kinds;
}

}  // namespace
}  // namespace keys

const KeyTable& scene_kinds() {
  static const KeyTable kKinds = keys::table();
  return kKinds;
}

const FileKind& scene_kind(std::string_view name) { return kind_of(scene_kinds(), name); }

std::string scene_schema() {
  return schema_text("Thimble scene, version 1",
                     "Generated from host-tools/compiler/scene_keys.cpp; compiler_test compares.", "scene",
                     scene_kinds());
}

}  // namespace thimble::host
