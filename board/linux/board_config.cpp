#include "board/linux/board_config.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "board/files/json_value.h"
#include "board/files/rotation.h"
#include "board/files/text_file.h"
#include "board/linux/check_uses.h"
#include "board/linux/read_drives.h"
#include "control/scene/limits.h"
#include "firmware/core/config.h"
#include "firmware/core/stop_timeout.h"
#include "kinematics/built_in_arms.h"

namespace thimble::board {

static_assert(kArmJoints == kinematics::kMaxJoints);

namespace {

constexpr double kMostMetres = 10.0;
// Two periods are the shortest time-out of the stop path: one tick must be allowed to be lost.
constexpr double kSlowest_Hz = 2e6 / firmware::kLongestStop_us;

Eigen::Vector3f vector_of(const JsonValue& value, double most) {
  return value.vector({-most, most}).cast<float>();
}

kinematics::BasePose read_base(const JsonValue& arm) {
  kinematics::BasePose base;
  if (arm.has("home_m")) base.home_m = vector_of(arm.at("home_m"), kMostMetres);
  if (arm.has("turn_deg") && arm.has("rotation_deg"))
    arm.at("turn_deg")
        .fail("senseless-key", "is the yaw of \"rotation_deg\", which is given too", "leave out one of them");
  Eigen::Vector3d rpy_deg = Eigen::Vector3d::Zero();
  if (arm.has("turn_deg")) rpy_deg.z() = arm.at("turn_deg").number({-180, 180});
  if (arm.has("rotation_deg")) rpy_deg = arm.at("rotation_deg").vector({-360, 360, "degrees"});
  base.rotation = rotation_of(rpy_deg).cast<float>();
  return base;
}

// {"line": NAME, "active": "high" | "low"}
GpioLine read_line(const JsonValue& value) {
  value.object("a line", {"line", "active"});
  return {value.at("line").text(), value.at("active").word({"high", "low"}) == 1, GpioBias::kAsIs};
}

// {"line": NAME, "closed": "high" | "low"}: the level of a closed contact. The pull resistor towards the
// other level makes an open wire read as open for either wiring.
GpioLine read_contact(const JsonValue& value) {
  value.object("a contact", {"line", "closed"});
  const bool closed_low = value.at("closed").word({"high", "low"}) == 1;
  return {value.at("line").text(), closed_low, closed_low ? GpioBias::kPullUp : GpioBias::kPullDown};
}

// Whether a value of the joint stands here; null: its drive does it, or there is nothing to do.
bool is_given(const JsonValue& value, bool needed) {
  if (!value.raw().is_null()) return true;
  if (needed)
    value.fail("bad-value", "is null, and the joint has no drive in /drives", "describe it, or its drive");
  return false;
}

// By which the wiring is judged; null while the store does not have it.
const kinematics::ArmData* known_arm(const ArmWiring& arm) {
  return arm.needs_stored.empty() ? &arm.arm : nullptr;
}

// Whether the joint's current must come from the converter.
bool needs_channel(const ArmWiring& arm, std::size_t joint) {
  return known_arm(arm) != nullptr && arm.arm.geometry.driven[joint] && !arm.drives[joint];
}

// The counter of the first joint that has one.
const std::string& first_counter(const EncoderConfig& encoders) {
  return std::ranges::find_if(encoders.counter, [](const CounterPlace& one) { return !one.device.empty(); })
      ->device;
}

EncoderConfig read_encoders(const JsonValue& value, const ArmWiring& arm) {
  EncoderConfig encoders;
  value.object("the encoders", {"read", "event", "joints"});
  encoders.kind =
      static_cast<EncoderConfig::Kind>(value.at("read").word({"counter", "counter_events", "gpio"}));
  if (encoders.kind == EncoderConfig::Kind::kCounterEvents) {
    constexpr std::array kEvents = {COUNTER_EVENT_CAPTURE, COUNTER_EVENT_INDEX,
                                    COUNTER_EVENT_CHANGE_OF_STATE};
    encoders.event = kEvents[value.at("event").word({"capture", "index", "change_of_state"})];
  } else if (value.has("event")) {
    value.at("event").fail("senseless-key", "has a meaning with \"read\": \"counter_events\" only",
                           "leave it out");
  }
  const JsonValue joints = value.at("joints");
  const std::size_t axes = one_for_each_axis(joints, known_arm(arm));
  bool any = false;
  for (std::size_t j = 0; j < axes; ++j) {
    const JsonValue joint = joints.at(j);
    if (!is_given(joint, !arm.drives[j])) continue;
    any = true;
    if (encoders.kind == EncoderConfig::Kind::kGpio) {
      joint.object("an encoder at two lines", {"line_a", "line_b"});
      encoders.lines[j] = {joint.at("line_a").text(), joint.at("line_b").text()};
    } else {
      joint.object("an encoder at a counter", {"counter", "count"});
      encoders.counter[j] = {joint.at("counter").text(),
                             static_cast<unsigned>(joint.at("count").integer(0, 255)),
                             arm.arm.axis[j].counter_bits};
      if (encoders.kind == EncoderConfig::Kind::kCounterEvents &&
          encoders.counter[j].device != first_counter(encoders))
        joint.at("counter").fail(
            "bad-value", "differs from the first joint's: one event latches the counts of one counter only",
            "give the same counter");
    }
  }
  if (!any)
    joints.fail("senseless-key", "names no encoder: every joint has that of its drive",
                "leave out the encoders");
  return encoders;
}

DacConfig read_dac(const JsonValue& value, const ArmWiring& arm) {
  DacConfig dac;
  value.object("the DAC", {"spi", "speed_Hz", "channels"});
  dac.device = value.at("spi").text();
  dac.speed_Hz = static_cast<std::uint32_t>(value.at("speed_Hz").integer(10'000, 30'000'000));
  const std::size_t axes = one_for_each_axis(value.at("channels"), known_arm(arm));
  for (std::size_t j = 0; j < axes; ++j) {
    const JsonValue channel = value.at("channels").at(j);
    if (!is_given(channel, needs_channel(arm, j))) continue;
    if (arm.drives[j])
      channel.fail("bad-value", "is of a joint whose current its drive gives",
                   "give null, or take the drive out of /drives");
    if (known_arm(arm) != nullptr && !arm.arm.geometry.driven[j])
      channel.fail("bad-value", "is of a joint that has no motor in the arm's model", "give null");
    if (j >= dac.channels.size())
      channel.fail("bad-value", "is of a joint beyond the converter's four outputs",
                   "give the joint a drive");
    channel.object("a channel of the DAC", {"volts_per_ampere", "offset_V"});
    Ad5754::Channel& read = dac.channels[j].emplace();
    read.volts_per_ampere = static_cast<float>(channel.at("volts_per_ampere").number({-100, 100}));
    if (read.volts_per_ampere == 0.0F) channel.at("volts_per_ampere").wrong("a number that is not 0");
    if (channel.has("offset_V")) read.offset_V = static_cast<float>(channel.at("offset_V").number({-1, 1}));
  }
  return dac;
}

// Which arm it is: `model`, one that is built in, in whose place comes what the store has; or `stored_model`, the one that the store must have.
void read_model(const JsonValue& value, const std::optional<kinematics::ArmData>& stored, ArmWiring& arm) {
  if (value.has("stored_model") && value.has("model"))
    value.at("model").fail("senseless-key", "is a built-in arm, and \"stored_model\" is given too",
                           "leave out one of them");
  std::string all;
  for (const std::string_view known : kinematics::built_in_arms())
    all.append(all.empty() ? "\"" : ", \"").append(known).append("\"");
  if (!value.has("stored_model") && !value.has("model"))
    value.fail("missing-key", "has neither \"model\" nor \"stored_model\"",
               "add \"stored_model\", the name of the arm that you upload, or \"model\", one of " + all);
  if (value.has("stored_model")) {
    const std::string wanted = value.at("stored_model").text(kinematics::kMaxArmName);
    arm.model = kinematics::built_in_arms().front();  // the controller needs one; it refuses to arm
    if (!stored || kinematics::name_of(*stored) != wanted) arm.needs_stored = wanted;
  } else {
    arm.model = value.at("model").text();
  }
  if (!kinematics::built_in_arm(arm.model, arm.arm))
    value.at("model").wrong("one of " + all + "; or name an arm of the store by \"stored_model\"");
  if (stored) arm.arm = *stored;
}

ArmWiring read_arm(const JsonValue& value, const std::optional<kinematics::ArmData>& stored) {
  ArmWiring arm;
  value.object("an arm", {"model", "stored_model", "home_m", "turn_deg", "rotation_deg", "encoders", "dac",
                          "drives", "enable", "drive_fault", "index"});
  arm.base = read_base(value);
  read_model(value, stored, arm);
  const kinematics::ArmData* known = known_arm(arm);
  if (value.has("drives")) arm.drives = read_drives(value.at("drives"), known);
  const auto axes = known == nullptr ? 0U : static_cast<std::size_t>(axes_of(known->geometry));
  bool needs_encoders = false, needs_dac = false;
  for (std::size_t j = 0; j < axes; ++j) {
    needs_encoders = needs_encoders || !arm.drives[j];
    needs_dac = needs_dac || needs_channel(arm, j);
  }
  if (value.has("encoders") || needs_encoders) arm.encoders = read_encoders(value.at("encoders"), arm);
  for (const char* key : {"dac", "enable"})
    if (known != nullptr && !needs_dac && value.has(key))
      value.at(key).fail("senseless-key", "is of amplifiers, and every motor has a drive", "leave it out");
  if (value.has("dac") || needs_dac) arm.dac = read_dac(value.at("dac"), arm);
  if (value.has("enable") || needs_dac) arm.enable = read_line(value.at("enable"));
  if (value.has("drive_fault")) arm.drive_fault = read_line(value.at("drive_fault"));
  if (value.has("index")) arm.index = read_line(value.at("index"));
  return arm;
}

// What was read of an arm that the store does not have was read for its errors alone.
void unwire(ArmWiring& arm) {
  arm.encoders.reset();
  arm.dac.reset();
  arm.drives = {};
  for (auto* line : {&arm.enable, &arm.drive_fault, &arm.index}) line->reset();
}

HeartbeatConfig read_heartbeat(const JsonValue& value) {
  value.object("the heartbeat", {"line", "active", "timeout_ms"});
  HeartbeatConfig heartbeat;
  heartbeat.line = {value.at("line").text(), value.at("active").word({"high", "low"}) == 1, GpioBias::kAsIs};
  const double timeout_ms =
      value.at("timeout_ms").number({firmware::kShortestStop_us * 1e-3, firmware::kLongestStop_us * 1e-3});
  heartbeat.timeout_us = static_cast<std::uint32_t>(std::lround(timeout_ms * 1e3));
  return heartbeat;
}

// Frames of the link must not reach the drives: an ODrive's watchdog takes any frame with its id.
void check_links(const JsonValue& links, const BoardConfig& config) {
  for (std::size_t i = 0; i < config.links.size(); ++i)
    for (const ArmWiring& arm : config.arms)
      for (const auto& drive : arm.drives)
        if (drive && config.links[i].kind == LinkConfig::Kind::kCan &&
            config.links[i].device == drive->interface)
          links.at(i).at("can").fail(
              "bad-value", "is \"" + drive->interface + "\", the bus of drives, which must be theirs alone",
              "use another interface for the link");
}

LinkConfig read_link(const JsonValue& value) {
  value.object("a link", {"can", "slcan"});
  if (value.has("can") == value.has("slcan")) value.wrong("either {\"can\": INTERFACE} or {\"slcan\": TTY}");
  if (value.has("can")) return {LinkConfig::Kind::kCan, value.at("can").text(15)};
  return {LinkConfig::Kind::kTty, value.at("slcan").text()};
}

BoardConfig read(const JsonValue& root, const StoredArmsOf& stored_arms) {
  BoardConfig config;
  root.object("the configuration",
              {"thimble_board", "serial_number", "node", "rate_Hz", "work_units", "links", "arms", "e_stop",
               "dead_man", "store", "realtime", "heartbeat", "event", "watchdog"});
  (void)root.at("thimble_board").integer(1, 1);
  config.serial_number = root.at("serial_number").text(32);
  if (root.has("node")) config.node = static_cast<std::uint8_t>(root.at("node").integer(1, 127));
  config.rate_Hz = root.at("rate_Hz").number({kSlowest_Hz, 20'000});
  for (std::size_t i = 0; i < root.at("links").size(1, 4); ++i)
    config.links.push_back(read_link(root.at("links").at(i)));
  config.store = root.at("store").text();
  const StoredArms stored = stored_arms ? stored_arms(config.store) : StoredArms{};
  for (std::size_t i = 0; i < root.at("arms").size(1, control::kMaxArms); ++i)
    config.arms.push_back(read_arm(root.at("arms").at(i), stored[i]));
  std::vector<DriveWirings> drives;
  drives.reserve(config.arms.size());
  for (const ArmWiring& arm : config.arms) drives.push_back(arm.drives);
  check_drive_buses(root.at("arms"), drives, config.rate_Hz);
  check_links(root.at("links"), config);
  config.work_units = firmware::Config{}.work_units;
  if (root.has("work_units")) {
    const auto least = firmware::kLeastWork * static_cast<std::uint32_t>(config.arms.size());
    config.work_units = static_cast<std::uint32_t>(
        root.at("work_units").integer(static_cast<int>(least), static_cast<int>(kMostWorkUnits)));
  }
  config.e_stop = read_contact(root.at("e_stop"));
  if (root.has("dead_man")) config.dead_man = read_contact(root.at("dead_man"));
  const JsonValue realtime = root.at("realtime");
  realtime.object("realtime", {"priority", "cpu"});
  config.priority = realtime.at("priority").integer(1, 98);
  if (realtime.has("cpu")) config.cpu = realtime.at("cpu").integer(0, 1023);
  if (root.has("heartbeat")) config.heartbeat = read_heartbeat(root.at("heartbeat"));
  if (root.has("event")) config.event = read_line(root.at("event"));
  if (root.has("watchdog")) {
    const JsonValue watchdog = root.at("watchdog");
    watchdog.object("the watchdog", {"device", "timeout_s"});
    config.watchdog = watchdog.at("device").text();
    config.watchdog_timeout_s = watchdog.at("timeout_s").integer(1, 60);
  }
  check_uses(root);
  for (ArmWiring& arm : config.arms)
    if (known_arm(arm) == nullptr) unwire(arm);
  return config;
}

}  // namespace

bool has_own_encoder(const ArmWiring& arm, std::size_t joint) noexcept {
  return arm.encoders &&
         !(arm.encoders->kind == EncoderConfig::Kind::kGpio ? arm.encoders->lines[joint][0]
                                                            : arm.encoders->counter[joint].device)
              .empty();
}

BoardConfig parse_board_config(const std::string& text, const std::string& file, const StoredArmsOf& stored) {
  try {
    const JsonDocument document(text, file, "the configuration");
    return read(JsonValue(document), stored);
  } catch (const JsonError& error) {
    throw ConfigError(error.what(), error.remedy);
  }
}

BoardConfig read_board_config(const std::filesystem::path& file, const StoredArmsOf& stored) {
  try {
    return parse_board_config(read_text(file), file.string(), stored);
  } catch (const FileError& error) {
    throw ConfigError(error.what(),
                      "write it, beginning with examples/board.json of the package (docs/board-linux.md), or "
                      "name another with --config");
  }
}

}  // namespace thimble::board
