// Configurations that the emulated drives of board/sim/drives agree with, at 1 kHz.
#pragma once

#include <string>

#include "board/linux/drives/drive_config.h"

namespace thimble::test {

using board::drives::DriveConfig;
using board::drives::Kind;

constexpr float kPeriod_s = .001F;

constexpr Kind kKinds[] = {Kind::kMoteus,   Kind::kOdrive05, Kind::kOdrive06, Kind::kMiniCheetah,
                           Kind::kCubeMars, Kind::kDamiao,   Kind::kDamiaoFd};
inline std::string name_of_kind(Kind kind) {
  static const char* const kNames[] = {"moteus",   "odrive05", "odrive06", "mini_cheetah",
                                       "cubemars", "damiao",   "damiao_fd"};
  return kNames[static_cast<std::size_t>(kind)];
}

// A configuration that the emulated drive of the kind agrees with.
inline DriveConfig config_of(Kind kind, std::uint8_t id) {
  static const board::drives::ConfigItem kEndpoints[] = {{"axis0.config.enable_watchdog", 100, true, 1},
                                                         {"axis0.config.watchdog_timeout", 101, false, .015}};
  DriveConfig config;
  config.kind = kind;
  config.id = id;
  config.base_damping_N_m_s_rad = .005F;
  config.least_reply_us = 50;  // of 60 that the emulated one takes; its bus takes none
  if (is_mit(kind)) config.reply_id = static_cast<std::uint16_t>(id + 16);
  if (kind == Kind::kMoteus) config.moteus_kd = .25F;
  if (is_odrive(kind)) {
    config.torque_constant_N_m_A = .04F;
    config.reply_period_s = .001F;
    config.torque_lag_s = .001F;
  }
  if (kind == Kind::kOdrive06) config.items = kEndpoints;
  if (is_mit(kind)) config.ranges = board::drives::mit::ranges_of(12.5F, 30, 10);
  if (kind == Kind::kMiniCheetah || kind == Kind::kCubeMars) {
    config.watchdog_s = .025F;
    config.watchdog_proven = true;
  }
  config.torque_lag_s = is_odrive(kind) ? .001F : .0005F;
  return config;
}

}  // namespace thimble::test
