// thimble doctor: is this machine ready for a device?
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "host-tools/can_tools/doctor_findings.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/discovery.h"

namespace thimble::host {
namespace {

// can:can0, canfd:can0, slcan:/dev/ttyACM0, the name of an interface or of `thimble list`.
Wish wish_for(const std::string& device) {
  std::string uri = device;
  std::error_code none;
  if (uri.find(':') == std::string::npos)
    uri = std::filesystem::exists("/sys/class/net/" + uri, none) ? "can:" + uri : choose_device(uri);
  Wish wish;
  const auto after = [&uri](std::string_view scheme) {
    return uri.size() > scheme.size() && uri.starts_with(scheme) ? uri.substr(scheme.size()) : std::string();
  };
  wish.fd = uri.starts_with("canfd:");
  wish.interface = wish.fd ? after("canfd:") : after("can:");
  wish.port = after("slcan:");
  if (wish.interface.empty() && wish.port.empty()) {
    throw Error(
        ExitCode::kUsage, "bad-uri", "'" + device + "' is neither a CAN interface nor a serial port",
        "write can:can0, canfd:can0 or slcan:/dev/ttyACM0; without --device all of them are looked at");
  }
  return wish;
}

void print_text(const std::vector<Finding>& findings) {
  for (const Finding& finding : findings) {
    say("{:8} {}{}{}: {}\n", state_name(finding.state), finding.name, finding.subject.empty() ? "" : " ",
        finding.subject, finding.cause);
    if (!finding.remedy.empty()) say("         remedy: {}\n", finding.remedy);
  }
}

void print_json(const std::vector<Finding>& findings) {
  Json json = document("doctor");
  json["findings"] = Json::array();
  for (const Finding& finding : findings) {
    json["findings"].push_back({{"name", finding.name},
                                {"subject", finding.subject},
                                {"state", state_name(finding.state)},
                                {"cause", finding.cause},
                                {"remedy", finding.remedy}});
  }
  for (const FindingState state : {FindingState::kWarning, FindingState::kFailure}) {
    json[state == FindingState::kWarning ? "warnings" : "failures"] =
        std::ranges::count(findings, state, &Finding::state);
  }
  print(json);
}

}  // namespace

void doctor(const Common& common, const DoctorChoice& choice) {
  Wish wish;
  if (!choice.device.empty()) wish = wish_for(choice.device);
  std::error_code none;
  wish.board = choice.board || std::filesystem::exists("/etc/thimble/board.json", none);

  Facts facts;
  facts.can_sockets = kernel_has_can_sockets();
  if (wish.port.empty()) facts.interfaces = read_can_interfaces();
  facts.devices =
      wish.port.empty() ? read_devices(wish.board) : std::vector{read_device(DeviceKind::kSerial, wish.port)};
  facts.privileges = read_privileges();

  const std::vector<Finding> findings = judge(facts, wish);
  common.json ? print_json(findings) : print_text(findings);
  const auto failed = std::ranges::find(findings, FindingState::kFailure, &Finding::state);
  if (failed == findings.end()) return;
  std::fflush(stdout);
  throw Error(failed->code, failed->name, failed->cause, failed->remedy);
}

}  // namespace thimble::host
