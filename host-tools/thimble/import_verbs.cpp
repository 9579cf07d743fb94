// import: scenes from data of another kind.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <string>

#include "host-tools/files/output_file.h"
#include "host-tools/import/import_volume.h"
#include "host-tools/thimble/output.h"
#include "host-tools/thimble/verbs.h"

namespace thimble::host {
namespace {

Eigen::Vector3d point(const char* option, const std::string& text) {
  Eigen::Vector3d p;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int i = 0; i < 3; ++i) {
    const std::from_chars_result read = std::from_chars(at, end, p[i]);
    const bool ends_well = i < 2 ? read.ptr != end && *read.ptr == ',' : read.ptr == end;
    if (read.ec != std::errc{} || !ends_well || !std::isfinite(p[i])) {
      throw Error(ExitCode::kUsage, "bad-point", fmt::format("{} is '{}', allowed is x,y,z", option, text),
                  fmt::format("give three numbers: {} 10,-20.5,30", option));
    }
    at = read.ptr + 1;
  }
  return p;
}

}  // namespace

void import_volume(const Common& common, const ImportVolumeChoice& choice) {
  ImportChoice wanted;
  wanted.volume = choice.volume;
  wanted.from = point("--from", choice.from);
  wanted.to = point("--to", choice.to);
  wanted.in_voxels = choice.in_voxels;
  if (!choice.table.empty()) wanted.table = choice.table;
  wanted.classes = choice.classes;
  wanted.thinnest_mm = choice.thinnest_mm;
  const ImportedNeedle imported = import_volume(wanted);
  OutputFile file(choice.output);
  file.stream() << imported.scene;
  file.commit();

  if (common.json) {
    Json json = document("import volume");
    json["scene"] = choice.output.string();
    json["voxel_type"] = imported.voxel_type;
    json["frame"] = imported.frame;
    json["from_mm"] = {imported.from_mm.x(), imported.from_mm.y(), imported.from_mm.z()};
    json["to_mm"] = {imported.to_mm.x(), imported.to_mm.y(), imported.to_mm.z()};
    json["layers"] = Json::array();
    for (const TissueLayer& layer : imported.layers) {
      json["layers"].push_back({{"name", imported.kinds[layer.kind].name},
                                {"begin_mm", layer.begin_mm},
                                {"end_mm", layer.end_mm},
                                {"mean_intensity", layer.mean}});
    }
    print(json);
    return;
  }
  fmt::print("{} voxels, placed by {}; {} layers -> {}\n", imported.voxel_type, imported.frame,
             imported.layers.size(), choice.output.string());
  for (const TissueLayer& layer : imported.layers) {
    fmt::print("  {:7.2f} to {:7.2f} mm  {} (mean intensity {:.4g})\n", layer.begin_mm, layer.end_mm,
               imported.kinds[layer.kind].name, layer.mean);
  }
}

}  // namespace thimble::host
