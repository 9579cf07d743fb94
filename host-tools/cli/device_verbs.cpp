// The verbs that talk to a device.
#include <fmt/format.h>
#include <langinfo.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <clocale>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <map>

#include "control/scene/limits.h"
#include "firmware/faults.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/limits.h"
#include "host-tools/cli/monitor_screen.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/discovery.h"
#include "host-tools/files/image_file.h"

namespace thimble::host {
namespace {

using firmware::find_param;
using firmware::kParamTable;
using firmware::ParamRow;
using firmware::ParamType;
using link::CanFrame;
using link::Micros;

constexpr Micros kSilence_us = 3'000'000;  // a device that sends no telemetry for so long is lost
constexpr Micros kKeepAlive_us = 200'000;

// Tells a person which image it met. A program asks `thimble info`: what it reads on stderr stays progress and errors.
Device open_device(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  if (common.json || isatty(STDERR_FILENO) == 0) return device;
  fmt::print(stderr, "{} {} on board {}\n", device.text(link::kDidArmName),
             device.text(link::kDidFirmwareVersion), device.text(link::kDidBoardName));
  return device;
}

// How an upload tells how far it is: a line that is redrawn on a terminal, a line per 10 % otherwise. On
// stderr.
class ProgressPrinter {
 public:
  void operator()(const UploadProgress& progress) {
    const unsigned percent = static_cast<unsigned>(100.0 * progress.sent / std::max(progress.total, 1U));
    const double left_s = (progress.total - progress.sent) / std::max(progress.bytes_per_s, 1.0);
    if (terminal_) {
      fmt::print(stderr, "\r{:3} %  {:.0f} kB/s  {:.1f} s left \x1b[K", percent, progress.bytes_per_s / 1e3,
                 left_s);
      if (progress.sent == progress.total) fmt::print(stderr, "\n");
    } else if (percent / 10 != tenth_) {
      tenth_ = percent / 10;
      fmt::print(stderr, "{} %  {:.0f} kB/s  {:.1f} s left\n", tenth_ * 10, progress.bytes_per_s / 1e3,
                 left_s);
    }
  }

 private:
  bool terminal_ = isatty(STDERR_FILENO) != 0;
  unsigned tenth_ = 0;
};

void done(const Common& common, const char* verb, std::uint8_t mode) {
  if (common.json) {
    Json json = document(verb);
    json["mode"] = mode_name(mode);
    print(json);
  } else {
    fmt::print("{}\n", mode_name(mode));
  }
}

// An arm that moves by itself says so, and one that is a host's.
std::string mode_shown(std::uint8_t mode, std::uint8_t flags) {
  constexpr unsigned kMovesItself = 1U << 5U, kHostRenders = 1U << 6U;  // of Status and DeviceState
  return mode_name(mode) + ((flags & kMovesItself) != 0 ? ",moves_by_itself" : "") +
         ((flags & kHostRenders) != 0 ? ",host_renders" : "");
}

const ParamRow& param_named(const std::string& name) {
  const ParamRow* row = find_param(std::string_view(name));
  if (row == nullptr) {
    throw Error(ExitCode::kUsage, "unknown-parameter", "there is no parameter '" + name + "'",
                "`thimble param list` names them");
  }
  return *row;
}

const char* access_name(const ParamRow& row) {
  return row.access == firmware::Access::kAlways ? "always" : "at rest";
}

Json to_json(const ParamRow& row, double value) {
  Json json;
  json["name"] = row.name;
  json["value"] = row.type == ParamType::kUnsigned ? Json(static_cast<std::uint64_t>(value))
                                                   : Json(tidy(static_cast<float>(value)));
  json["unit"] = row.unit;
  json["default"] = tidy(row.initial);
  json["min"] = tidy(row.min);
  json["max"] = tidy(row.max);
  json["writable"] = access_name(row);
  json["text"] = row.text;
  return json;
}

std::string shown(const ParamRow& row, double value) {
  return row.type == ParamType::kUnsigned ? fmt::format("{}", static_cast<std::uint64_t>(value))
                                          : fmt::format("{}", static_cast<float>(value));
}

// The bins that are not empty: " below_1us 39990, below_10us 10".
std::string histogram(const link::Lateness& late) {
  std::string text;
  link::visit_fields(late, [&text](auto, const char* name, const auto& value, auto&&...) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, std::uint32_t>) {
      if (value != 0) text += fmt::format("{} {} {}", text.empty() ? "" : ",", name, value);
    }
  });
  return text.empty() ? " none" : text;
}

