// import: scenes from data of another kind.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/device_log.h"
#include "host-tools/lab/import_volume.h"
#include "host-tools/lab/run_log.h"

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
  keep_apart(choice.volume, choice.output);
  keep_apart(choice.table, choice.output);
  std::optional<Busy> busy(std::in_place, common.json, "reading the volume");
  const ImportedNeedle imported = import_volume(wanted);
  busy.reset();
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
  say("{} voxels, placed by {}; {} layers -> {}\n", imported.voxel_type, imported.frame,
      imported.layers.size(), choice.output.string());
  for (const TissueLayer& layer : imported.layers) {
    say("  {:7.2f} to {:7.2f} mm  {} (mean intensity {:.4g})\n", layer.begin_mm, layer.end_mm,
        imported.kinds[layer.kind].name, layer.mean);
  }
}

void import_device_log(const Common& common, const ImportDeviceLogChoice& choice) {
  if (choice.path.empty() && choice.forces.empty()) {
    throw Error(ExitCode::kUsage, "usage", "neither --output nor --log is given",
                "--output PATH.csv for `thimble simulate --path`, --log LOG.csv for `thimble plot`");
  }
  keep_apart(choice.log, choice.path);
  keep_apart(choice.log, choice.forces);
  keep_outputs_apart(choice.path, choice.forces);
  std::optional<Busy> busy(std::in_place, common.json, "converting the log");
  const DeviceLog log = read_device_log(choice.log, choice.thimble_frame);
  if (!choice.forces.empty() && !log.has_force) {
    throw Error(ExitCode::kBadInput, "no-force", choice.log.string() + " has no FORCE",
                "write its path (--output), and simulate a scene along it (`thimble simulate`)");
  }
  if (!choice.path.empty()) {
    OutputFile file(choice.path);
    file.stream() << "time_s,x_m,y_m,z_m\n";
    for (const DeviceLogSample& sample : log.samples)
      file.stream() << fmt::format("{:.9g},{:.9g},{:.9g},{:.9g}\n", sample.time_s, sample.position_m.x(),
                                   sample.position_m.y(), sample.position_m.z());
    file.commit();
  }
  if (!choice.forces.empty()) {
    OutputFile file(choice.forces);
    write_log_header(file.stream(), {});
    for (const DeviceLogSample& sample : log.samples) {
      board::LogRow row;
      row.time_s = sample.time_s;
      row.tip_m = row.proxy_m = sample.position_m;  // a DeviceLog has no god object
      row.force_N = sample.force_N;
      row.contacts = sample.force_N.isZero() ? 0 : 1;
      write_log_row(file.stream(), row, {});
    }
    file.commit();
  }
  busy.reset();
  const double seconds = log.samples.back().time_s - log.samples.front().time_s;
  if (common.json) {
    Json json = document("import devicelog");
    json["kind"] = log.binary ? "binary" : "text";
    json["columns"] = log.columns;
    json["rows"] = log.samples.size();
    json["repeated"] = log.repeated;
    json["seconds"] = seconds;
    if (!choice.path.empty()) json["path"] = choice.path.string();
    if (!choice.forces.empty()) json["log"] = choice.forces.string();
    print(json);
    return;
  }
  say("{} log with {}: {} rows over {:.3f} s{}\n", log.binary ? "binary" : "text",
      fmt::join(log.columns, ", "), log.samples.size(), seconds,
      log.repeated == 0 ? "" : fmt::format(", {} left out whose time did not rise", log.repeated));
}

}  // namespace thimble::host
