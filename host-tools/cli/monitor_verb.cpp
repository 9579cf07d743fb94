// monitor: the telemetry of a device, as rows, as JSON lines or as a picture in the terminal.
#include <fmt/format.h>
#include <langinfo.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <clocale>
#include <cstdio>
#include <functional>
#include <iostream>
#include <map>
#include <utility>

#include "firmware/core/faults.h"
#include "host-tools/cli/interrupt.h"
#include "host-tools/cli/monitor_screen.h"
#include "host-tools/cli/open_remote.h"
#include "host-tools/cli/output.h"
#include "host-tools/cli/telemetry_json.h"
#include "host-tools/cli/verbs.h"
#include "host-tools/client/device.h"
#include "host-tools/client/flag_names.h"

namespace thimble::host {
namespace {

using link::CanFrame;
using link::Micros;

constexpr Micros kSilence_us = 3'000'000;  // without telemetry for this time the device counts as lost
constexpr Micros kKeepAlive_us = 200'000;

// The names of the solids that tips are inside of, asked for when the first frame tells of one.
class InsideNames {
 public:
  explicit InsideNames(Device& device) : device_(device) {}

  // Whether this is news: the last frame of this arm and object is more than a second old.
  bool is_new(const link::Inside& inside) {
    constexpr Micros kPast_us = 1'000'000;
    Micros& heard_us = heard_us_[{inside.arm, inside.object}];
    const bool news = heard_us == 0 || now_us() - heard_us > kPast_us;
    heard_us = now_us();
    if (news)
      for (const Device::Inside& solid : device_.inside()) names_[solid.object] = solid.name;
    return news;
  }
  [[nodiscard]] std::string of(std::uint8_t object) const {
    const auto name = names_.find(object);
    return name == names_.end() ? fmt::format("object {}", object) : name->second;
  }

 private:
  Device& device_;
  std::map<std::pair<std::uint8_t, std::uint8_t>, Micros> heard_us_;  // by arm and object
  std::map<unsigned, std::string> names_;
};

// Tells why an arm is no longer armed: asked for when a Status says so, because a Status has no room for it.
class Stops {
 public:
  explicit Stops(Device& device) : device_(device) {}

  std::optional<link::DeviceState> take(const link::Status& status) {
    const bool stopped = armed_ && status.mode != link::Mode::kArmed;
    armed_ = status.mode == link::Mode::kArmed;
    if (!stopped) return std::nullopt;
    return device_.state();
  }

 private:
  Device& device_;
  bool armed_ = false;
};

// Prints telemetry: every frame as a JSON line, or one row per force frame with the pose before it.
class TelemetryPrinter {
 public:
  TelemetryPrinter(bool json, Device& device)
      : json_(json), node_(device.info().node), names_(device), stops_(device) {
    if (!json_) say("arm x_m y_m z_m force_x_N force_y_N force_z_N contacts mode\n");
  }

