// Its length is that of the table: a row a key. Those of the primitive shapes are in scene_shape.cpp.
#include "host-tools/compiler/scene_keys.h"

#include <algorithm>
#include <stdexcept>

#include "control/scene/limits.h"
#include "host-tools/compiler/scene_shape.h"

namespace thimble::host {
namespace {

using enum KeyType;

double written(float value) { return board::as_written(value); }

constexpr bool kRequired = true;
constexpr double kMaxTurn_deg = 5729.0;      // just below control::kMaxTurn_rad
constexpr double kMinPitch_deg = 0.0057296;  // just above control::kMinDetentPitch
constexpr double kMaxPathBytes = 4096, kMaxNameBytes = 64;
constexpr double kMaxInclusions = 64;
constexpr double kMaxSource = 1.0e6;
constexpr Range kAny{-1.0e9, 1.0e9};

std::vector<SceneKind> table() {
  using namespace control;
  const double reach = written(kMaxCoordinate_m);
  const double stiffest = written(kMaxStiffness_N_m), most_damping = written(kMaxDamping_N_s_m);
  const double effort = written(kMaxControlEffort), speed = written(kMaxBodySpeed_m_s),
               spin = written(kMaxBodySpin_rad_s);
  const Range length{1.0e-5, reach, false, "m"};
  const Range coordinate{-reach, reach, false, "m"};
  const Range stiffness{0, stiffest, true, "N/m"}, damping{0, most_damping, false, "N s/m"};
  const Range friction{0, written(kMaxFriction)};
  const Range tear{0, written(kMaxTear_N), false, "N"};
  const Range degrees{0, 180, false, "degrees"};
  const Range path{1, kMaxPathBytes}, name{1, kMaxNameBytes};
  const Range turn{-kMaxTurn_deg, kMaxTurn_deg, false, "degrees"};
  const std::vector<std::string_view> none;
  const auto up_to = [](std::size_t least, std::size_t most) {
    return Range{static_cast<double>(least), static_cast<double>(most)};
  };
  std::vector<SceneKind> kinds;
  kinds.push_back(
      {"scene",
       "a scene",
       "What the fingertip can touch. See docs/scene-format.md.",
       {{"$schema", kText, path, none, false, {}, {}, "Path of this schema, for editors."},
        {"thimble_scene", kVersion, {}, none, kRequired, {}, {}, "Version of the format."},
        {"name", kText, name, none, kRequired, {}, {}, "Name of the scene."},
        {"description", kText, path, none, false, {}, {}, "For people."},
        {"materials",
         kNamedParts,
         {},
         {"material"},
         false,
         {},
         {},
         "Materials by name, for objects to refer to."},
        {"objects", kList, up_to(0, kMaxObjects), {"object"}, kRequired, {}, {}, "What can be touched."},
        {"gravity_m_s2",
         kVector,
         {-reach, reach, false, "m/s2"},
         none,
         false,
         {0, 0, 0},
         {},
         "Acts on objects with a body."}}});
  kinds.push_back({"object",
                   "an object of the scene",
                   "",
                   {{"name", kText, name, none, kRequired, {}, {}, "Unlike every other object's."},
                    {"shape", kPart, {}, {"shape"}, kRequired, {}, {}, {}},
                    {"pose", kPart, {}, {"pose"}, false, {}, {}, {}},
                    {"material",
                     kPartOrName,
                     {},
                     {"material"},
                     kRequired,
                     {},
                     {},
                     "A material, or the name of one of the scene's materials."},
                    {"body", kPart, {}, {"body"}, false, {}, {}, {}}}});
  kinds.push_back({"shape", "a shape", "Exactly one shape.", {}, true});
  for (const std::string_view word : shape_words())
    kinds.back().keys.push_back({word, kPart, {}, {word}, false, {}, {}, {}});
  kinds.push_back(
      {"body",
       "a body",
       "The object moves when it is pushed.",
       {{"motion", kWord, {}, {"free", "translate", "plane", "slide", "turn"}, kRequired, {}, {}, {}},
        {"mass_kg",
         kNumber,
         {written(kMinMass_kg), written(kMaxMass_kg), false, "kg"},
         none,
         kRequired,
         {},
         {},
         {}},
        {"inertia_kg_m2",
         kVector,
         {written(kMinInertia_kg_m2), written(kMaxInertia_kg_m2), false, "kg m2"},
         none,
         false,
         {},
         {},
         "About the object's axes through its origin."},
        {"restitution",
         kNumber,
         {0, 1},
         none,
         false,
         {0},
         {},
         "Ratio of the speeds after and before an impact."},
        {"velocity_m_s", kVector, {-speed, speed, false, "m/s"}, none, false, {0, 0, 0}, {}, "At the start."},
        {"spin_rad_s", kVector, {-spin, spin, false, "rad/s"}, none, false, {0, 0, 0}, {}, "At the start."},
        {"spring_N_m",
         kNumber,
         {0, stiffest, false, "N/m"},
         none,
         false,
         {0},
         {},
         "To the initial position."},
        {"damping_N_s_m", kNumber, damping, none, false, {0}, {}, {}},
        {"angular_damping_N_m_s",
         kNumber,
         {0, written(kMaxAngularDamping_N_m_s), false, "N m s"},
         none,
         false,
         {0},
         {},
         {}},
        {"axis", kDirection, kAny, none, false, {0, 0, 1}, {}, "World frame, of any length but zero."},
        {"pivot_m", kVector, coordinate, none, false, {}, {}, "A point of the axis of \"turn\"."},
        {"control", kPart, {}, {"slide_control", "turn_control"}, false, {}, {}, {}}}});
  for (const SceneShapeRow& row : scene_shapes())
    if (row.keys) kinds.push_back(*row.keys);
  kinds.push_back(
      {"mesh",
       "a mesh",
       "",
       {{"file",
         kText,
         path,
         none,
         kRequired,
         {},
         {},
         "Relative to the scene file: OBJ, STL, PLY, OFF, glTF and other formats of assimp, or a REND386 "
         ".plg."},
        {"scale", kNumber, {1.0e-9, 1.0e9, false, "metres per file unit"}, none, false, {1}, {}, {}},
        {"crease_deg",
         kNumber,
         degrees,
         none,
         false,
         {},
         {},
         "Smooths the surface by force shading; edges sharper than this stay sharp. Without it the mesh is "
         "faceted."},
        {"side",
         kWord,
         {},
         {"outside", "inside", "both"},
         false,
         {},
         "outside",
         "The side of the surface from which it can be touched."}}});
  kinds.push_back(
      {"height_field",
       "a height field",
       "A block whose top is a grid of heights, smooth between its points; the value 0 is at z = 0.",
       {{"file",
         kText,
         path,
         none,
         kRequired,
         {},
         {},
         "Relative to the scene file: numbers as CSV, or an image as PNG whose brightness is 0 to 1. The "
         "last row is nearest to "
         "the user."},
        {"size_m",
         kPair,
         length,
         none,
         kRequired,
         {},
         {},
         "From the first to the last point along x and y; the centre is the origin."},
        {"height_m",
         kNumber,
         {0, reach, true, "m"},
         none,
         kRequired,
         {},
         {},
         "Metres per unit of the values: the height of white, 1 for a CSV in metres, 0.001 for one in mm."},
        {"thickness_m",
         kNumber,
         length,
         none,
         false,
         {0.01},
         {},
         "From the lowest point to the flat bottom."},
        {"crease_deg",
         kNumber,
         degrees,
         none,
         false,
         {180},
         {},
         "Edges of the top sharper than this stay sharp."}}});
  kinds.push_back(
      {"needle",
       "a needle",
       "The path of a needle: the skin is the object's plane z = 0, and the needle moves along -z. The "
       "material's stiffness holds "
       "it to its track.",
       {{"layers", kList, up_to(1, kMaxLayers), {"layer"}, kRequired, {}, {}, "From the skin inwards."}}});
  kinds.push_back({"layer",
                   "a layer of a needle's way",
                   "One tissue.",
                   {{"name", kText, name, none, false, {}, {}, "For people."},
                    {"thickness_m", kNumber, length, none, kRequired, {}, {}, {}},
                    {"stiffness_N_m",
                     kNumber,
                     {0, stiffest, false, "N/m"},
                     none,
                     kRequired,
                     {},
                     {},
                     "Until it tears; 0 is a gap."},
                    {"tear_N", kNumber, tear, none, kRequired, {}, {}, "The force at which it tears."},
                    {"friction_N",
                     kNumber,
                     tear,
                     none,
                     false,
                     {0},
                     {},
                     "Coulomb friction of a shaft through the whole layer."},
                    {"viscosity_N_s_m2",
                     kNumber,
                     {0, written(kMaxViscosity_N_s_m2), false, "N s/m^2"},
                     none,
                     false,
                     {0},
                     {},
                     "Viscous friction per metre of shaft in the layer."}}});
  kinds.push_back(
      {"tissue",
       "a tissue",
       "A soft half space below z = 0 that follows the tip and recovers slowly.",
       {{"size_m", kPair, length, none, kRequired, {}, {}, "Extent along x and y, centred on the origin."},
        {"contact_radius_m", kNumber, length, none, kRequired, {}, {}, "Of the round flat tip that presses."},
        {"relaxed_stiffness_N_m",
         kNumber,
         stiffness,
         none,
         kRequired,
         {},
         {},
         "After a long press; at most the material's stiffness, which acts at once."},
        {"recovery_s",
         kNumber,
         {written(kMinRecovery_s), written(kMaxRecovery_s), false, "s"},
         none,
         kRequired,
         {},
         {},
         "Time constant with which a dimple recovers."}}});
  kinds.push_back({"vector_field",
                   "a vector field",
                   "A volume divided into subvolumes, each with a surface that pushes what is in it. Exactly "
                   "one of these.",
                   {{"box", kPart, {}, {"box"}, false, {}, {}, {}},
                    {"sphere", kPart, {}, {"sphere"}, false, {}, {}, {}},
                    {"planes",
                     kList,
                     up_to(1, kMaxSubvolumeSides),
                     {"plane"},
                     false,
                     {},
                     {},
                     "A convex body, the intersection of their half spaces; the nearest plane pushes."},
                    {"subvolumes", kList, up_to(1, kMaxSubvolumes), {"subvolume"}, false, {}, {}, {}}},
                   true});
  kinds.push_back({"subvolume",
                   "a subvolume",
                   "The points where all sides hold and which are behind its plane or inside its ball; it "
                   "has one of these two.",
                   {{"sides", kList, up_to(0, kMaxSubvolumeSides), {"plane"}, false, {}, {}, {}},
                    {"plane", kPart, {}, {"plane"}, false, {}, {}, {}},
                    {"ball", kPart, {}, {"ball"}, false, {}, {}, {}}}});
  kinds.push_back({"ball",
                   "a ball",
                   "",
                   {{"centre_m", kVector, coordinate, none, false, {0, 0, 0}, {}, {}},
                    {"radius_m", kNumber, length, none, kRequired, {}, {}, {}}}});
  kinds.push_back(
      {"potential_field",
       "a potential field",
       "A potential that the compiler solves: zero on the surface, raised by sources and inclusions.",
       {{"shape", kPart, {}, {"solid"}, kRequired, {}, {}, {}},
        {"step_m",
         kNumber,
         {written(kMinFieldStep_m), 1, false, "m"},
         none,
         kRequired,
         {},
         {},
         "Of the grid; at most 2097152 samples."},
        {"law",
         kWord,
         {},
         {"spring", "energy"},
         false,
         {},
         "spring",
         "spring: the potential is a depth in metres, pressed against the material's stiffness. energy: it "
         "is an energy in "
         "joules."},
        {"source_per_m",
         kNumber,
         {0, kMaxSource, false, "1/m"},
         none,
         false,
         {0},
         {},
         "Law spring: minus the Laplacian of the depth."},
        {"source_N_m",
         kNumber,
         {0, kMaxSource, false, "N/m"},
         none,
         false,
         {0},
         {},
         "Law energy: minus the Laplacian of the energy."},
        {"inclusions", kList, {0, kMaxInclusions}, {"inclusion"}, false, {}, {}, {}},
        {"regions", kList, {0, kMaxInclusions}, {"region"}, false, {}, {}, {}}}});
  kinds.push_back({"solid",
                   "a shape of closed form",
                   "Exactly one shape.",
                   {{"sphere", kPart, {}, {"sphere"}, false, {}, {}, {}},
                    {"box", kPart, {}, {"box"}, false, {}, {}, {}},
                    {"cylinder", kPart, {}, {"cylinder"}, false, {}, {}, {}},
                    {"capsule", kPart, {}, {"capsule"}, false, {}, {}, {}}},
                   true});
  kinds.push_back(
      {"inclusion",
       "an inclusion",
       "A region inside that is held at a potential.",
       {{"shape", kPart, {}, {"solid"}, kRequired, {}, {}, {}},
        {"pose", kPart, {}, {"pose"}, false, {}, {}, {}},
        {"depth_m", kNumber, {0, 1, true, "m"}, none, false, {}, {}, "Law spring: required."},
        {"potential_J", kNumber, {0, 1000, true, "J"}, none, false, {}, {}, "Law energy: required."}}});
  kinds.push_back({"region",
                   "a region",
                   "A region with additional source.",
                   {{"shape", kPart, {}, {"solid"}, kRequired, {}, {}, {}},
                    {"pose", kPart, {}, {"pose"}, false, {}, {}, {}},
                    {"source_per_m",
                     kNumber,
                     {0, kMaxSource, false, "1/m"},
                     none,
                     false,
                     {},
                     {},
                     "Law spring: required."},
                    {"source_N_m",
                     kNumber,
                     {0, kMaxSource, false, "N/m"},
                     none,
                     false,
                     {},
                     {},
                     "Law energy: required."}}});
  kinds.push_back({"pose",
                   "a pose",
                   "First rotates the object about its origin, then moves it.",
                   {{"position_m", kVector, coordinate, none, false, {0, 0, 0}, {}, {}},
                    {"rotation_deg",
                     kVector,
                     {-360, 360, false, "degrees"},
                     none,
                     false,
                     {0, 0, 0},
                     {},
                     "Roll, pitch, yaw: about x, then y, then z, fixed axes."}}});
  kinds.push_back({"material",
                   "a material",
                   "",
                   {{"stiffness_N_m", kNumber, stiffness, none, kRequired, {}, {}, {}},
                    {"damping_N_s_m", kNumber, damping, none, false, {0}, {}, "Along the surface's normal."},
                    {"static_friction",
                     kNumber,
                     friction,
                     none,
                     false,
                     {0},
                     {},
                     "Coefficient of friction while the tip sticks."},
                    {"dynamic_friction",
                     kNumber,
                     friction,
                     none,
                     false,
                     {},
                     {},
                     "While the tip slides: at most static_friction, which is its default."},
                    {"friction_mode", kWord, {}, {"stick_slip", "steady"}, false, {}, "stick_slip", {}},
                    {"click", kPart, {}, {"click"}, false, {}, {}, {}},
                    {"brake_friction",
                     kNumber,
                     friction,
                     none,
                     false,
                     {0},
                     {},
                     "Added to both coefficients of friction."},
                    {"texture", kPart, {}, {"texture"}, false, {}, {}, {}},
                    {"stiffness_map", kPart, {}, {"stiffness_map"}, false, {}, {}, {}}}});
  kinds.push_back({"click",
                   "a click",
                   "A decaying transient at contact, proportional to the speed of the impact.",
                   {{"amplitude_N",
                     kNumber,
                     {0, written(kMaxClick_N), false, "N"},
                     none,
                     kRequired,
                     {},
                     {},
                     "For an impact at 0.1 m/s."},
                    {"frequency_Hz",
                     kNumber,
                     {written(kMinClickFrequency_Hz), written(kMaxClickFrequency_Hz), false, "Hz"},
                     none,
                     kRequired,
                     {},
                     {},
                     {}},
                    {"decay_per_s",
                     kNumber,
                     {written(kMinClickDecay_per_s), written(kMaxClickDecay_per_s), false, "1/s"},
                     none,
                     kRequired,
                     {},
                     {},
                     {}}}});
  kinds.push_back(
      {"texture",
       "a texture",
       "One tile of heights that repeats over the surface; exactly one of pattern, heights and file.",
       {{"kind", kWord, {}, {"lateral", "normal", "height"}, kRequired, {}, {}, {}},
        {"tile_m", kPair, length, none, kRequired, {}, {}, "Size of the tile along u and v."},
        {"height_m",
         kNumber,
         {0, written(kMaxRelief_m), true, "m"},
         none,
         kRequired,
         {},
         {},
         "From the lowest point to the highest."},
        {"pattern", kWord, {}, {"cos_cos", "ridges", "noise"}, false, {}, {}, {}},
        {"heights",
         kRows,
         {-1.0e6, 1.0e6},
         none,
         false,
         {},
         {},
         "In any unit; the last row is at the least v."},
        {"file", kText, path, none, false, {}, {}, "CSV or PNG, relative to the scene file."}}});
  kinds.push_back(
      {"stiffness_map",
       "a stiffness map",
       "Control points of a bicubic B-spline of stiffness and damping over the surface.",
       {{"stiffness_N_m",
         kRowsOrFile,
         stiffness,
         none,
         kRequired,
         {},
         {},
         "Rows of numbers, or the path of a CSV file of them; the last row is at the least v."},
        {"damping_N_s_m",
         kRowsOrFile,
         damping,
         none,
         false,
         {},
         {},
         "As many numbers; without them the material's damping holds everywhere."},
        {"cell_m", kNumber, length, none, kRequired, {}, {}, "Between neighbouring control points."},
        {"origin_m",
         kVector,
         coordinate,
         none,
         false,
         {0, 0, 0},
         {},
         "The first control point, in the object's frame."},
        {"u", kDirection, kAny, none, false, {1, 0, 0}, {}, "Along the rows."},
        {"v", kDirection, kAny, none, false, {0, 1, 0}, {}, "From row to row."},
        {"conservative",
         kFlag,
         {},
         none,
         false,
         {1},
         {},
         "Adds the sideways force that makes it a potential."}}});
  // Control elements: the rows of a slide and of a turn have the same order (scene_control.cpp).
  kinds.push_back({"slide_control",
                   "a control that slides",
                   "A control element that slides along the axis, 0 at the start: spring, damping, friction, "
                   "stops, detents, curve and switch.",
                   {{"stiffness_N_m", kNumber, {0, stiffest, false, "N/m"}, none, false, {0}, {}, {}},
                    {"rest_m", kNumber, coordinate, none, false, {0}, {}, {}},
                    {"damping_N_s_m", kNumber, damping, none, false, {0}, {}, {}},
                    {"friction_N", kNumber, {0, effort, false, "N"}, none, false, {0}, {}, {}},
                    {"low_m", kNumber, {-reach, 0, false, "m"}, none, false, {-reach}, {}, {}},
                    {"high_m", kNumber, {0, reach, false, "m"}, none, false, {reach}, {}, {}},
                    {"detents", kPart, {}, {"slide_detents"}, false, {}, {}, {}},
                    {"curve_m_N",
                     kCurve,
                     coordinate,
                     none,
                     false,
                     {},
                     {},
                     "[at, effort against pressing], rising in at, linear between."},
                    {"switch", kPart, {}, {"slide_switch"}, false, {}, {}, {}}}});
  kinds.push_back(
      {"slide_detents",
       "detents",
       "-T sin(2 pi (q - phase) / pitch).",
       {{"pitch_m", kNumber, {written(kMinDetentPitch), reach, false, "m"}, none, kRequired, {}, {}, {}},
        {"phase_m", kNumber, coordinate, none, false, {0}, {}, {}},
        {"force_N", kNumber, {0, effort, true, "N"}, none, kRequired, {}, {}, {}}}});
  kinds.push_back({"slide_switch",
                   "a switch",
                   "On where q passes on_at, off where it passes off_at on the way back.",
                   {{"on_at_m", kNumber, coordinate, none, kRequired, {}, {}, {}},
                    {"off_at_m", kNumber, coordinate, none, kRequired, {}, {}, {}}}});
  kinds.push_back(
      {"turn_control",
       "a control that turns",
       "A control element that turns about the axis; q is its angle.",
       {{"stiffness_N_m_rad", kNumber, {0, stiffest, false, "N m/rad"}, none, false, {0}, {}, {}},
        {"rest_deg", kNumber, turn, none, false, {0}, {}, {}},
        {"damping_N_m_s_rad", kNumber, {0, most_damping, false, "N m s/rad"}, none, false, {0}, {}, {}},
        {"friction_N_m", kNumber, {0, effort, false, "N m"}, none, false, {0}, {}, {}},
        {"low_deg", kNumber, {-kMaxTurn_deg, 0, false, "degrees"}, none, false, {-kMaxTurn_deg}, {}, {}},
        {"high_deg", kNumber, {0, kMaxTurn_deg, false, "degrees"}, none, false, {kMaxTurn_deg}, {}, {}},
        {"detents", kPart, {}, {"turn_detents"}, false, {}, {}, {}},
        {"curve_deg_N_m",
         kCurve,
         turn,
         none,
         false,
         {},
         {},
         "[at, effort against pressing], rising in at, linear between."},
        {"switch", kPart, {}, {"turn_switch"}, false, {}, {}, {}}}});
  kinds.push_back(
      {"turn_detents",
       "detents",
       "-T sin(2 pi (q - phase) / pitch).",
       {{"pitch_deg", kNumber, {kMinPitch_deg, kMaxTurn_deg, false, "degrees"}, none, kRequired, {}, {}, {}},
        {"phase_deg", kNumber, turn, none, false, {0}, {}, {}},
        {"torque_N_m", kNumber, {0, effort, true, "N m"}, none, kRequired, {}, {}, {}}}});
  kinds.push_back({"turn_switch",
                   "a switch",
                   "On where q passes on_at, off where it passes off_at on the way back.",
                   {{"on_at_deg", kNumber, turn, none, kRequired, {}, {}, {}},
                    {"off_at_deg", kNumber, turn, none, kRequired, {}, {}, {}}}});
  for (SceneKind& kind : kinds)
    for (const SceneKey& key : kind.keys) kind.key_names.push_back(key.name);
  return kinds;
}

}  // namespace

const std::vector<SceneKind>& scene_kinds() {
  static const std::vector<SceneKind> kKinds = table();
  return kKinds;
}

const SceneKind& scene_kind(std::string_view name) {
  const auto found = std::ranges::find(scene_kinds(), name, &SceneKind::name);
  if (found == scene_kinds().end()) throw std::logic_error("no such kind: " + std::string(name));
  return *found;
}

const SceneKey& scene_key(const SceneKind& kind, std::string_view name) {
  const auto found = std::ranges::find(kind.keys, name, &SceneKey::name);
  if (found == kind.keys.end())
    throw std::logic_error(std::string(kind.name) + " has no key " + std::string(name));
  return *found;
}

}  // namespace thimble::host
