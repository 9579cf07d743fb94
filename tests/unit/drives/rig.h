// A bus of drives with emulated drives at the other end of a socketpair, in simulated time: 1 kHz, replies within the tick.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "board/linux/drives/drive_bus.h"
#include "board/sim/drives/emulated_bus.h"
#include "board/sim/drives/emulated_mit.h"
#include "board/sim/drives/emulated_moteus.h"
#include "board/sim/drives/emulated_odrive.h"
#include "tests/support/drive_configs.h"

namespace thimble::test {

using board::Descriptor;
using board::drives::DriveBus;
using board::drives::DriveFault;
using board::drives::DriveState;
using board::drives::Limiter;
using board::drives::State;
using board::emulated::EmulatedBus;
using board::emulated::EmulatedDrive;
using board::emulated::EmulatedMit;
using board::emulated::EmulatedMoteus;
using board::emulated::EmulatedOdrive;

inline std::pair<Descriptor, Descriptor> socket_pair() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, static_cast<int*>(ends)) != 0)
    throw std::runtime_error("no socketpair");
  return {Descriptor(ends[0]), Descriptor(ends[1])};
}

inline std::unique_ptr<EmulatedDrive> emulated_of(const DriveConfig& config) {
  if (config.kind == Kind::kMoteus) {
    auto drive = std::make_unique<EmulatedMoteus>(config.id);
    drive->config["servo.default_timeout_s"] = .015;
    return drive;
  }
  if (is_odrive(config.kind)) {
    auto drive = std::make_unique<EmulatedOdrive>(config.id, config.kind == Kind::kOdrive06);
    if (config.request_estimates) drive->config.estimates_s = 0;
    return drive;
  }
  const auto flavour = config.kind == Kind::kMiniCheetah ? EmulatedMit::Flavour::kMiniCheetah
                       : config.kind == Kind::kCubeMars  ? EmulatedMit::Flavour::kCubeMars
                                                         : EmulatedMit::Flavour::kDamiao;
  auto drive = std::make_unique<EmulatedMit>(flavour, config.id, config.reply_id,
                                             static_cast<double>(config.ranges.velocity.hi),
                                             static_cast<double>(config.ranges.torque.hi));
  drive->takes_fd = config.kind == Kind::kDamiaoFd;
  return drive;
}

class DriveRig {
 public:
  explicit DriveRig(std::vector<DriveConfig> configs) : DriveRig(std::move(configs), socket_pair()) {}
  explicit DriveRig(Kind kind) : DriveRig(std::vector{config_of(kind, 1), config_of(kind, 2)}) {}

  void tick(unsigned ticks = 1) {
    for (unsigned i = 0; i < ticks; ++i) {
      bus.begin_cycle(now_us, torque_N_m, damping_N_m_s_rad);
      if (!emulation_stopped) emulated.run(now_us);
      (void)bus.collect(now_us);
      if (!emulation_stopped) emulated.run(now_us + 300);
      const auto out = bus.end_cycle(now_us + 300);
      states.assign(out.begin(), out.end());
      if (!emulation_stopped) emulated.run(now_us + 900);
      now_us += 1000;
    }
  }
  // The host is not there, the drives are.
  void pause(unsigned ms) {
    for (unsigned i = 0; i < ms; ++i) emulated.run(now_us += 1000);
  }
  [[nodiscard]] bool all(State state) const {
    return !states.empty() &&
           std::ranges::all_of(states, [state](const DriveState& one) { return one.state == state; });
  }
  [[nodiscard]] bool until_all(State state, unsigned most = 3000) {
    for (unsigned i = 0; i < most && !all(state); ++i) tick();
    return all(state);
  }
  // From power-on to Running.
  [[nodiscard]] testing::AssertionResult start() {
    if (!until_all(State::kIdle)) return testing::AssertionFailure() << "not idle: " << text();
    if (const auto why = bus.enable(); !why.empty()) return testing::AssertionFailure() << why;
    if (!until_all(State::kRunning)) return testing::AssertionFailure() << "not running: " << text();
    return testing::AssertionSuccess();
  }
  [[nodiscard]] std::string text() const {
    std::string out;
    for (const DriveState& one : states)
      out += std::string(name_of(one.state)) + ' ' + name_of(one.fault) + ' ' +
             (one.wrong_item != nullptr ? one.wrong_item : "") + "; ";
    return out;
  }
  template <class Drive = EmulatedDrive>
  [[nodiscard]] Drive& drive(std::size_t i) {
    return dynamic_cast<Drive&>(*drives_[i]);
  }
  // The first drive has dropped with this fault, and the others brake or are off.
  [[nodiscard]] testing::AssertionResult dropped(DriveFault fault) const {
    if (states[0].fault != fault) return testing::AssertionFailure() << text();
    for (const DriveState& one : states)
      if (one.state == State::kRunning || one.state == State::kEnabled)
        return testing::AssertionFailure() << text();
    return testing::AssertionSuccess();
  }

 private:
  DriveRig(std::vector<DriveConfig> configs, std::pair<Descriptor, Descriptor> ends)
      : torque_N_m(configs.size(), 0),
        damping_N_m_s_rad(configs.size(), 0),
        bus(std::move(ends.first), configs, kPeriod_s),
        emulated(std::move(ends.second)) {
    EXPECT_EQ(board::drives::check_drives(configs, kPeriod_s), "");
    for (const DriveConfig& config : configs) drives_.push_back(&emulated.add(emulated_of(config)));
  }

 public:
  std::vector<float> torque_N_m, damping_N_m_s_rad;
  DriveBus bus;
  EmulatedBus emulated;
  std::vector<DriveState> states;
  std::uint64_t now_us = 1'000'000;
  bool emulation_stopped = false;

 private:
  std::vector<EmulatedDrive*> drives_;
};

}  // namespace thimble::test
