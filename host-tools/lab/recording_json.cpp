#include "host-tools/lab/recording_json.h"

namespace thimble::host {

using Json = nlohmann::ordered_json;

Json verdict_json(const ReplayVerdict& verdict) {
  Json json = {{"exact", verdict.exact()},
               {"ticks", verdict.ticks},
               {"checks", verdict.checks},
               {"first_tick", verdict.first_tick},
               {"exact_to", verdict.exact_to},
               {"not_replayed", verdict.not_replayed},
               {"contact_ticks", verdict.contact_ticks},
               {"peak_force_N", verdict.peak_force_N}};
  if (verdict.differs_at) json["differs_at"] = *verdict.differs_at;
  if (verdict.gap_at) json["gap_at"] = *verdict.gap_at;
  return json;
}

Json about_json(const Recording& recording) {
  const RecordingHeader& header = recording.header;
  Json json = {{"tool", header.tool},          {"firmware", header.firmware}, {"board", header.board},
               {"serial", header.serial},      {"arms", header.models},       {"scene", header.scene_name},
               {"scene_crc", header.scene_crc}};
  json["rate_Hz"] = 1.0 / static_cast<double>(header.start.period_s);
  json["end"] = recording.end ? recording.end->reason : "cut_off";
  json["missing"] = recording.end ? recording.end->missing : 0;
  json["dropped"] = recording.end ? recording.end->dropped : 0;
  json["events_missing"] = recording.end ? recording.end->marks_missing : 0;
  return json;
}

}  // namespace thimble::host
