// fault list, clear and explain.
#include <fmt/format.h>

#include <iterator>

#include "firmware/core/faults.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"

namespace thimble::host {
namespace {

Json fault_json(const firmware::FaultRow& row) {
  return {{"number", static_cast<int>(row.fault)},
          {"name", row.name},
          {"emergency_code", row.emergency_code},
          {"cause", row.cause},
          {"remedy", row.remedy}};
}

}  // namespace

void fault_list(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  const std::vector<std::uint8_t> numbers = device.faults();
  const std::uint8_t latched = device.state().fault;
  Json json = document("fault");
  json["latched"] = latched;
  json["faults"] = Json::array();
  for (const std::uint8_t number : numbers) {
    const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
    const std::vector<link::FreezeFrame> frames = device.freeze_frames(number);
    if (common.json) {
      Json entry = row == nullptr ? Json{{"number", number}} : fault_json(*row);
      entry["latched"] = number == latched;
      entry["freeze_frames"] = Json::array();
      for (const link::FreezeFrame& frame : frames) entry["freeze_frames"].push_back(host::to_json(frame));
      json["faults"].push_back(entry);
      continue;
    }
    say("{} {}{}: {}\n  remedy: {}\n", number, row == nullptr ? "unknown" : row->name,
        number == latched ? " (latched)" : "", row == nullptr ? "" : row->cause,
        row == nullptr ? "" : row->remedy);
    if (!frames.empty()) {
      const link::FreezeFrame& last = frames.back();
      say("  {} ticks kept; the last: tick {}, tip {:.5f} {:.5f} {:.5f} m, force {:.3f} {:.3f} {:.3f} N, "
          "{}\n",
          frames.size(), last.tick, last.tip_x_m, last.tip_y_m, last.tip_z_m, last.force_x_N, last.force_y_N,
          last.force_z_N, name(last.mode));
    }
  }
  if (common.json) {
    print(json);
  } else if (numbers.empty()) {
    say(stderr, "no fault since the last clear\n");
  }
}

void fault_clear(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  device.clear_faults();
  print_mode(common, "fault", device.state().mode);
}

void fault_explain(const Common& common, const std::string& which) {
  for (const firmware::FaultRow& row : firmware::kFaultTable) {
    if (which != row.name && which != std::to_string(static_cast<int>(row.fault))) continue;
    if (common.json) {
      Json json = document("fault");
      json.update(fault_json(row));
      print(json);
    } else {
      say("{} {} (emergency code 0x{:04X})\n  cause: {}\n  remedy: {}\n", static_cast<int>(row.fault),
          row.name, row.emergency_code, row.cause, row.remedy);
    }
    return;
  }
  throw Error(ExitCode::kUsage, "unknown-fault", "there is no fault '" + which + "'",
              fmt::format("give a number from 1 to {}, or a name",
                          static_cast<int>(std::end(firmware::kFaultTable)[-1].fault)));
}

}  // namespace thimble::host
