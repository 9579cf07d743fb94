// Both ends of every range of the table of keys are accepted by the compiler, and what is beyond them by a millionth is
// refused with numbers as a person would write them.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "control/scene/scene_view.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/compiler/scene_keys.h"
#include "host-tools/error.h"
#include "tests/support/figure.h"
#include "tests/support/temporary_folder.h"
#include "tests/unit/compiler/refusal.h"

namespace thimble::test {
namespace {

using host::FileKey;
using host::KeyType;
using nlohmann::json;

// A scene of one object, and where in the object a part of the kind is.
struct Sample {
  std::string kind;
  std::string object;
  std::string part;
};

std::string shaped(const std::string& shape, const std::string& more = "") {
  return R"({"name": "it", "material": {"stiffness_N_m": 500}, "shape": {)" + shape + "}" + more + "}";
}

std::string moving(const std::string& body) {
  return shaped(R"("sphere": {"radius_m": 0.01})", R"(, "body": {"mass_kg": 0.1, )" + body + "}");
}

std::string with_material(const std::string& more) {
  return R"({"name": "it", "shape": {"box": {"size_m": [0.1, 0.1, 0.1]}}, "material": {"stiffness_N_m": 500, )" +
         more + "}}";
}

const std::vector<Sample>& samples() {
  static const std::string potential = shaped(
      R"("potential_field": {"shape": {"sphere": {"radius_m": 0.01}}, "step_m": 0.002, "source_per_m": 100,
         "inclusions": [{"shape": {"sphere": {"radius_m": 0.004}}, "depth_m": 0.01}],
         "regions": [{"shape": {"sphere": {"radius_m": 0.005}}, "source_per_m": 100}]})");
  static const std::string energy = shaped(
      R"("potential_field": {"shape": {"sphere": {"radius_m": 0.01}}, "step_m": 0.002, "law": "energy", "source_N_m": 1,
         "inclusions": [{"shape": {"sphere": {"radius_m": 0.004}}, "potential_J": 0.01}],
         "regions": [{"shape": {"sphere": {"radius_m": 0.005}}, "source_N_m": 1}]})");
  static const std::vector<Sample> all = {
      {"pose", shaped(R"("sphere": {"radius_m": 0.01})", R"(, "pose": {})"), "/pose"},
      {"plane", shaped(R"("plane": {"normal": [0, 0, 1]})"), "/shape/plane"},
      {"sphere", shaped(R"("sphere": {"radius_m": 0.01})"), "/shape/sphere"},
      {"box", shaped(R"("box": {"size_m": [0.1, 0.1, 0.1]})"), "/shape/box"},
      {"cylinder", shaped(R"("cylinder": {"radius_m": 0.01, "height_m": 0.05})"), "/shape/cylinder"},
      {"capsule", shaped(R"("capsule": {"radius_m": 0.01, "height_m": 0.05})"), "/shape/capsule"},
      {"cone", shaped(R"("cone": {"radius_m": 0.01, "height_m": 0.05})"), "/shape/cone"},
      {"mesh", shaped(R"("mesh": {"file": "asteroid/asteroid.plg", "scale": 1e-5})"), "/shape/mesh"},
      {"height_field",
       shaped(
           R"("height_field": {"file": "telephone/heights_mm.csv", "size_m": [0.15, 0.12], "height_m": 0.001})"),
       "/shape/height_field"},
      {"layer", shaped(R"("needle": {"layers": [{"thickness_m": 0.01, "stiffness_N_m": 100, "tear_N": 1}]})"),
       "/shape/needle/layers/0"},
      {"tissue",
       shaped(
           R"("tissue": {"size_m": [0.1, 0.1], "contact_radius_m": 0.005, "relaxed_stiffness_N_m": 100, "recovery_s": 1})"),
       "/shape/tissue"},
      {"ball", shaped(R"("vector_field": {"subvolumes": [{"ball": {"radius_m": 0.01}}]})"),
       "/shape/vector_field/subvolumes/0/ball"},
      {"force_field", shaped(R"("force_field": {})"), "/shape/force_field"},
      {"hung_mass", shaped(R"("force_field": {"mass": {"mass_kg": 1, "stiffness_N_m": 100}})"),
       "/shape/force_field/mass"},
      {"potential_field", potential, "/shape/potential_field"},
      {"potential_field", energy, "/shape/potential_field"},
      {"inclusion", potential, "/shape/potential_field/inclusions/0"},
      {"inclusion", energy, "/shape/potential_field/inclusions/0"},
      {"region", potential, "/shape/potential_field/regions/0"},
      {"region", energy, "/shape/potential_field/regions/0"},
      {"material", with_material(R"("static_friction": 10)"), "/material"},
      {"click", with_material(R"("click": {"amplitude_N": 1, "frequency_Hz": 100, "decay_per_s": 100})"),
       "/material/click"},
      {"texture",
       with_material(
           R"("texture": {"kind": "lateral", "tile_m": [0.004, 0.004], "height_m": 0.0005, "heights": [[0, 1], [1, 0]]})"),
       "/material/texture"},
      {"stiffness_map",
       with_material(
           R"("stiffness_map": {"stiffness_N_m": [[500, 500], [500, 500]], "damping_N_s_m": [[1, 1], [1, 1]],
                        "cell_m": 0.01})"),
       "/material/stiffness_map"},
      {"body", moving(R"("motion": "free")"), "/body"},
      {"body", moving(R"("motion": "turn", "axis": [0, 0, 1])"), "/body"},
      {"slide_control", moving(R"("motion": "slide", "axis": [0, 0, 1], "control": {})"), "/body/control"},
      {"slide_detents",
       moving(
           R"("motion": "slide", "axis": [0, 0, 1], "control": {"detents": {"pitch_m": 0.1, "force_N": 1}}, "mass_kg": 1)"),
       "/body/control/detents"},
      {"slide_switch",
       moving(
           R"("motion": "slide", "axis": [0, 0, 1], "control": {"switch": {"on_at_m": 0.002, "off_at_m": 0.001}})"),
       "/body/control/switch"},
      {"turn_control", moving(R"("motion": "turn", "axis": [0, 0, 1], "control": {})"), "/body/control"},
      {"turn_detents",
       moving(
           R"("motion": "turn", "axis": [0, 0, 1], "inertia_kg_m2": [1, 1, 1], "control": {"detents": {"pitch_deg": 10, "torque_N_m": 1}})"),
       "/body/control/detents"},
      {"turn_switch",
       moving(
           R"("motion": "turn", "axis": [0, 0, 1], "control": {"switch": {"on_at_deg": 2, "off_at_deg": 1}})"),
       "/body/control/switch"}};
  return all;
}