Json limits_json() {
  Json json = Json::object();
  for (const LimitRow& row : scene_limits()) json[row.key] = row.value;
  return json;
}

Json fault_json(const firmware::FaultRow& row) {
  return {{"number", static_cast<int>(row.fault)},
          {"name", row.name},
          {"emergency_code", row.emergency_code},
          {"cause", row.cause},
          {"remedy", row.remedy}};
}

const firmware::FaultRow* fault_row(std::uint8_t number) {
  return firmware::find_fault(static_cast<firmware::Fault>(number));
}

// Shows telemetry: every frame as a JSON line, or a row a force frame with the pose before it.
class TelemetryPrinter {
 public:
  TelemetryPrinter(bool json, std::uint8_t node) : json_(json), node_(node) {
    if (!json_) fmt::print("arm x_m y_m z_m force_x_N force_y_N force_z_N contacts mode\n");
  }

  // True when it printed a row.
  bool operator()(const CanFrame& frame) {
    bool printed = false;
    link::visit_messages([&](auto message) {
      using Message = decltype(message);
      if constexpr (Message::kIsFrame) {
        if (!link::from_frame(frame, node_, message)) return;
        if (json_) {
          Json json;
          json["schema"] = kJsonSchema;
          json["message"] = Message::kName;
          json["node"] = node_;
          json.update(host::to_json(message));
          print_line(json);
          printed = true;
        } else {
          printed = show(message) || printed;
        }
      }
    });
    return printed;
  }

 private:
  bool show(const link::Pose& pose) {
    pose_[pose.arm] = pose;
    return false;
  }
  bool show(const link::Force& force) {
    const auto arm = static_cast<std::uint8_t>(force.arm_contacts >> 6U);
    const link::Pose& pose = pose_[arm];
    fmt::print("{} {:.5f} {:.5f} {:.5f} {:.3f} {:.3f} {:.3f} {} {}\n", arm, pose.x_m, pose.y_m, pose.z_m,
               force.x_N, force.y_N, force.z_N, force.arm_contacts & 3U, mode_);
    std::fflush(stdout);
    return true;
  }
  bool show(const link::Status& status) {
    mode_ = mode_shown(status.mode, status.flags);
    return false;
  }
  bool show(const link::Emergency& emergency) {
    const firmware::FaultRow* row = fault_row(emergency.fault);
    fmt::print(stderr, "fault {}: {}\n", emergency.fault, row == nullptr ? "cleared or unknown" : row->cause);
    return false;
  }
  template <class Message>
  bool show(const Message&) {  // of the scene: with --json only
    return false;
  }
  bool show(const link::EmergencyStop&) {
    fmt::print(stderr, "emergency stop on the link\n");
    return false;
  }

  bool json_;
  std::uint8_t node_;
  std::map<std::uint8_t, link::Pose> pose_;
  std::string mode_ = mode_name(0);
};

// Draws a MonitorScreen over itself ten times a second.
class ScreenPrinter {
 public:
  explicit ScreenPrinter(Device& device)
      : screen_(
            fmt::format("{} on board {}", device.text(link::kDidArmName), device.text(link::kDidBoardName)),
            device.info().node, terminal_has_blocks()) {}

  // True when it drew.
  bool operator()(const CanFrame& frame) {
    screen_.take(frame);
    if (now_us() - drawn_us_ < kRedraw_us) return false;
    drawn_us_ = now_us();
    screen_.step();
    winsize window{};
    constexpr unsigned kColumns = 80;  // of a terminal that does not tell
    const bool told = ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col != 0;
    std::string text = screen_.text(told ? window.ws_col : kColumns);
    // Up to where the last picture began, and each line's old rest away.
    std::string picture = lines_ == 0 ? "" : fmt::format("\x1b[{}A", lines_);
    lines_ = static_cast<std::size_t>(std::ranges::count(text, '\n'));
    for (const char c : text) picture += c == '\n' ? "\x1b[K\n" : std::string(1, c);
    fmt::print("{}\x1b[J", picture);
    std::fflush(stdout);
    return true;
  }