  // True when it printed a row.
  bool operator()(const CanFrame& frame) {
    bool printed = false;
    link::visit_messages([&](auto message) {
      using Message = decltype(message);
      if constexpr (Message::kIsFrame) {
        if (!link::from_frame(frame, node_, message)) return;
        if (json_) {
          Json json = telemetry_json(node_, message);
          if constexpr (std::is_same_v<Message, link::Inside>) {
            names_.is_new(message);
            json["name"] = names_.of(message.object);
          }
          print_line(json);
          if constexpr (std::is_same_v<Message, link::Status>) {
            if (const auto state = stops_.take(message)) print_line(telemetry_json(node_, *state));
          }
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
    const link::Pose& pose = pose_[force.arm];
    say("{} {:.5f} {:.5f} {:.5f} {:.3f} {:.3f} {:.3f} {} {}\n", force.arm, pose.x_m, pose.y_m, pose.z_m,
        force.x_N, force.y_N, force.z_N, force.contacts, mode_);
    std::fflush(stdout);
    return true;
  }
  bool show(const link::Status& status) {
    mode_ = mode_shown(status.mode, status.flags);
    if (const auto state = stops_.take(status))
      say(stderr, "no longer armed: {}\n", description(state->stopped_by));
    return false;
  }
  bool show(const link::Emergency& emergency) {
    const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(emergency.fault));
    say(stderr, "fault {}: {}\n", emergency.fault, row == nullptr ? "cleared or unknown" : row->cause);
    return false;
  }
  bool show(const link::Inside& inside) {
    if (names_.is_new(inside))
      say(stderr, "the tip of arm {} is inside {}: move out\n", inside.arm, names_.of(inside.object));
    return false;
  }
  template <class Message>
  bool show(const Message&) {  // other messages about the scene: only with --json
    return false;
  }
  bool show(const link::EmergencyStop&) {
    say(stderr, "emergency stop on the link\n");
    return false;
  }

  bool json_;
  std::uint8_t node_;
  InsideNames names_;
  Stops stops_;
  std::map<std::uint8_t, link::Pose> pose_;
  std::string mode_ = "waiting";  // for the first Status
};

// Draws a MonitorScreen over itself ten times a second.
class ScreenPrinter {
 public:
  explicit ScreenPrinter(Device& device)
      : screen_(
            fmt::format("{} on board {}", device.text(link::kDidArmName), device.text(link::kDidBoardName)),
            device.info().node, terminal_has_blocks()),
        node_(device.info().node),
        names_(device),
        stops_(device) {}

  // True when it drew.
  bool operator()(const CanFrame& frame) {
    screen_.take(frame);
    link::Inside inside;
    if (link::from_frame(frame, node_, inside) && names_.is_new(inside))
      screen_.name(inside.object, names_.of(inside.object));
    link::Status status;
    if (link::from_frame(frame, node_, status)) {
      if (const auto state = stops_.take(status)) screen_.stopped(description(state->stopped_by));
    }
    if (now_us() - drawn_us_ < kRedraw_us) return false;
    drawn_us_ = now_us();
    screen_.step();
    winsize window{};
    constexpr unsigned kColumns = 80;  // if the terminal does not tell its width
    const bool told = ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col != 0;
    std::string text = screen_.text(told ? window.ws_col : kColumns);
    // Moves the cursor to the start of the last picture, and clears the rest of each line.
    std::string picture = lines_ == 0 ? "" : fmt::format("\x1b[{}A", lines_);
    lines_ = static_cast<std::size_t>(std::ranges::count(text, '\n'));
    for (const char c : text) picture += c == '\n' ? "\x1b[K\n" : std::string(1, c);
    fmt::print("{}\x1b[J", picture);
    std::fflush(stdout);
    return true;
  }

 private:
  static bool terminal_has_blocks() {
    std::setlocale(LC_CTYPE, "");  // without it the locale would be "C"
    return std::string_view(nl_langinfo(CODESET)) == "UTF-8";
  }

  static constexpr Micros kRedraw_us = 100'000;
  MonitorScreen screen_;
  std::uint8_t node_;
  InsideNames names_;
  Stops stops_;
  Micros drawn_us_ = 0;
  std::size_t lines_ = 0;
};

}  // namespace

void monitor(const Common& common, const Remote& remote, const MonitorChoice& choice) {
  Device device = open_device(common, remote);
  std::function<bool(const CanFrame&)> printer;
  if (!common.json && !choice.rows && isatty(STDOUT_FILENO) != 0) {
    printer = ScreenPrinter(device);
  } else {
    printer = TelemetryPrinter(common.json, device);
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
      if (!std::cout || std::ferror(stdout) != 0) return;  // the reader of the output has closed it
    } else if (now_us() - heard_us > kSilence_us) {
      throw Error(ExitCode::kLinkLost, "no-telemetry", "the device has been silent for 3 s",
                  "check that it still runs");
    }
  }
}

}  // namespace thimble::host