// What other keys must be so that a rule for several keys holds as well: merged into the object.
const std::map<std::string, std::string>& companions() {
  static const std::map<std::string, std::string> all = {
      {"body/inertia_kg_m2/least", R"({"material": {"stiffness_N_m": 10}})"},
      {"slide_control/stiffness_N_m/most", R"({"body": {"mass_kg": 1}})"},
      {"turn_control/stiffness_N_m_rad/most", R"({"body": {"inertia_kg_m2": [1, 1, 1]}})"},
      {"height_field/height_m/most", R"({"shape": {"height_field": {"file": "tmp:low.csv"}}})"},
      {"mesh/scale/most", R"({"shape": {"mesh": {"file": "tmp:tiny.obj"}}})"},
      {"mesh/scale/least", R"({"shape": {"mesh": {"file": "tmp:huge.obj"}}})"},
      {"layer/stiffness_N_m/least",
       R"({"shape": {"needle": {"layers": [{"thickness_m": 0.01, "tear_N": 0}]}}})"},
      {"tissue/relaxed_stiffness_N_m/most", R"({"material": {"stiffness_N_m": 100000}})"},
      {"potential_field/step_m/most",
       R"({"shape": {"potential_field": {"shape": {"sphere": {"radius_m": 5}}, "inclusions": null, "regions": null}}})"},
      {"potential_field/step_m/least",
       R"({"shape": {"potential_field": {"shape": {"sphere": {"radius_m": 1e-4}}, "inclusions": null, "regions": null}}})"},
  };
  return all;
}

// Ends of a range that no other keys make possible. A tile has at least two heights along each side; the spline of a
// potential overshoots between an inclusion and the surface.
const std::map<std::string, std::string>& never_alone() {
  static const std::map<std::string, std::string> all = {
      {"texture/tile_m/least", "too-fine"}, {"inclusion/potential_J/most", "potential-too-high"}};
  return all;
}

json scene_with(const json& object) {
  return {{"thimble_scene", 1}, {"name", "ranges"}, {"objects", {object}}};
}

std::string refused_as(const json& scene, std::string* cause = nullptr) {
  const Refusal refusal = refusal_of([&] {
    const host::CompiledScene compiled =
        host::compile_scene_text(scene.dump(), "test.scene.json", THIMBLE_SOURCE_DIR "/scenes");
    control::SceneView view;
    EXPECT_STREQ(control::name(control::SceneView::check(compiled.image, view)),
                 control::name(control::ImageStatus::kOk))
        << "the controller refuses " << scene.dump();
  });
  if (cause != nullptr) *cause = refusal.cause;
  return refusal.name;
}

