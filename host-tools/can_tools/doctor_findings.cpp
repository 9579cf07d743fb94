#include "host-tools/can_tools/doctor_findings.h"

#include <fmt/format.h>

#include <algorithm>

namespace thimble::host {
namespace {

// Frames that wait in an interface: the host's own are few, but others' (a second host, cangen) wait before them, and the 10 of a
// CAN driver are soon full. vcan has 1000.
constexpr std::uint32_t kQueueFrames = 1000;
constexpr std::uint32_t kRestart_ms = 100;
constexpr std::uint64_t kBoardPriority = 80;  // docs/board-linux.md's configuration

using Findings = std::vector<Finding>;

Finding fine(std::string name, std::string subject, std::string cause) {
  return {std::move(name), std::move(subject), FindingState::kOk, std::move(cause), "", ExitCode::kOk};
}
Finding warning(std::string name, std::string subject, std::string cause, std::string remedy) {
  return {std::move(name),  std::move(subject), FindingState::kWarning,
          std::move(cause), std::move(remedy),  ExitCode::kOk};
}
Finding failure(std::string name, std::string subject, std::string cause, std::string remedy, ExitCode code) {
  return {std::move(name),  std::move(subject), FindingState::kFailure,
          std::move(cause), std::move(remedy),  code};
}

std::string rate(std::uint32_t bits_per_s) {
  if (bits_per_s % 1000000 == 0) return fmt::format("{} Mbit/s", bits_per_s / 1000000);
  return fmt::format("{} kbit/s", bits_per_s / 1000.0);
}

// The bit rates that are set already, or docs/link.md's.
std::string how_to_bring_up(const CanInterface& interface, bool fd) {
  const CanController set = interface.controller.value_or(CanController{});
  std::string command = "sudo ip link set " + interface.name + " up";
  if (!interface.controller) return command;  // vcan has no bit rate
  command += fmt::format(" type can bitrate {}", set.bit_rate != 0 ? set.bit_rate : 500000);
  if (fd || interface.fd)
    command += fmt::format(" dbitrate {} fd on", set.data_bit_rate != 0 ? set.data_bit_rate : 2000000);
  return command + fmt::format(" restart-ms {}", kRestart_ms);
}

// A setting that a controller takes only while it is down.
std::string how_to_set(const std::string& interface, const std::string& setting) {
  return fmt::format(
      "sudo ip link set {0} down && sudo ip link set {0} type can {1} && sudo ip link set {0} up", interface,
      setting);
}

void judge_bus(const CanInterface& interface, const CanController& controller, Findings& findings) {
  const std::string counters =
      fmt::format("{} transmit and {} receive errors", controller.transmit_errors, controller.receive_errors);
  const std::string check =
      ": check that the device has power and the same bit rate, the wires, and the 120 ohm at both ends";
  const std::string look = "ip -details -statistics link show " + interface.name;
  switch (controller.state) {
    case BusState::kErrorActive:
      findings.push_back(fine("bus", interface.name, "error-active, " + counters));
      break;
    case BusState::kErrorWarning:
      findings.push_back(warning("bus", interface.name, "error-warning, " + counters + check, look));
      break;
    case BusState::kErrorPassive:
      findings.push_back(warning("bus", interface.name, "error-passive, " + counters + check, look));
      break;
    case BusState::kBusOff:
      findings.push_back(
          failure("bus-off", interface.name, interface.name + " left the bus after too many errors" + check,
                  "sudo ip link set " + interface.name + " type can restart", ExitCode::kLinkLost));
      break;
    case BusState::kStopped:
    case BusState::kSleeping:  // some drivers say so until the controller has met the bus (ctucanfd)
      findings.push_back(warning("bus", interface.name, "not on the bus yet, " + counters + check, look));
      break;
  }
}

void judge_controller(const CanInterface& interface, const CanController& controller, Findings& findings) {
  std::string rates = rate(controller.bit_rate);
  if (controller.sample_point != 0) rates += fmt::format(", sampled at {} %", controller.sample_point / 10.0);
  if (interface.fd && controller.data_bit_rate != 0) rates += ", FD data " + rate(controller.data_bit_rate);
  findings.push_back(fine("bit-rate", interface.name, rates));
  judge_bus(interface, controller, findings);
  if (controller.listen_only) {
    findings.push_back(failure("listen-only", interface.name,
                               interface.name + " only listens: no frame leaves it",
                               how_to_set(interface.name, "listen-only off"), ExitCode::kLinkLost));
  }
  if (controller.restart_ms == 0) {
    findings.push_back(warning("restart", interface.name,
                               "after bus off it stays off until somebody restarts it",
                               how_to_set(interface.name, fmt::format("restart-ms {}", kRestart_ms))));
  } else {
    findings.push_back(
        fine("restart", interface.name, fmt::format("{} ms after bus off", controller.restart_ms)));
  }
}

void judge_interface(const CanInterface& interface, const Wish& wish, Findings& findings) {
  const bool named = interface.name == wish.interface;
  const bool fd = named && wish.fd;
  if (!interface.up) {
    Finding down = warning(
        "interface-down", interface.name,
        interface.name + " is down" + (interface.controller ? "; it needs the bit rate of the bus" : ""),
        how_to_bring_up(interface, fd));
    if (named) {
      down.state = FindingState::kFailure;
      down.code = ExitCode::kLinkLost;
    }
    findings.push_back(std::move(down));
    return;  // the rest is set when it is brought up
  }
  findings.push_back(fine("interface", interface.name,
                          std::string(interface.controller ? "up" : "up, virtual") +
                              (interface.fd ? ", classic and FD frames" : ", classic frames")));
  if (fd && !interface.fd) {
    findings.push_back(failure(
        "classic-interface", interface.name,
        interface.name + " takes classic frames only: use can:" + interface.name +
            ", or let it take FD frames",
        interface.controller
            ? how_to_set(interface.name,
                         fmt::format("bitrate {} dbitrate 2000000 fd on", interface.controller->bit_rate))
            : fmt::format("sudo ip link set {0} down && sudo ip link set {0} mtu 72 up", interface.name),
        ExitCode::kUsage));
  }
  if (interface.controller) judge_controller(interface, *interface.controller, findings);
  const std::string frames = fmt::format("{} frames may wait", interface.queue_frames);
  if (interface.queue_frames >= kQueueFrames) {
    findings.push_back(fine("queue", interface.name, frames));
  } else {
    findings.push_back(warning(
        "queue", interface.name, frames + ": another program on it may fill that, and uploads then wait",
        fmt::format("sudo ip link set {} txqueuelen {}", interface.name, kQueueFrames)));
  }
}

std::string_view kind_name(DeviceKind kind) {
  switch (kind) {
    case DeviceKind::kSerial:
      return "serial-port";
    case DeviceKind::kGpio:
      return "gpio";
    case DeviceKind::kSpi:
      return "spi";
    case DeviceKind::kCounter:
      return "counter";
  }
  return "";
}

void judge_device(const DeviceFile& device, const Wish& wish, Findings& findings) {
  const bool named = device.path == wish.port;
  const std::string name(kind_name(device.kind));
  if (!device.exists) {
    findings.push_back(failure("no-device", device.path,
                               "there is no " + device.path + ": connect the controller",
                               "ls -l /dev/serial/by-id", ExitCode::kNotFound));
    return;
  }
  if (device.usable) {
    findings.push_back(fine(name, device.path, "may be read and written"));
    return;
  }
  Finding closed = warning("permission", device.path, "", "");
  if (device.group.empty()) {
    closed.cause = device.path + " is open to root only";
    closed.remedy = device.kind == DeviceKind::kSerial
                        ? fmt::format("sudo chgrp dialout {0} && sudo chmod g+rw {0}", device.path)
                        : "sudo apt install ./thimble-board_*.deb && sudo usermod -aG thimble \"$USER\"";
    if (device.kind != DeviceKind::kSerial)
      closed.cause += "; the udev rule of thimble-board gives it to the group thimble";
  } else if (device.member_by_now) {
    closed.cause =
        device.path + " is for the group " + device.group + ", which you joined after this session began";
    closed.remedy = "newgrp " + device.group;
  } else {
    closed.cause = device.path + " is for the group " + device.group + ", and you are not in it";
    closed.remedy = fmt::format("sudo usermod -aG {0} \"$USER\" && newgrp {0}", device.group);
  }
  if (named) {
    closed.state = FindingState::kFailure;
    closed.code = ExitCode::kPermission;
  }
  findings.push_back(std::move(closed));
}

// One line for /etc/security/limits.d.
std::string how_to_allow(const std::string& item, const std::string& value) {
  return fmt::format("echo \"$USER - {} {}\" | sudo tee -a /etc/security/limits.d/thimble.conf", item, value);
}

void judge_privileges(const Privileges& privileges, const Wish& wish, Findings& findings) {
  std::string priority = fmt::format("SCHED_FIFO up to {}", privileges.priority);
  if (privileges.priority == 0) priority = "no real-time priority";
  std::string memory = "no limit";
  if (privileges.locked_bytes) memory = fmt::format("{} kB may be locked", *privileges.locked_bytes / 1024);
  const bool enough = privileges.priority >= kBoardPriority;
  const std::string who = "; thimble-board started by hand wants ";
  const std::string login = ", from the next login on";
  if (wish.board && !enough) {
    findings.push_back(warning("rtprio", "", fmt::format("{}{}{}", priority, who, kBoardPriority) + login,
                               how_to_allow("rtprio", std::to_string(kBoardPriority))));
  } else {
    findings.push_back(fine("rtprio", "", priority + (enough ? "" : "; only thimble-board needs it")));
  }
  if (wish.board && privileges.locked_bytes) {
    findings.push_back(warning("memlock", "", memory + who + "all of its memory locked" + login,
                               how_to_allow("memlock", "unlimited")));
  } else {
    findings.push_back(
        fine("memlock", "", memory + (privileges.locked_bytes ? "; only thimble-board needs more" : "")));
  }
}

}  // namespace

std::vector<Finding> judge(const Facts& facts, const Wish& wish) {
  Findings findings;
  const bool any = wish.interface.empty() && wish.port.empty();
  bool seen = false;
  for (const CanInterface& interface : facts.interfaces) {
    if (!any && interface.name != wish.interface) continue;
    seen = true;
    judge_interface(interface, wish, findings);
  }
  if (!wish.interface.empty() && !seen) {
    findings.push_back(
        failure("no-interface", wish.interface,
                wish.interface + " is no CAN interface of this machine: connect it and load its driver",
                "ip link show type can", ExitCode::kNotFound));
  } else if (any && !seen) {
    findings.push_back(fine("interface", "", "no CAN interface; a device on USB needs none"));
  }
  if (seen && !facts.can_sockets) {
    findings.push_back(failure("no-socketcan", "", "the kernel has no CAN sockets",
                               "sudo modprobe -a can can-raw", ExitCode::kNotFound));
  }
  for (const DeviceFile& device : facts.devices) {
    if (any || device.path == wish.port) judge_device(device, wish, findings);
  }
  judge_privileges(facts.privileges, wish, findings);
  return findings;
}

std::string_view state_name(FindingState state) {
  switch (state) {
    case FindingState::kOk:
      return "ok";
    case FindingState::kWarning:
      return "warning";
    case FindingState::kFailure:
      return "failure";
  }
  return "";
}

}  // namespace thimble::host
