// The start of the drives on CAN: buses, search, and what is missing. drive_set.cpp has the tick.
#include <linux/can/raw.h>
#include <sys/socket.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <system_error>
#include <utility>

#include "board/linux/clock.h"
#include "board/linux/drive_set.h"
#include "board/posix/can_interfaces.h"

namespace thimble::board {
namespace {

using drives::DriveConfig;
using drives::DriveFault;
using drives::DriveState;
using drives::State;

constexpr float kMostSilence_s = 2;  // of a drive that may still be starting

drives::OpenedBus open_interface(const std::string& interface, bool fd, drives::BusRate& rate, bool& real) {
  drives::OpenedBus opened = drives::open_can_bus(interface, {}, fd);
  if (!opened.socket.is_open()) return opened;
  try {
    for (const CanInterface& one : read_can_interfaces()) {
      if (one.name != interface || !one.controller || one.controller->bit_rate == 0) continue;
      real = true;
      rate.nominal_bits_s = static_cast<float>(one.controller->bit_rate);
      if (one.controller->data_bit_rate != 0)
        rate.data_bits_s = static_cast<float>(one.controller->data_bit_rate);
    }
  } catch (const std::system_error&) {  // the kernel does not tell: the usual rates are assumed
  }
  return opened;
}

std::string place_of(std::size_t arm, std::size_t joint, const DriveWiring& wiring) {
  return "arm " + std::to_string(arm) + " joint " + std::to_string(joint + 1) + " (" +
         name_of(wiring.config.kind) + " " + std::to_string(wiring.config.id) + " on " + wiring.interface +
         ")";
}

const char* watchdog_text(drives::WatchdogProof proof) {
  switch (proof) {
    case drives::WatchdogProof::kReadBack:
      return "read back";
    case drives::WatchdogProof::kBySilence:
      return "let run out once";
    case drives::WatchdogProof::kByHand:
      return "tried by hand";
  }
  return "";
}

struct Remedy {
  DriveFault fault;
  const char* text;
};
constexpr Remedy kRemedies[] = {
    {DriveFault::kConfigDiffers, "write the value to the drive and save it, or correct /arms/N/drives"},
    {DriveFault::kConfigSilent, "correct the item's name or number in /arms/N/drives/N/configuration"},
    {DriveFault::kWatchdogUnproven,
     "switch the drive's watchdog on; one that cannot be asked: try it by hand, then set watchdog_proven"},
    {DriveFault::kVersion, "correct the kind, or update the drive's firmware"},
    {DriveFault::kStartPose, "move the joint into its limits, or power the drive again"},
};
const char* drive_remedy(DriveFault fault) {
  for (const Remedy& one : kRemedies)
    if (one.fault == fault) return one.text;
  return "see docs/drives.md, then start again";
}

}  // namespace

DriveHost DriveHost::of_this_machine() {
  return {open_interface, [] { return monotonic_ns() / 1000; },
          [](std::uint64_t time_us) {
            const timespec until{static_cast<time_t>(time_us / 1'000'000),
                                 static_cast<long>(time_us % 1'000'000 * 1000)};
            (void)clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
          }};
}

DriveSet::DriveSet(std::span<const ArmWiring> arms, double rate_Hz, const DriveHost& host)
    : arms_(arms.begin(), arms.end()), period_s_(static_cast<float>(1.0 / rate_Hz)) {
  sort_into_buses();
  for (Bus& bus : buses_) open(bus, rate_Hz, host);
  if (!empty()) search(rate_Hz, host);
  report_missing();
}

void DriveSet::sort_into_buses() {
  for (std::size_t i = 0; i < arms_.size(); ++i)
    for (std::size_t j = 0; j < kArmJoints; ++j) {
      const auto& wiring = arms_[i].drives[j];
      if (!wiring) continue;
      driven_[i] = true;
      auto bus = std::ranges::find(buses_, wiring->interface, &Bus::interface);
      if (bus == buses_.end()) {
        bus = buses_.emplace(buses_.end());
        bus->interface = wiring->interface;
        bus->items.reserve(drives::kMostDrives);  // the configurations point into it
      }
      auto& items = bus->items.emplace_back();
      items.reserve(wiring->items.size());
      for (const DriveWiring::Item& item : wiring->items)
        items.push_back({item.name.c_str(), item.number, item.integer, item.value});
      bus->configs.push_back(wiring->config);
      bus->configs.back().items = items;

      const kinematics::AxisData& axis = arms_[i].arm.axis[j];
      auto joint = std::make_unique<Joint>();
      joint->arm = i;
      joint->joint = j;
      joint->direction = wiring->direction;
      joint->torque_per_A = axis.motor.torque_constant_N_m_A;
      // The drive's position is that of its shaft, as its torque; the axis's counts may have another sign and ratio.
      joint->counts_per_rad = static_cast<double>(axis.encoder_sign * axis.drive_sign) *
                              static_cast<double>(axis.counts_per_turn) *
                              static_cast<double>(axis.encoder_turns) /
                              (static_cast<double>(axis.drive_turns) * 2 * std::numbers::pi);
      joint->mask = UINT32_MAX >> (32U - axis.counter_bits);
      joint->encoder = !has_own_encoder(arms_[i], j);
      joint->text = place_of(i, j, *wiring);
      bus->joints.push_back(std::move(joint));
    }
}

void DriveSet::open(Bus& bus, double rate_Hz, const DriveHost& host) {
  const bool fd = std::ranges::any_of(bus.configs, [](const DriveConfig& one) { return is_fd(one.kind); });
  drives::BusRate rate;
  bool real = false;
  drives::OpenedBus opened = host.open(bus.interface, fd, rate, real);
  std::vector<drives::Exchange> exchanges;
  exchanges.reserve(bus.configs.size());
  for (DriveConfig& config : bus.configs) {
    exchanges.push_back(exchange_of(config));
    // What is sooner than the wire allows answers the tick before.
    if (real && config.reply_period_s == 0)
      config.least_reply_us = exchange_time_us(exchanges.back(), drives::Stuffing::kNone, rate);
  }
  const drives::BusLoad load = bus_load(bus.interface, exchanges, static_cast<float>(rate_Hz), rate);
  bus.load = load.sentence();
  if (!load.fits) {
    const std::size_t remedy = bus.load.find(": ");
    missing_.push_back({"drive_bus_overloaded", bus.load.substr(0, remedy),
                        remedy == std::string::npos ? "" : bus.load.substr(remedy + 2), EINVAL});
  }
  if (!opened.socket.is_open()) {
    missing_.push_back({"no_drive_bus", opened.trouble,
                        "set the interface up (docs/drives.md), or correct /arms/N/drives", ENODEV});
  } else {
    drives::BusRate ignored;
    bool also_ignored = false;
    drives::OpenedBus second = host.open(bus.interface, fd, ignored, also_ignored);
    if (second.socket.is_open()) {  // sends only
      (void)setsockopt(second.socket.get(), SOL_CAN_RAW, CAN_RAW_FILTER, nullptr, 0);
      stopper_.add(std::move(second.socket), bus.configs);
    }
  }
  bus.bus = std::make_unique<drives::DriveBus>(std::move(opened.socket), bus.configs, period_s_);
}

// Cycles until every drive is idle or has a fault, or has not been heard of for too long.
void DriveSet::search(double rate_Hz, const DriveHost& host) {
  const auto period_us = static_cast<std::uint64_t>(std::lround(1e6 / rate_Hz));
  std::uint64_t begin_us = host.now_us();
  const std::uint64_t start_us = begin_us;
  for (bool searching = true; searching; begin_us += period_us) {
    host.sleep_until(begin_us);
    for (Bus& bus : buses_) bus.bus->begin_cycle(host.now_us(), {}, {});
    host.sleep_until(begin_us + period_us * 9 / 10);
    searching = false;
    const auto time_s = static_cast<float>(begin_us - start_us) * 1e-6F;
    for (Bus& bus : buses_) {
      bus.states = bus.bus->end_cycle(host.now_us());
      for (const DriveState& one : bus.states)
        searching = searching || (one.state == State::kFound && time_s < kMostSearch_s) ||
                    (one.state == State::kUnknown && bus.bus->descriptor() >= 0 && time_s < kMostSilence_s);
    }
  }
  for (Bus& bus : buses_) {
    if (bus.bus->descriptor() < 0) continue;
    const std::vector<can_filter> filters = bus.bus->reply_filters();
    (void)setsockopt(bus.bus->descriptor(), SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(),
                     static_cast<socklen_t>(filters.size() * sizeof(can_filter)));
  }
}

void DriveSet::report_missing() {
  for (const Bus& bus : buses_) {
    if (bus.bus->descriptor() < 0) continue;
    for (std::size_t k = 0; k < bus.states.size(); ++k) {
      const DriveState& state = bus.states[k];
      if (state.fault == DriveFault::kNone &&
          (state.state == State::kUnknown || state.state == State::kFound)) {
        missing_.push_back({"no_drive", bus.joints[k]->text + ": does not answer",
                            "check its power, its id, termination and bit rates", ENODEV});
      } else if (state.fault != DriveFault::kNone) {
        std::string what = bus.joints[k]->text + ": " + sentence_of(state.fault);
        if (state.wrong_item != nullptr) what.append(" (").append(state.wrong_item).append(")");
        missing_.push_back(
            {std::string("drive_") + name_of(state.fault), what, drive_remedy(state.fault), EINVAL});
      }
    }
    for (const drives::Stranger& one : bus.bus->strangers()) {
      std::array<char, 80> id{};
      std::snprintf(id.data(), id.size(),
                    ": a frame with the id 0x%X and %u bytes is of no drive of the list",
                    static_cast<unsigned>(one.id), unsigned{one.size});
      missing_.push_back({"strange_drive", bus.interface + id.data(),
                          "give each drive its own ids, and the bus to the drives alone", EINVAL});
    }
  }
}

std::vector<std::string> DriveSet::report() const {
  std::vector<std::string> lines;
  for (const Bus& bus : buses_) {
    lines.push_back(bus.load);
    for (std::size_t k = 0; k < bus.states.size(); ++k) {
      const DriveState& state = bus.states[k];
      if (state.state != State::kIdle) continue;  // missing() has it
      std::array<char, 120> text{};
      std::snprintf(text.data(), text.size(), ": off, watchdog %g ms %s, configuration as in the file (%08X)",
                    static_cast<double>(bus.configs[k].watchdog_s) * 1e3,
                    watchdog_text(drives::make_protocol(bus.configs[k])->proof()),
                    static_cast<unsigned>(state.config_hash));
      lines.push_back(bus.joints[k]->text + text.data());
    }
  }
  return lines;
}

}  // namespace thimble::board