// All numbers of the key's value are this one; of rows, the first: the others are in the middle of the range.
json value_of(const FileKey& key, double number) {
  if (key.type == KeyType::kPair) return {number, number};
  if (key.type == KeyType::kVector) return {number, number, number};
  if (key.type == KeyType::kRows || key.type == KeyType::kRowsOrFile) {
    const double middle = 0.5 * (key.range.least + key.range.most);
    return {{number, middle}, {middle, middle}};
  }
  return number;
}

std::string tetrahedron(const std::string& edge) {
  return "v 0 0 0\nv " + edge + " 0 0\nv 0 " + edge + " 0\nv 0 0 " + edge +
         "\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
}

std::string replaced_all(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::string accepted_as(const std::string& place) {
  const auto found = never_alone().find(place);
  return found == never_alone().end() ? "nothing refused" : found->second;
}

bool ranged(const FileKey& key) {
  return key.type == KeyType::kNumber || key.type == KeyType::kPair || key.type == KeyType::kVector ||
         key.type == KeyType::kRows || key.type == KeyType::kRowsOrFile;
}

// The most significant digits of any number in the text, other than the given one.
std::size_t digits_in(std::string text, double given) {
  const std::string given_text = json(given).dump();
  for (std::size_t at = text.find(given_text); at != std::string::npos; at = text.find(given_text))
    text.erase(at, given_text.size());
  std::size_t most = 0;
  const std::regex number("[0-9]+(\\.[0-9]+)?");
  for (std::sregex_iterator at(text.begin(), text.end(), number), end; at != end; ++at) {
    std::string digits = std::regex_replace(at->str(), std::regex("\\."), "");
    digits.erase(0, digits.find_first_not_of('0'));
    digits.erase(digits.find_last_not_of('0') + 1);
    most = std::max(most, digits.size());
  }
  return most;
}

TEST(SceneRanges, BothEndsAreAcceptedAndNothingBeyond) {
  int accepted = 0;
  int refused = 0;
  std::size_t digits = 0;
  std::set<std::string> tried;
  const TemporaryFolder files;
  files.write("low.csv", "0,0.5\n0.5,0\n");
  files.write("tiny.obj", tetrahedron("1e-11"));
  files.write("huge.obj", tetrahedron("1e7"));
  for (const Sample& sample : samples()) {
    const json whole = json::parse(sample.object);
    ASSERT_EQ(refused_as(scene_with(whole)), "nothing refused") << sample.kind << ": " << sample.object;
    for (const FileKey& key : host::scene_kind(sample.kind).keys) {
      if (!ranged(key)) continue;
      const std::string name = sample.kind + "/" + std::string(key.name);
      const auto with = [&](double number, const std::string& end) {
        json object = whole;
        if (const auto more = companions().find(name + "/" + end); more != companions().end())
          object.merge_patch(json::parse(replaced_all(more->second, "tmp:", files.path().string() + "/")));
        json& part = object[json::json_pointer(sample.part)];
        const std::string word(key.name);
        part[word] = value_of(key, number);
        return scene_with(object);
      };
      std::string why;
      const std::string first = refused_as(with(key.range.most, "most"), &why);
      if (first == "senseless-key" || first == "wrong-law")
        continue;  // of the other motion, or the other law
      tried.insert(name);
      EXPECT_EQ(first, accepted_as(name + "/most")) << name << " = " << key.range.most << ": " << why;
      const std::string least = refused_as(with(key.range.least, "least"), &why);
      EXPECT_EQ(least, key.range.least_excluded ? "bad-value" : accepted_as(name + "/least"))
          << name << " = " << key.range.least << ": " << why;
      accepted += 2;
      for (const bool above : {false, true}) {
        const double end = above ? key.range.most : key.range.least;
        const double beyond = end + (above ? 1e-6 : -1e-6) * (end == 0.0 ? 1.0 : std::abs(end));
        EXPECT_EQ(refused_as(with(beyond, above ? "most" : "least"), &why), "bad-value")
            << name << " = " << beyond;
        EXPECT_LE(digits_in(why, beyond), 7U) << why;
        digits = std::max(digits, digits_in(why, beyond));
        ++refused;
      }
    }
  }
  // Every key of the table with a range.
  for (const host::FileKind& kind : host::scene_kinds())
    for (const FileKey& key : kind.keys)
      if (ranged(key) && kind.name != "scene") {
        EXPECT_TRUE(tried.contains(std::string(kind.name) + "/" + std::string(key.name)))
            << kind.name << "/" << key.name;
      }
  figure("ends of ranges, accepted", accepted, "all");
  figure("numbers beyond them, refused", refused, "all");
  figure("digits of the limits in the messages, at most", static_cast<double>(digits), "7");
}

}  // namespace
}  // namespace thimble::test
