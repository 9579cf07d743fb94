#include "host-tools/lab/import_volume.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "control/scene/limits.h"
#include "host-tools/compiler/compile.h"
#include "host-tools/error.h"

namespace thimble::host {
namespace {

using Json = nlohmann::ordered_json;

// The skin lies this far below the tip's home: the needle starts outside.
constexpr double kSkin_m = -0.02;
// What holds the needle to its track.
constexpr double kTrackStiffness_N_m = 600.0;
constexpr double kTrackDamping_N_s_m = 1.0;

double metres(double mm) { return std::round(mm * 1000.0) / 1.0e6; }  // to a micrometre

std::string text_of(const Eigen::Vector3d& p) {
  std::ostringstream text;
  text << "(" << p.x() << ", " << p.y() << ", " << p.z() << ")";
  return text.str();
}

Json needle_of(const ImportedNeedle& imported) {
  Json layers = Json::array();
  for (const TissueLayer& layer : imported.layers) {
    const TissueKind& kind = imported.kinds[layer.kind];
    layers.push_back({{"name", kind.name},
                      {"thickness_m", metres(layer.end_mm - layer.begin_mm)},
                      {"stiffness_N_m", kind.stiffness_N_m},
                      {"tear_N", kind.tear_N},
                      {"friction_N", kind.friction_N},
                      {"viscosity_N_s_m2", kind.viscosity_N_s_m2}});
  }
  return {{"layers", layers}};
}

std::string scene_of(const ImportedNeedle& imported, const std::filesystem::path& volume) {
  const std::string file = volume.filename().string();
  Json scene;
  scene["thimble_scene"] = 1;
  scene["name"] = ("needle in " + file).substr(0, 64);
  scene["description"] = "The way of a needle through " + file.substr(0, 1024) + ", from " +
                         text_of(imported.from_mm) + " to " + text_of(imported.to_mm) +
                         " mm. Below the skin it goes along -z.";
  scene["objects"] = Json::array();
  scene["objects"].push_back(
      {{"name", "needle's way"},
       {"shape", {{"needle", needle_of(imported)}}},
       {"pose", {{"position_m", {0.0, 0.0, kSkin_m}}}},
       {"material", {{"stiffness_N_m", kTrackStiffness_N_m}, {"damping_N_s_m", kTrackDamping_N_s_m}}}});
  return scene.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

ImportedNeedle import_volume(const ImportChoice& choice) {
  const Volume volume = Volume::read(choice.volume);
  ImportedNeedle imported;
  imported.voxel_type = volume.type();
  imported.frame = volume.frame();
  imported.from_mm = choice.in_voxels ? Eigen::Vector3d(volume.world() * choice.from) : choice.from;
  imported.to_mm = choice.in_voxels ? Eigen::Vector3d(volume.world() * choice.to) : choice.to;
  const LineProfile profile = profile_along(volume, imported.from_mm, imported.to_mm, choice.volume.string());
  imported.kinds =
      choice.table ? read_tissue_table(*choice.table) : kinds_by_k_means(profile.values, choice.classes);
  imported.layers = layers_of(profile, imported.kinds, choice.thinnest_mm);
  if (imported.layers.size() > control::kMaxLayers) {
    throw Error(ExitCode::kBadInput, "too-many-layers",
                choice.volume.string() + ": the line has " + std::to_string(imported.layers.size()) +
                    " layers, at most " + std::to_string(control::kMaxLayers) + " are allowed",
                "raise --min-thickness, or use fewer tissues");
  }
  imported.scene = scene_of(imported, choice.volume);
  static_cast<void>(
      compile_scene_text(imported.scene, choice.volume.string(), {}));  // what is written compiles
  return imported;
}

}  // namespace thimble::host
