// list, upload, and the verbs that change the mode: arm, disarm, stop, home, restart.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "firmware/core/faults.h"
#include "host-tools/cli/cost_json.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/progress.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/discovery.h"
#include "host-tools/client/stop.h"
#include "host-tools/compiler/stable_stiffness.h"
#include "host-tools/files/image_file.h"
#include "host-tools/lab/arm_choice.h"
#include "host-tools/lab/kept_arms.h"

namespace thimble::host {
namespace {

using link::Micros;

// Prints the progress of an upload on stderr: on a terminal one line that is redrawn, otherwise a line per
// 10 %.
class ProgressPrinter {
 public:
  void operator()(const UploadProgress& progress) {
    const unsigned percent = static_cast<unsigned>(100.0 * progress.sent / std::max(progress.total, 1U));
    const double left_s = (progress.total - progress.sent) / std::max(progress.bytes_per_s, 1.0);
    if (terminal_) {
      fmt::print(stderr, "\r{:3} %  {:.0f} kB/s  {:.1f} s left \x1b[K", percent, progress.bytes_per_s / 1e3,
                 left_s);
      if (progress.sent == progress.total) say(stderr, "\n");
    } else if (percent / 10 != tenth_) {
      tenth_ = percent / 10;
      say(stderr, "{} %  {:.0f} kB/s  {:.1f} s left\n", tenth_ * 10, progress.bytes_per_s / 1e3, left_s);
    }
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) != 0;
  unsigned tenth_ = 0;
};

// The controller measures it over half a second; 0 if it does not run.
double measured_rate_Hz(Device& device) {
  constexpr int kMostTries = 12;
  for (int tries = 1;; ++tries) {
    const auto rate_Hz = static_cast<double>(device.state().tick_rate_Hz);
    if (rate_Hz > 0 || tries == kMostTries) return rate_Hz;
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

// Of a board that is not known here too: in units.
CostReport cost_on(Device& device, std::span<const std::byte> image, double rate_Hz) {
  if (!(rate_Hz > 0)) return {};
  const std::string name = device.text(link::kDidBoardName);
  const board::BoardCost* const known = board::find_board_cost(name);
  const board::BoardCost other{.name = name, .core = {}, .clock_Hz = 0, .instructions = {}};
  return cost_report(image, known != nullptr ? *known : other, rate_Hz, device.state().work_units,
                     device.info().arms);
}

// Of what the device's arms cannot hold still; `named`, if any, takes the place of what this machine knows of them.
std::vector<std::string> wall_warnings(Device& device, const std::optional<ArmWalls>& named,
                                       std::span<const std::byte> image, double rate_Hz) {
  const std::string all = device.text(link::kDidArmName);
  const std::vector<std::string> names = names_of_arms(all);
  std::vector<ArmWalls> arms;
  if (named) {
    arms.push_back(*named);
  } else {
    const link::ArmImages images = device.arm_images();
    for (std::size_t i = 0; i < names.size() && i < images.crc.size(); ++i)
      arms.push_back(walls_of_device(names[i], images.crc.at(i)));
  }
  std::vector<std::string> warnings = stiffness_warnings(image, arms, rate_Hz);
  if (named && std::ranges::find(names, named->arm) == names.end())
    warnings.push_back("--model names " + named->arm + ", and the arm of the device is " + all);
  return warnings;
}

}  // namespace

void list(const Common& common) {
  std::string trouble;
  const std::vector<DeviceEntry> devices = discover(&trouble);
  if (!trouble.empty() && !common.json) say(stderr, "warning: simulators are not listed: {}\n", trouble);
  if (common.json) {
    Json json = document("list");
    json["devices"] = Json::array();
    for (const DeviceEntry& device : devices) {
      json["devices"].push_back(
          {{"name", device.name}, {"kind", device.kind}, {"arm", device.arm}, {"uris", device.uris}});
    }
    if (!trouble.empty()) json["trouble"] = trouble;
    print(json);
    return;
  }
  for (const DeviceEntry& device : devices) {
    say("{}  {}{}{}", device.name, device.kind, device.arm.empty() ? "" : "  ", device.arm);
    for (const std::string& uri : device.uris) say("  {}", uri);
    say("\n");
  }
  if (devices.empty() && trouble.empty())
    say(stderr, "no device: connect a controller, or start thimble-sim\n");
}

void upload(const Common& common, const Remote& remote, const UploadChoice& choice) {
  std::optional<ArmWalls> named;
  if (!choice.model.empty()) named = chosen_arm(choice.model).walls;
  const ImageFile file = load_image(choice.file);
  Device device = open_device(common, remote);
  const double rate_Hz = measured_rate_Hz(device);
  const CostReport cost = cost_on(device, file.image, rate_Hz);
  if (!common.json && !cost.warning.empty()) say(stderr, "warning: {}\n", cost.warning);
  ProgressPrinter printer;
  std::function<void(const UploadProgress&)> progress;
  if (!common.json) progress = std::ref(printer);
  const UploadResult result = device.upload(file.image, {.crc = file.crc, .verify = choice.verify}, progress);
  const std::string scene = device.text(link::kDidSceneName);
  std::vector<std::string> warnings = wall_warnings(device, named, file.image, rate_Hz);
  if (common.json) {
    if (!cost.warning.empty()) warnings.push_back(cost.warning);
    Json json = document("upload");
    json["scene"] = scene;
    json["bytes"] = result.bytes;
    json["crc"] = result.crc;
    json["resumed_from"] = result.resumed_from;
    json["retried_blocks"] = result.retried_blocks;
    json["seconds"] = result.seconds;
    json["rate_bytes_s"] = result.bytes_per_s;
    json["verified"] = choice.verify;
    if (!cost.text.empty()) json["cost"] = to_json(cost);
    json["warnings"] = warnings;
    print(json);
    return;
  }
  say("{}: {} bytes in {:.2f} s, {:.0f} kB/s{}{}\n", scene, result.bytes, result.seconds,
      result.bytes_per_s / 1e3,
      result.resumed_from == 0 ? "" : fmt::format(", resumed at {}", result.resumed_from),
      choice.verify ? ", verified" : "");
  if (!cost.text.empty()) say("{}\n", cost.text);
  for (const std::string& warning : warnings) say(stderr, "warning: {}\n", warning);
}

void arm(const Common& common, const Remote& remote) {
  open_device(common, remote).arm();
  print_mode(common, "arm", link::Mode::kArmed);
}

void disarm(const Common& common, const Remote& remote) {
  print_mode(common, "disarm",
             host::disarm(open_transport(choose_device(remote.device)), options_of(remote)));
}

void stop(const Common& common, const Remote& remote) {
  const std::unique_ptr<Transport> transport = open_transport(choose_device(remote.device));
  const Stopped stopped =
      stop(*transport, static_cast<std::uint8_t>(remote.node), static_cast<Micros>(remote.timeout_s * 1e6));
  const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(stopped.fault));
  const char* fault = row != nullptr ? row->name : "unknown";
  if (common.json) {
    Json json = document("stop");
    json["mode"] = name(stopped.mode);
    json["fault"] = fault;
    json["after_s"] = stopped.after_s;
    print(json);
  } else {
    say("{}, {}\n", name(stopped.mode), fault);
  }
}

void restart(const Common& common, const Remote& remote) {
  open_device(common, remote).restart();
  if (common.json) {
    Json json = document("restart");
    json["restarting"] = true;
    print(json);
  } else {
    say("restarting\n");
  }
}

void home(const Common& common, const Remote& remote, double wait_s) {
  Device device = open_device(common, remote);
  {
    const Busy busy(common.json, "homing");
    device.home(static_cast<Micros>(wait_s * 1e6));
  }
  print_mode(common, "home", link::Mode::kReady);
}

}  // namespace thimble::host
