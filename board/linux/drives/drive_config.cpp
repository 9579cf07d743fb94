#include "board/linux/drives/drive_config.h"

#include <algorithm>
#include <cmath>

#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"

namespace thimble::board::drives {
namespace {

constexpr float kFewestTicks = 10, kMostTicks = 20;
constexpr float kRounding = 1.001F;
constexpr float kMitTimeout_s = .025F;  // motorcontrol's CAN_TIMEOUT

// The key that must differ, or nothing.
std::string_view same_replies(const DriveConfig& a, const DriveConfig& b) {
  if (is_mit(a.kind) && is_mit(b.kind) && a.reply_id == b.reply_id) return "reply_id";
  const bool same_family = (is_mit(a.kind) && is_mit(b.kind)) || (is_moteus(a.kind) && is_moteus(b.kind)) ||
                           (is_odrive(a.kind) && is_odrive(b.kind));
  return same_family && a.id == b.id ? "id" : "";
}

bool has_item(const DriveConfig& config, std::string_view end) {
  return std::ranges::any_of(
      config.items, [end](const ConfigItem& item) { return std::string_view(item.name).ends_with(end); });
}

// By its ticks and by what its kind can be given.
WrongDrive check_watchdog(const DriveConfig& config, float period_s) {
  const bool by_hand = config.kind == Kind::kMiniCheetah || config.kind == Kind::kCubeMars;
  const Capabilities can = capabilities_of(config);
  const auto outside = [&config](float least_s, float most_s) {
    return config.watchdog_s * kRounding < least_s || config.watchdog_s > most_s * kRounding;
  };
  WrongDrive wrong{"", "watchdog_ms", can.least_watchdog_s, can.most_watchdog_s};
  if (outside(wrong.least_s, wrong.most_s)) wrong.what = "the drive cannot be given such a watchdog";
  if (by_hand) return wrong;
  const float least_s = kFewestTicks * period_s, most_s = kMostTicks * period_s;
  if (outside(least_s, most_s)) wrong.what = "the drive's watchdog must be 10 to 20 ticks";
  wrong.least_s = std::max(wrong.least_s, least_s);
  wrong.most_s = std::min(wrong.most_s, most_s);
  return wrong;
}

WrongDrive check_drive(const DriveConfig& config, float period_s) {
  if (is_moteus(config.kind) && (config.id < moteus::kLowestId || config.id > moteus::kHighestId))
    return {"moteus ids are 1 to 127", "id"};
  if (is_odrive(config.kind) && config.id > odrive::kHighestNode)
    return {"ODrive nodes are 0 to 62; give a drive that has none an address", "id"};
  if (is_mit(config.kind) && (config.reply_id == 0 || config.reply_id > 0x7FF))
    return {"a reply id of 0 is every motor's default: give each motor its own", "reply_id"};
  if (is_mit(config.kind) && (config.id == 0 || config.reply_id == config.id))
    return {"a motor needs an id above 0 that is not its reply id", "id"};
  if (is_damiao(config.kind) && config.id > 15)
    return {"a Damiao drive answers with four bits of its id: use 1 to 15", "id"};
  if (const WrongDrive wrong = check_watchdog(config, period_s); !wrong.what.empty()) return wrong;
  if (is_moteus(config.kind) && config.base_damping_N_m_s_rad > 0 && config.moteus_kd <= 0)
    return {"damping in a moteus (damping_N_m_s_rad) needs its servo.pid_position.kd, above 0 N m s/turn",
            "kd_N_m_s_turn"};
  if (is_moteus(config.kind) && config.moteus_timeout_mode != 12 && config.moteus_timeout_mode != 15)
    return {"a moteus must brake when the host is silent: servo.timeout_mode 12 or 15", "timeout_mode"};
  if (config.kind == Kind::kOdrive06 &&
      (!has_item(config, "watchdog_timeout") || !has_item(config, "enable_watchdog")))
    return {
        "an ODrive 0.6 needs the endpoints of watchdog_timeout and enable_watchdog, from the file of its "
        "firmware",
        "configuration"};
  const std::size_t own = kind_items(config).count;
  if (own + config.items.size() > kMostItems) return {"too many configuration items", "configuration"};
  return {};
}

}  // namespace

Exchange exchange_of(const DriveConfig& config) noexcept {
  switch (config.kind) {
    case Kind::kMoteus:
      return config.short_frames ? Exchange::kMoteusMotion : Exchange::kMoteusAll;
    case Kind::kOdrive05:
    case Kind::kOdrive06:
      if (config.request_estimates) return Exchange::kOdriveRequested;
      return config.base_damping_N_m_s_rad > 0 ? Exchange::kOdriveDamped : Exchange::kOdriveCyclic;
    case Kind::kMiniCheetah:
      return Exchange::kMiniCheetah;
    case Kind::kCubeMars:
    case Kind::kDamiao:
      return Exchange::kEightBytes;
    case Kind::kDamiaoFd:
      return Exchange::kEightBytesFd;
  }
  return Exchange::kMoteusAll;
}

Capabilities capabilities_of(const DriveConfig& config) noexcept {
  switch (config.kind) {
    case Kind::kMoteus:
      return {0,
              config.moteus_kd > 0,
              config.moteus_kd > 0,
              true,
              .001F,
              32.767F,
              config.needed_home_state >= 2 ? AbsoluteKind::kOutput : AbsoluteKind::kRotorTurn};
    case Kind::kOdrive05:
    case Kind::kOdrive06:
      return {0, false, true, false, .001F, 1000, AbsoluteKind::kNone};
    case Kind::kMiniCheetah:
    case Kind::kCubeMars:
      return {config.ranges.torque.step(), true, true, false, kMitTimeout_s, kMitTimeout_s,
              AbsoluteKind::kRotorTurn};
    case Kind::kDamiao:
    case Kind::kDamiaoFd:
      return {config.ranges.torque.step(), true, true, false, mit::kTimeoutStep_s, 3600,
              AbsoluteKind::kOutputTurn};
  }
  return {};
}

KindItems kind_items(const DriveConfig& config) noexcept {
  KindItems out;
  const auto add = [&out](const ConfigItem& item) { out.items[out.count++] = item; };
  const auto damiao = [&](const char* name, mit::Register number, bool integer, double value) {
    add({name, static_cast<std::uint16_t>(number), integer, value});
  };
  if (is_moteus(config.kind)) {
    // Each command has its own watchdog; this one is for a frame without.
    add({"servo.default_timeout_s", 0, false, static_cast<double>(config.watchdog_s)});
    add({"servo.timeout_mode", 0, false, static_cast<double>(config.moteus_timeout_mode)});
    // An integrator would turn the damping into a spring.
    add({"servo.pid_position.ki", 0, false, 0});
    if (config.moteus_kd > 0) add({"servo.pid_position.kd", 0, false, static_cast<double>(config.moteus_kd)});
  } else if (is_damiao(config.kind)) {
    damiao("TIMEOUT", mit::Register::kTimeout, true,
           std::round(static_cast<double>(config.watchdog_s / mit::kTimeoutStep_s)));
    damiao("CTRL_MODE", mit::Register::kControlMode, true, 1);
    damiao("PMAX", mit::Register::kPositionRange, false, static_cast<double>(config.ranges.position.hi));
    damiao("VMAX", mit::Register::kVelocityRange, false, static_cast<double>(config.ranges.velocity.hi));
    damiao("TMAX", mit::Register::kTorqueRange, false, static_cast<double>(config.ranges.torque.hi));
  }
  return out;
}

WrongDrive find_wrong(std::span<const DriveConfig> drives, float period_s) noexcept {
  WrongDrive wrong;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    wrong = i < kMostDrives ? check_drive(drives[i], period_s) : WrongDrive{"a bus has at most eight drives"};
    wrong.drive = wrong.other = i;
    for (std::size_t j = 0; j < i && wrong.what.empty(); ++j) {
      wrong.key = same_replies(drives[i], drives[j]);
      if (wrong.key.empty()) continue;
      wrong.what = "two drives of one bus have the same id or reply id";
      wrong.other = j;
    }
    if (!wrong.what.empty()) return wrong;
  }
  return {};
}

std::string_view check_drives(std::span<const DriveConfig> drives, float period_s) noexcept {
  return find_wrong(drives, period_s).what;
}

}  // namespace thimble::board::drives