 private:
  static bool terminal_has_blocks() {
    std::setlocale(LC_CTYPE, "");  // or it would be "C", whatever the user has
    return std::string_view(nl_langinfo(CODESET)) == "UTF-8";
  }

  static constexpr Micros kRedraw_us = 100'000;
  MonitorScreen screen_;
  Micros drawn_us_ = 0;
  std::size_t lines_ = 0;
};

}  // namespace

void list(const Common& common) {
  const std::vector<DeviceEntry> devices = discover();
  if (common.json) {
    Json json = document("list");
    json["devices"] = Json::array();
    for (const DeviceEntry& device : devices) {
      json["devices"].push_back(
          {{"name", device.name}, {"kind", device.kind}, {"arm", device.arm}, {"uris", device.uris}});
    }
    print(json);
    return;
  }
  for (const DeviceEntry& device : devices) {
    fmt::print("{}  {}{}{}", device.name, device.kind, device.arm.empty() ? "" : "  ", device.arm);
    for (const std::string& uri : device.uris) fmt::print("  {}", uri);
    fmt::print("\n");
  }
  if (devices.empty()) fmt::print(stderr, "no device: connect a controller, or start thimble-sim\n");
}

void info(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);
  const link::DeviceState state = device.state();
  const link::Lateness late = device.lateness();
  const link::HostOrders orders = device.orders();
  const std::string board = device.text(link::kDidBoardName);
  const std::string reset_reason = device.text(link::kDidResetReason);
  const std::string version = device.text(link::kDidFirmwareVersion);
  const std::string serial = device.text(link::kDidSerialNumber);
  const std::string arm = device.text(link::kDidArmName);
  const std::string scene = device.text(link::kDidSceneName);
  if (common.json) {
    Json json = document("info");
    json["firmware"] = version;
    json["board"] = board;
    json["reset_reason"] = reset_reason;
    json["serial"] = serial;
    json["arm"] = arm;
    json["scene"] = scene;
    json["link"] = host::to_json(device.info());
    json["state"] = host::to_json(state);
    json["state"]["mode"] = mode_name(state.mode);
    json["lateness"] = host::to_json(late);
    json["host_orders"] = host::to_json(orders);
    json["limits"] = limits_json();
    print(json);
    return;
  }
  fmt::print("firmware   {} (protocol {}, scene image {})\n", version, device.info().protocol,
             device.info().image);
  fmt::print("board      {}, last start: {}\n", board, reset_reason.empty() ? "not known why" : reset_reason);
  fmt::print("serial     {}\n", serial);
  fmt::print("arm        {}, {} arm(s), node {}, {}\n", arm, device.info().arms, device.info().node,
             device.info().frame_bytes == link::kFdDataBytes ? "CAN FD" : "classic CAN");
  fmt::print("mode       {}\n", mode_shown(state.mode, state.flags));
  if (const firmware::FaultRow* row = fault_row(state.fault)) {
    fmt::print("fault      {} {}: {}\n", state.fault, row->name, row->cause);
  }
  if (state.scene_bytes == 0) {
    fmt::print("scene      none\n");
  } else {
    fmt::print("scene      {} ({} bytes, CRC {:08x}, activation {})\n", scene, state.scene_bytes,
               state.scene_crc, state.scene_sequence);
  }
  fmt::print("loop       {:.0f} Hz, tick {}, worst tick {:.1f} us, {} overruns\n", state.tick_rate_Hz,
             state.tick, state.worst_tick_s * 1e6F, state.overruns);
  fmt::print("late       worst {:.1f} us; ticks:{}\n", late.worst_s * 1e6F, histogram(late));
  fmt::print("contact    {} ticks, peak {:.3f} N, mean {:.3f} N\n", state.contact_ticks, state.peak_force_N,
             state.mean_force_N);
  if (orders.taken + orders.old + orders.wrong != 0) {
    fmt::print("orders     {} forces taken from a host, {} old, {} wrong; {} times none in time\n",
               orders.taken, orders.old, orders.wrong, orders.expired);
  }
  fmt::print("limits     {} objects, {} triangles, {} bytes a scene; {:g} N/m, {:g} Ns/m, friction {:g}\n",
             control::kMaxObjects, control::kMaxTriangles, control::kMaxImageBytes,
             control::kMaxStiffness_N_m, control::kMaxDamping_N_s_m, control::kMaxFriction);
  for (const LimitRow& row : scene_limits()) {
    fmt::print("  {:<24} {:>10}  {}\n", row.key, row.value.dump(), row.of);
  }
}

