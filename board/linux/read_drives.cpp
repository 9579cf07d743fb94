#include "board/linux/read_drives.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string_view>

#include "board/linux/drives/moteus.h"

namespace thimble::board {
namespace {

using drives::DriveConfig;
using drives::Kind;

constexpr std::array<std::string_view, 7> kKinds = {"moteus",   "odrive_0.5", "odrive_0.6", "mini_cheetah",
                                                    "cubemars", "damiao",     "damiao_fd"};

// The keys of every drive, and those of its kind.
std::vector<std::string_view> keys_of(Kind kind) {
  std::vector<std::string_view> keys = {"can",
                                        "kind",
                                        "id",
                                        "direction",
                                        "watchdog_ms",
                                        "peak_torque_N_m",
                                        "top_speed_rad_s",
                                        "damping_N_m_s_rad",
                                        "torque_lag_ms",
                                        "start_rad",
                                        "configuration"};
  const auto add = [&keys](std::initializer_list<std::string_view> more) { keys.insert(keys.end(), more); };
  if (is_moteus(kind)) add({"kd_N_m_s_turn", "timeout_mode", "short_frames", "home_state"});
  if (is_odrive(kind)) add({"current_limit_A", "estimates_ms"});
  if (kind == Kind::kOdrive05) add({"torque_constant_N_m_A"});
  if (is_mit(kind)) add({"reply_id", "ranges"});
  if (kind == Kind::kMiniCheetah || kind == Kind::kCubeMars) add({"watchdog_proven"});
  return keys;
}

float float_of(const JsonValue& value, std::string_view key, const Range& range) {
  return static_cast<float>(value.at(key).number(range));
}

void read_moteus(const JsonValue& value, DriveConfig& config) {
  config.moteus_kd = static_cast<float>(value.number_or("kd_N_m_s_turn", {0, 1000, "N m s/turn"}, 0));
  if (value.has("timeout_mode")) config.moteus_timeout_mode = value.at("timeout_mode").integer(12, 15);
  if (value.has("short_frames")) config.short_frames = value.at("short_frames").boolean();
  if (value.has("home_state"))
    config.needed_home_state = static_cast<std::uint8_t>(value.at("home_state").integer(0, 2));
}

void read_odrive(const JsonValue& value, DriveConfig& config) {
  config.current_limit_A = float_of(value, "current_limit_A", {0, 1000, "A", true});
  config.reply_period_s = static_cast<float>(value.number_or("estimates_ms", {0, 10, "ms"}, 0) * 1e-3);
  config.request_estimates = config.reply_period_s == 0;
  if (config.kind == Kind::kOdrive05)
    config.torque_constant_N_m_A = float_of(value, "torque_constant_N_m_A", {0, 100, "N m/A", true});
}

void read_mit(const JsonValue& value, DriveConfig& config) {
  config.reply_id = static_cast<std::uint16_t>(value.at("reply_id").integer(1, 0x7FF));
  const JsonValue ranges = value.at("ranges");
  ranges.object("the ranges", {"position_rad", "velocity_rad_s", "torque_N_m"});
  config.ranges = drives::mit::ranges_of(float_of(ranges, "position_rad", {0, 1000, "rad", true}),
                                         float_of(ranges, "velocity_rad_s", {0, 1000, "rad/s", true}),
                                         float_of(ranges, "torque_N_m", {0, 1000, "N m", true}));
  if (value.has("watchdog_proven")) config.watchdog_proven = value.at("watchdog_proven").boolean();
}

std::vector<DriveWiring::Item> read_items(const JsonValue& value) {
  std::vector<DriveWiring::Item> items;
  const std::size_t count = value.size(0, drives::kMostItems);
  items.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const JsonValue item = value.at(i);
    item.object("an item of a drive's configuration", {"name", "number", "integer", "value"});
    // With "conf get " and the end of the line a name must fit into one frame.
    items.push_back({item.at("name").text(drives::moteus::kMostText - 10), 0, false,
                     item.at("value").number({-1e9, 1e9})});
    if (item.has("number"))
      items.back().number = static_cast<std::uint16_t>(item.at("number").integer(0, 0xFFFF));
    if (item.has("integer")) items.back().integer = item.at("integer").boolean();
  }
  return items;
}

// With less the limits of the arm would ask for what the drive does not give, which is the fault current_mismatch.
void check_peak(const JsonValue& value, const DriveConfig& config, const kinematics::AxisData& axis) {
  const float peak_N_m = axis.motor.peak_current_A * axis.motor.torque_constant_N_m_A;
  if (config.peak_torque_N_m >= peak_N_m) return;
  value.at("peak_torque_N_m")
      .fail("bad-value",
            "is below the " + number(as_written(peak_N_m)) +
                " N m that the arm's motors give at peak current; fit a drive "
                "that gives them, or lower the motors' peak in the arm's model",
            "give a larger value");
}

DriveWiring read_drive(const JsonValue& value, const kinematics::AxisData* axis) {
  if (!value.raw().is_object()) value.wrong("null or an object (a drive)");
  DriveWiring wiring;
  DriveConfig& config = wiring.config;
  config.kind = static_cast<Kind>(value.at("kind").word(kKinds));
  const std::string what = "a drive of the kind \"" + std::string(name_of(config.kind)) + "\"";
  const std::vector<std::string_view> keys = keys_of(config.kind);
  value.object(what.c_str(), keys);
  wiring.interface = value.at("can").text(15);
  config.id = static_cast<std::uint8_t>(value.at("id").integer(0, 127));
  if (value.has("direction")) {
    wiring.direction = static_cast<float>(value.at("direction").integer(-1, 1));
    if (wiring.direction == 0) value.at("direction").wrong("1 or -1");
  }
  config.watchdog_s = static_cast<float>(value.at("watchdog_ms").number({1, 1000, "ms"}) * 1e-3);
  config.peak_torque_N_m = float_of(value, "peak_torque_N_m", {0, 1000, "N m", true});
  config.top_speed_rad_s = float_of(value, "top_speed_rad_s", {0, 10'000, "rad/s", true});
  config.base_damping_N_m_s_rad =
      static_cast<float>(value.number_or("damping_N_m_s_rad", {0, 100, "N m s/rad"}, 0));
  config.torque_lag_s = static_cast<float>(value.number_or("torque_lag_ms", {0, 100, "ms", true}, 1) * 1e-3);
  if (value.has("start_rad")) {
    const JsonValue start = value.at("start_rad");
    (void)start.size(2, 2);
    config.start_lo_rad = static_cast<float>(start.at(std::size_t{0}).number({-1e4, 1e4, "rad"}));
    config.start_hi_rad = static_cast<float>(start.at(std::size_t{1}).number({-1e4, 1e4, "rad"}));
    if (!(config.start_lo_rad < config.start_hi_rad)) start.wrong("two numbers, the lower one first");
  }
  if (is_moteus(config.kind)) read_moteus(value, config);
  if (is_odrive(config.kind)) read_odrive(value, config);
  if (is_mit(config.kind)) read_mit(value, config);
  if (value.has("configuration")) wiring.items = read_items(value.at("configuration"));
  if (axis != nullptr) check_peak(value, config, *axis);
  return wiring;
}

// The watchdog's time in the key's unit, without the digits that a float makes of it.
double in_ms(float time_s) { return std::round(static_cast<double>(time_s) * 1e6) * 1e-3; }

// places: the drives of the bus.
[[noreturn]] void fail_at(std::span<const JsonValue> places, const drives::WrongDrive& wrong,
                          const std::string& bus) {
  const JsonValue& drive = places[wrong.drive];
  const std::string what(wrong.what), key(wrong.key);
  if (key.empty()) drive.fail("bad-value", "does not fit the bus " + bus + ": " + what, "use another bus");
  if (!drive.has(key)) drive.fail("missing-key", "has no \"" + key + "\": " + what, "add \"" + key + "\"");
  const JsonValue value = drive.at(key);
  if (wrong.most_s > 0)
    value.wrong(describe(Range{in_ms(wrong.least_s), in_ms(wrong.most_s), "ms"}) + ": " + what);
  if (wrong.other != wrong.drive)
    value.fail("bad-value",
               "is " + value.raw().dump() + ", as is " + places[wrong.other].at(key).place() + ": " + what,
               "give each drive on " + bus + " an id of its own, in the drive and here");
  const std::string given = value.raw().is_array() ? "does not fit" : "is " + value.raw().dump();
  value.fail("bad-value", given + ": " + what, "correct it, in the drive too");
}

}  // namespace

const char* name_of(Kind kind) noexcept { return kKinds[static_cast<std::size_t>(kind)].data(); }

std::size_t one_for_each_axis(const JsonValue& value, const kinematics::ArmData* arm) {
  if (arm == nullptr) return value.size(1, kArmJoints);
  const auto axes = static_cast<std::size_t>(axes_of(arm->geometry));
  if (!value.raw().is_array() || value.raw().size() != axes)
    value.wrong("an array of " + std::to_string(axes) + " values, one for each axis of the arm \"" +
                std::string(kinematics::name_of(*arm)) + "\"");
  return axes;
}

DriveWirings read_drives(const JsonValue& value, const kinematics::ArmData* arm) {
  DriveWirings drives;
  const std::size_t axes = one_for_each_axis(value, arm);
  for (std::size_t j = 0; j < axes; ++j) {
    if (value.at(j).raw().is_null()) continue;
    if (arm != nullptr && !arm->geometry.driven[j])
      value.at(j).fail("bad-value", "is a drive, and the arm has no motor at this joint", "give null");
    drives[j] = read_drive(value.at(j), arm == nullptr ? nullptr : &arm->axis[j]);
  }
  return drives;
}

void check_drive_buses(const JsonValue& arms, std::span<const DriveWirings> wirings, double rate_Hz) {
  std::vector<std::string> checked;
  std::vector<std::vector<drives::ConfigItem>> items;
  for (const DriveWirings& some : wirings)
    for (const auto& first : some) {
      if (!first || std::ranges::find(checked, first->interface) != checked.end()) continue;
      checked.push_back(first->interface);
      std::vector<DriveConfig> bus;
      std::vector<JsonValue> places;
      items.clear();
      items.reserve(wirings.size() * kArmJoints);  // the configurations point into it
      for (std::size_t i = 0; i < wirings.size(); ++i)
        for (std::size_t j = 0; j < kArmJoints; ++j) {
          const auto& one = wirings[i][j];
          if (!one || one->interface != first->interface) continue;
          auto& own = items.emplace_back();
          own.reserve(one->items.size());
          for (const DriveWiring::Item& item : one->items)
            own.push_back({item.name.c_str(), item.number, item.integer, item.value});
          bus.push_back(one->config);
          bus.back().items = own;
          places.push_back(arms.at(i).at("drives").at(j));
        }
      const auto wrong = drives::find_wrong(bus, static_cast<float>(1.0 / rate_Hz));
      if (!wrong.what.empty()) fail_at(places, wrong, first->interface);
    }
}

}  // namespace thimble::board
