// audit: what was done with a device, when and by whom.
#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <ctime>

#include "firmware/core/faults.h"
#include "firmware/params.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/printable.h"

namespace thimble::host {
namespace {

using link::AuditEvent;
using link::AuditRecord;

std::string text_of(const AuditRecord& entry) {
  return printable(std::string(entry.text.begin(), std::find(entry.text.begin(), entry.text.end(), 0)));
}

std::string fault_name(std::uint32_t number) {
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
  return row == nullptr ? fmt::format("fault {}", number) : row->name;
}

std::string utc_text(std::uint32_t utc_s) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time_t{utc_s}));
}

// "max_force 3.5"; the bits where this version does not know the parameter.
std::string parameter_text(const AuditRecord& entry) {
  for (const firmware::ParamRow& row : firmware::kParamTable) {
    if (row.id != entry.detail) continue;
    return row.type == firmware::ParamType::kFloat
               ? fmt::format("{} {:g}", row.name, std::bit_cast<float>(entry.value))
               : fmt::format("{} {}", row.name, entry.value);
  }
  return fmt::format("0x{:04X} 0x{:08X}", entry.detail, entry.value);
}

// What the event was about; empty if its name says all.
std::string about(const AuditRecord& entry) {
  switch (entry.event) {
    case AuditEvent::kStart:
      return text_of(entry);
    case AuditEvent::kDisarmed: {
      const auto cause = static_cast<link::StoppedBy>(entry.detail);
      if (cause == link::StoppedBy::kFault) return "by " + fault_name(entry.value);
      return std::string("by ") + (cause == link::StoppedBy::kDisarm ? "host" : name(cause));
    }
    case AuditEvent::kMove:
      return fmt::format("arm {}", entry.detail);
    case AuditEvent::kParameter:
      return parameter_text(entry);
    case AuditEvent::kFault:
    case AuditEvent::kCleared:
      return fault_name(entry.value);
    case AuditEvent::kScene:
    case AuditEvent::kSaved:
      return fmt::format("CRC {:08x}", entry.value);
    case AuditEvent::kArmImage:
      return fmt::format("arm {}, CRC {:08x}", entry.detail, entry.value);
    case AuditEvent::kTimeTold:
      return utc_text(entry.value);
    case AuditEvent::kArmed:
    case AuditEvent::kHoming:
    case AuditEvent::kRestart:
    case AuditEvent::kUploadRefused:
    case AuditEvent::kKeySet:
    case AuditEvent::kKeyRemoved:
    case AuditEvent::kProofRefused:
      return "";
  }
  return fmt::format("{} {}", entry.detail, entry.value);  // of a later version
}

std::string who(const AuditRecord& entry) {
  if (entry.host == 0) return "";
  const std::string name = text_of(entry);
  return fmt::format("by host {:02X}, {}", entry.host, name.empty() ? "which gave no name" : name);
}

Json entry_json(const AuditRecord& entry) {
  Json json = host::to_json(entry);
  json["text"] = text_of(entry);
  json["about"] = about(entry);
  json["time"] = entry.utc_s == 0 ? Json(nullptr) : Json(utc_text(entry.utc_s));
  return json;
}

}  // namespace

void audit(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  const std::vector<AuditRecord> entries = device.audit();
  if (common.json) {
    Json json = document("audit");
    json["entries"] = Json::array();
    for (const AuditRecord& entry : entries) json["entries"].push_back(entry_json(entry));
    return print(json);
  }
  for (const AuditRecord& entry : entries) {
    if (entry.left_out != 0) say("  {} more without an entry\n", entry.left_out);
    const std::string what = fmt::format("{} {}", name(entry.event), about(entry));
    say("{:<20}  start {}, {:>6} s  {:<34} {}\n", entry.utc_s != 0 ? utc_text(entry.utc_s) : "time not known",
        entry.start, entry.uptime_s, what, who(entry));
  }
}

}  // namespace thimble::host