void upload(const Common& common, const Remote& remote, const UploadChoice& choice) {
  const ImageFile file = load_image(choice.file);
  Device device = open_device(common, remote);
  ProgressPrinter printer;
  std::function<void(const UploadProgress&)> progress;
  if (!common.json) progress = std::ref(printer);
  const UploadResult result = device.upload(file.image, {.crc = file.crc, .verify = choice.verify}, progress);
  const std::string scene = device.text(link::kDidSceneName);
  if (common.json) {
    Json json = document("upload");
    json["scene"] = scene;
    json["bytes"] = result.bytes;
    json["crc"] = result.crc;
    json["resumed_from"] = result.resumed_from;
    json["retried_blocks"] = result.retried_blocks;
    json["seconds"] = result.seconds;
    json["rate_bytes_s"] = result.bytes_per_s;
    json["verified"] = choice.verify;
    print(json);
    return;
  }
  fmt::print("{}: {} bytes in {:.2f} s, {:.0f} kB/s{}{}\n", scene, result.bytes, result.seconds,
             result.bytes_per_s / 1e3,
             result.resumed_from == 0 ? "" : fmt::format(", resumed at {}", result.resumed_from),
             choice.verify ? ", verified" : "");
}

void arm(const Common& common, const Remote& remote) {
  open_device(common, remote).arm();
  done(common, "arm", kModeArmed);
}

void disarm(const Common& common, const Remote& remote) {
  Device device = open_remote(remote);  // first things first
  device.disarm();
  done(common, "disarm", device.state().mode);
}

void restart(const Common& common, const Remote& remote) {
  open_device(common, remote).restart();
  if (common.json) {
    Json json = document("restart");
    json["restarting"] = true;
    print(json);
  } else {
    fmt::print("restarting\n");
  }
}

void home(const Common& common, const Remote& remote, double wait_s) {
  open_device(common, remote).home(static_cast<Micros>(wait_s * 1e6));
  done(common, "home", kModeReady);
}

void monitor(const Common& common, const Remote& remote, const MonitorChoice& choice) {
  Device device = open_device(common, remote);
  std::function<bool(const CanFrame&)> printer;
  if (!common.json && !choice.rows && isatty(STDOUT_FILENO) != 0) {
    printer = ScreenPrinter(device);
  } else {
    printer = TelemetryPrinter(common.json, device.info().node);
  }
  heed_interrupts();

  const Micros start_us = now_us();
  const Micros end_us =
      choice.seconds > 0 ? start_us + static_cast<Micros>(choice.seconds * 1e6) : ~Micros{0};
  Micros heard_us = start_us;
  Micros fed_us = 0;
  std::uint64_t rows = 0;
  while (interrupted == 0 && now_us() < end_us && (choice.count == 0 || rows < choice.count)) {
    if (choice.keep_alive && now_us() - fed_us >= kKeepAlive_us) {
      device.keep_alive();
      fed_us = now_us();
    }
    const std::optional<CanFrame> frame = device.telemetry(std::min(end_us, now_us() + kKeepAlive_us));
    if (frame) {
      heard_us = now_us();
      if (printer(*frame)) ++rows;
      if (!std::cout || std::ferror(stdout) != 0) return;  // whoever read us has gone
    } else if (now_us() - heard_us > kSilence_us) {
      throw Error(ExitCode::kLinkLost, "no-telemetry", "the device has been silent for 3 s",
                  "check that it still runs");
    }
  }
}

void param_list(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  Json json = document("param");
  json["params"] = Json::array();
  for (const ParamRow& row : kParamTable) {
    const double value = device.read_param(row);
    if (common.json) {
      json["params"].push_back(to_json(row, value));
    } else {
      fmt::print("{:<22} {:>10} {:<6} {} to {}, {}: {}\n", row.name, shown(row, value), row.unit, row.min,
                 row.max, access_name(row), row.text);
    }
  }
  if (common.json) print(json);
}

void param_get(const Common& common, const Remote& remote, const std::string& name) {
  const ParamRow& row = param_named(name);
  const double value = open_device(common, remote).read_param(row);
  if (common.json) {
    Json json = document("param");
    json.update(to_json(row, value));
    print(json);
  } else {
    fmt::print("{}\n", shown(row, value));
  }
}

void param_set(const Common& common, const Remote& remote, const std::string& name,
               const std::string& value) {
  const ParamRow& row = param_named(name);
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = row.type == ParamType::kFloat || std::trunc(number) == number;
  if (error != std::errc() || end != value.data() + value.size() || !whole ||
      !(number >= static_cast<double>(row.min)) || !(number <= static_cast<double>(row.max))) {
    throw Error(
        ExitCode::kUsage, "bad-value",
        fmt::format("'{}' is not a value of {}: a {} from {} to {} {}", value, name,
                    row.type == ParamType::kFloat ? "number" : "whole number", row.min, row.max, row.unit),
        "choose a value in that range");
  }
  Device device = open_device(common, remote);
  device.write_param(row, number);
  const double now = device.read_param(row);
  if (common.json) {
    Json json = document("param");
    json.update(to_json(row, now));
    print(json);
  } else {
    fmt::print("{}\n", shown(row, now));
  }
}

void param_save(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  device.save_params();
  if (common.json) {
    Json json = document("param");
    json["saved"] = true;
    print(json);
  } else {
    fmt::print("saved\n");
  }
}

void fault_list(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  const std::vector<std::uint8_t> numbers = device.faults();
  const std::uint8_t latched = device.state().fault;
  Json json = document("fault");
  json["latched"] = latched;
  json["faults"] = Json::array();
  for (const std::uint8_t number : numbers) {
    const firmware::FaultRow* row = fault_row(number);
    const std::vector<link::FreezeFrame> frames = device.freeze_frames(number);
    if (common.json) {
      Json entry = row == nullptr ? Json{{"number", number}} : fault_json(*row);
      entry["latched"] = number == latched;
      entry["freeze_frames"] = Json::array();
      for (const link::FreezeFrame& frame : frames) entry["freeze_frames"].push_back(host::to_json(frame));
      json["faults"].push_back(entry);
      continue;
    }
    fmt::print("{} {}{}: {}\n  remedy: {}\n", number, row == nullptr ? "unknown" : row->name,
               number == latched ? " (latched)" : "", row == nullptr ? "" : row->cause,
               row == nullptr ? "" : row->remedy);
    if (!frames.empty()) {
      const link::FreezeFrame& last = frames.back();
      fmt::print(
          "  {} ticks kept; the last: tick {}, tip {:.5f} {:.5f} {:.5f} m, force {:.3f} {:.3f} {:.3f} N, "
          "{}\n",
          frames.size(), last.tick, last.tip_x_m, last.tip_y_m, last.tip_z_m, last.force_x_N, last.force_y_N,
          last.force_z_N, mode_name(last.mode));
    }
  }
  if (common.json) {
    print(json);
  } else if (numbers.empty()) {
    fmt::print(stderr, "no fault since the last clear\n");
  }
}

void fault_clear(const Common& common, const Remote& remote) {
  Device device = open_device(common, remote);
  device.clear_faults();
  done(common, "fault", device.state().mode);
}

void fault_explain(const Common& common, const std::string& which) {
  for (const firmware::FaultRow& row : firmware::kFaultTable) {
    if (which != row.name && which != std::to_string(static_cast<int>(row.fault))) continue;
    if (common.json) {
      Json json = document("fault");
      json.update(fault_json(row));
      print(json);
    } else {
      fmt::print("{} {} (emergency code 0x{:04X})\n  cause: {}\n  remedy: {}\n", static_cast<int>(row.fault),
                 row.name, row.emergency_code, row.cause, row.remedy);
    }
    return;
  }
  throw Error(ExitCode::kUsage, "unknown-fault", "there is no fault '" + which + "'",
              fmt::format("give a number from 1 to {}, or a name",
                          static_cast<int>(std::end(firmware::kFaultTable)[-1].fault)));
}

}  // namespace thimble::host
