// The key arms/N/drives of the board's configuration: what is read, and what is refused, with place and cause.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "board/linux/board_config.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/drive_configs.h"

namespace thimble::test {
namespace {

using board::BoardConfig;
using nlohmann::json;

// The JSON block of docs/board-linux.md below this heading.
json block_of_docs(const std::string& heading) {
  std::ifstream in(THIMBLE_SOURCE_DIR "/docs/board-linux.md");
  const std::string page((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::size_t section = page.find("\n" + heading + "\n");
  const std::size_t begin = page.find("```json\n", section);
  const std::size_t end = page.find("```", begin + 8);
  if (section == std::string::npos || end == std::string::npos)
    throw std::logic_error("no example below " + heading);
  return json::parse(page.substr(begin + 8, end - begin - 8));
}

// The example of the page with the mixed arm of its section on drives.
json mixed_board() {
  json root = block_of_docs("## Configuration");
  const json drives = block_of_docs("### Drives");
  for (const auto& [key, value] : drives.items()) root["arms"][0][key] = value;
  return root;
}

BoardConfig parsed(const json& root) { return board::parse_board_config(root.dump(), "board.json"); }

std::string refusal(const std::function<void(json& root, json& drive)>& change) {
  json root = mixed_board();
  change(root, root["arms"][0]["drives"][1]);
  try {
    (void)parsed(root);
  } catch (const board::ConfigError& error) {
    return error.what();
  }
  return "nothing";
}

TEST(DriveKeys, TheExampleOfTheDocsMixesCounterAndDrives) {
  const BoardConfig config = parsed(mixed_board());
  const board::ArmWiring& arm = config.arms[0];
  EXPECT_FALSE(arm.drives[0].has_value());
  EXPECT_TRUE(board::has_own_encoder(arm, 0));
  EXPECT_FALSE(board::has_own_encoder(arm, 1));
  ASSERT_TRUE(arm.drives[1].has_value());
  EXPECT_EQ(arm.drives[1]->interface, "can1");
  EXPECT_EQ(arm.drives[1]->config.kind, Kind::kMoteus);
  EXPECT_FLOAT_EQ(arm.drives[1]->config.watchdog_s, .015F);
  EXPECT_FLOAT_EQ(arm.drives[1]->config.moteus_kd, .25F);
  EXPECT_EQ(arm.drives[2]->direction, -1);
  ASSERT_EQ(arm.drives[2]->items.size(), 1U);
  EXPECT_EQ(arm.drives[2]->items[0].name, "motor_position.rotor_to_output_ratio");
}

TEST(DriveKeys, AnArmOfDrivesAloneHasNoEncodersNoDacAndNoEnableLine) {
  json root = mixed_board();
  json& arm = root["arms"][0];
  arm["drives"][0] = arm["drives"][1];
  arm["drives"][0]["id"] = 7;
  for (const char* key : {"encoders", "dac", "enable"}) arm.erase(key);
  const BoardConfig config = parsed(root);
  EXPECT_FALSE(config.arms[0].encoders || config.arms[0].dac || config.arms[0].enable);
  // Its own encoders beside drives are allowed.
  arm["encoders"] = block_of_docs("## Configuration")["arms"][0]["encoders"];
  EXPECT_TRUE(board::has_own_encoder(parsed(root).arms[0], 2));
}

TEST(DriveKeys, EveryKindHasItsKeys) {
  for (const Kind kind : kKinds) {
    json root = mixed_board();
    json& drive = root["arms"][0]["drives"][1];
    drive = {{"can", "can2"},     {"kind", board::name_of(kind)}, {"id", 1},
             {"watchdog_ms", 15}, {"peak_torque_N_m", 1},         {"top_speed_rad_s", 100}};
    if (is_odrive(kind)) drive["current_limit_A"] = 10;
    if (kind == Kind::kOdrive05) drive["torque_constant_N_m_A"] = .04;
    if (kind == Kind::kOdrive06)
      drive["configuration"] = json::parse(
          R"([{"name": "axis0.config.enable_watchdog", "number": 100, "integer": true, "value": 1},
              {"name": "axis0.config.watchdog_timeout", "number": 101, "value": 0.015}])");
    if (is_mit(kind)) {
      drive["reply_id"] = 17;
      drive["ranges"] = {{"position_rad", 12.5}, {"velocity_rad_s", 30}, {"torque_N_m", 10}};
    }
    if (kind == Kind::kMiniCheetah || kind == Kind::kCubeMars) {
      drive["watchdog_ms"] = 25;
      drive["watchdog_proven"] = true;
    }
    const BoardConfig config = parsed(root);
    EXPECT_EQ(config.arms[0].drives[1]->config.kind, kind) << board::name_of(kind);
    EXPECT_EQ(config.arms[0].drives[1]->config.request_estimates, is_odrive(kind));
  }
}

TEST(DriveKeys, WhatIsRefusedHasItsPlaceAndCause) {
  using testing::HasSubstr;
  EXPECT_THAT(refusal([](json&, json& drive) { drive["kind"] = "vesc"; }),
              HasSubstr("/arms/0/drives/1/kind is \"vesc\", allowed is one of \"moteus\", \"odrive_0.5\""));
  EXPECT_THAT(refusal([](json&, json& drive) { drive["current_limit_A"] = 3; }),
              HasSubstr("/arms/0/drives/1/current_limit_A is not a key of a drive of the kind \"moteus\""));
  EXPECT_THAT(refusal([](json&, json& drive) { drive.erase("watchdog_ms"); }),
              HasSubstr("/arms/0/drives/1 has no \"watchdog_ms\""));
  EXPECT_THAT(
      refusal([](json&, json& drive) { drive["peak_torque_N_m"] = .1; }),
      HasSubstr("/arms/0/drives/1/peak_torque_N_m is below the 0.128934 N m that the arm's motors give"));
  EXPECT_THAT(refusal([](json&, json& drive) { drive["direction"] = 0; }),
              HasSubstr("/arms/0/drives/1/direction is 0, allowed is 1 or -1"));
  EXPECT_THAT(refusal([](json& root, json&) { root["arms"][0]["drives"][1] = nullptr; }),
              HasSubstr("/arms/0/encoders/joints/1 is null, and the joint has no drive in /drives"));
  EXPECT_THAT(refusal([](json& root, json&) { root["arms"][0].erase("drives"); }),
              HasSubstr("/arms/0/encoders/joints/1 is null, and the joint has no drive in /drives"));
  EXPECT_THAT(refusal([](json& root, json&) {
                root["arms"][0]["dac"]["channels"][1] = {{"volts_per_ampere", 2}};
              }),
              HasSubstr("/arms/0/dac/channels/1 is of a joint whose current its drive gives"));
  EXPECT_THAT(refusal([](json& root, json&) { root["arms"][0]["drives"] = json::array({nullptr}); }),
              HasSubstr("/arms/0/drives is [null], allowed is an array of 3 values"));
  EXPECT_THAT(refusal([](json& root, json&) { root["links"][0]["can"] = "can1"; }),
              HasSubstr("/links/0/can is \"can1\", the bus of drives, which must be theirs alone"));
  EXPECT_THAT(refusal([](json& root, json& drive) {
                root["arms"][0]["drives"][0] = drive;
                root["arms"][0]["drives"][0]["id"] = 9;
              }),
              HasSubstr("/arms/0/dac is of amplifiers, and every motor has a drive"));
  EXPECT_THAT(refusal([](json& root, json&) {
                root["arms"][0]["encoders"]["joints"] = json::array({nullptr, nullptr, nullptr});
                root["arms"][0]["drives"][0] = root["arms"][0]["drives"][1];
              }),
              HasSubstr("/arms/0/encoders/joints names no encoder"));
}

// What only all drives of a bus and the rate can tell is said at the drive and its key too, in the key's unit.
TEST(DriveKeys, WhatDoesNotFitTheBusHasItsPlaceAndCause) {
  const auto refusal_of = [](const char* key, const json& value) {
    return refusal([&](json&, json& drive) { drive[key] = value; });
  };
  EXPECT_EQ(
      refusal_of("watchdog_ms", 100),
      "board.json:1: /arms/0/drives/1/watchdog_ms is 100, allowed is a number from 10.0 to 20.0 ms: the "
      "drive's watchdog must be 10 to 20 ticks");
  EXPECT_EQ(refusal([](json& root, json&) { root["rate_Hz"] = 600; }),
            "board.json:1: /arms/0/drives/1/watchdog_ms is 15, allowed is a number from 16.667 to 33.333 ms: "
            "the drive's watchdog must be 10 to 20 ticks");
  EXPECT_EQ(refusal_of("id", 2),
            "board.json:1: /arms/0/drives/2/id is 2, as is board.json:1: /arms/0/drives/1/id: two drives of "
            "one bus have the same id or reply id");
  EXPECT_EQ(refusal_of("id", 0), "board.json:1: /arms/0/drives/1/id is 0: moteus ids are 1 to 127");
  const std::string needs =
      ": damping in a moteus (damping_N_m_s_rad) needs its servo.pid_position.kd, above 0 N m s/turn";
  EXPECT_EQ(refusal_of("kd_N_m_s_turn", 0), "board.json:1: /arms/0/drives/1/kd_N_m_s_turn is 0" + needs);
  EXPECT_EQ(refusal([](json&, json& drive) { drive.erase("kd_N_m_s_turn"); }),
            "board.json:1: /arms/0/drives/1 has no \"kd_N_m_s_turn\"" + needs);
  EXPECT_EQ(refusal_of("timeout_mode", 13),
            "board.json:1: /arms/0/drives/1/timeout_mode is 13: a moteus must brake when the host is silent: "
            "servo.timeout_mode 12 or 15");
  json items;
  for (int i = 0; i < 13; ++i) items.push_back({{"name", "x"}, {"value", i}});
  EXPECT_EQ(refusal_of("configuration", items),
            "board.json:1: /arms/0/drives/1/configuration does not fit: too many configuration items");
}

TEST(DriveKeys, ABusHasAtMostEightDrives) {
  json root = mixed_board();
  const json drive = root["arms"][0]["drives"][1];
  root["arms"] = json::array();
  for (int id = 1; id <= 9; ++id) {
    json& arm = root["arms"][id <= 5 ? 0U : 1U];
    arm["stored_model"] = "x";
    arm["drives"].push_back(drive);
    arm["drives"].back()["id"] = id;
  }
  try {
    (void)parsed(root);
    FAIL() << "nine drives on a bus";
  } catch (const board::ConfigError& error) {
    EXPECT_STREQ(error.what(),
                 "board.json:1: /arms/1/drives/3 does not fit the bus can1: a bus has at most eight drives");
  }
}

// The example with its arm's wiring for the arm in the store.
struct Rewired {
  explicit Rewired(const kinematics::Geometry& geometry) : root(mixed_board()) {
    arm = kinematics::built_in_arm("premium-1.5");
    arm.geometry = geometry;
    json& wiring = root["arms"][0];
    moteus = wiring["drives"][1];
    json counter = wiring["encoders"]["joints"][0];
    const json channel = wiring["dac"]["channels"][0];
    wiring["drives"] = wiring["encoders"]["joints"] = wiring["dac"]["channels"] = json::array();
    for (std::size_t j = 0; j < static_cast<std::size_t>(axes_of(geometry)); ++j) {
      arm.axis[j] = arm.axis[0];
      arm.axis[j].counter_bits = static_cast<std::uint8_t>(20 + j);
      wiring["drives"].push_back(nullptr);
      counter["count"] = j;
      wiring["encoders"]["joints"].push_back(counter);
      wiring["dac"]["channels"].push_back(geometry.driven[j] ? channel : json());
    }
  }
  void give_drive(std::size_t j) {
    json& wiring = root["arms"][0];
    wiring["drives"][j] = moteus;
    wiring["drives"][j]["id"] = j + 1;
    wiring["encoders"]["joints"][j] = wiring["dac"]["channels"][j] = nullptr;
  }
  [[nodiscard]] BoardConfig parsed() const {
    return board::parse_board_config(root.dump(), "board.json", [this](const std::filesystem::path& store) {
      EXPECT_EQ(store, root["store"].get<std::string>());
      return board::StoredArms{arm, std::nullopt};
    });
  }
  [[nodiscard]] std::string refusal() const {
    try {
      (void)parsed();
    } catch (const board::ConfigError& error) {
      return error.what();
    }
    return "nothing";
  }

  json root, moteus;
  kinematics::ArmData arm;
};

kinematics::Geometry five_bar() {
  kinematics::Geometry geometry;
  geometry.platform = kinematics::FiveBarGeometry{.05F, {.1F, .1F}, {.12F, .12F}, true};
  geometry.driven = {true, true};
  return geometry;
}
kinematics::Geometry chain(int joints, int motors) {
  kinematics::Geometry geometry;
  geometry.chain.count = joints;
  for (int j = 0; j < motors; ++j) geometry.driven[static_cast<std::size_t>(j)] = true;
  return geometry;
}

TEST(BoardConfig, JointsAreThoseOfTheArmInTheStore) {
  using testing::HasSubstr;
  for (const auto& [geometry, axes, motors] : {std::tuple{five_bar(), 2U, 2U},
                                               {chain(1, 1), 1U, 1U},
                                               {chain(4, 4), 4U, 4U},
                                               {chain(6, 3), 6U, 3U}}) {
    const Rewired board(geometry);
    const BoardConfig config = board.parsed();
    const board::ArmWiring& arm = config.arms[0];
    unsigned own = 0, channels = 0;
    for (std::size_t j = 0; j < board::kArmJoints; ++j) {
      if (!board::has_own_encoder(arm, j)) continue;
      ++own;
      EXPECT_EQ(arm.encoders->counter[j].bits, 20 + j);
    }
    for (const auto& channel : arm.dac->channels) channels += channel.has_value() ? 1U : 0U;
    EXPECT_EQ(own, axes);
    EXPECT_EQ(channels, motors);
    // The wiring of an arm of three joints is not this one's.
    Rewired other(geometry);
    other.root["arms"][0] = mixed_board()["arms"][0];
    EXPECT_THAT(other.refusal(),
                HasSubstr("allowed is an array of " + std::to_string(axes) + " values, one for each axis"));
  }
}

// By stored_model the configuration of an arm can be written before the arm is uploaded: until then nothing is wired, and so nothing moves.
TEST(BoardConfig, AnArmThatTheStoreMustHaveIsWiredWhenItHasIt) {
  Rewired board(five_bar());
  json& wiring = board.root["arms"][0];
  wiring.erase("model");
  wiring["stored_model"] = "bench arm";
  const auto unwired = [](const BoardConfig& config) {
    const board::ArmWiring& arm = config.arms[0];
    return arm.needs_stored == "bench arm" && !arm.encoders && !arm.dac && !arm.enable && !arm.index &&
           !arm.drives[0];
  };
  EXPECT_TRUE(unwired(parsed(board.root)));  // the store is empty
  EXPECT_TRUE(unwired(board.parsed()));      // it has the arm of another name
  EXPECT_EQ(parsed(board.root).arms[0].model, "premium-1.5");
  std::ranges::copy(std::string_view("bench arm"), (board.arm.name = {}).begin());
  const BoardConfig config = board.parsed();
  EXPECT_EQ(config.arms[0].needs_stored, "");
  EXPECT_TRUE(config.arms[0].encoders && config.arms[0].dac && config.arms[0].enable);
  EXPECT_EQ(axes_of(config.arms[0].arm.geometry), 2);
  // What is wired is checked then.
  wiring["encoders"]["joints"].push_back(nullptr);
  EXPECT_THAT(board.refusal(), testing::HasSubstr("one for each axis of the arm \"bench arm\""));
}

// All that needs no arm is said before the upload: how many axes there are, and which have motors, is not known.
TEST(BoardConfig, TheWiringOfAnArmThatIsNotStoredIsCheckedAsFarAsPossible) {
  using testing::HasSubstr;
  const auto unstored_refusal = [](const std::function<void(json&, json&)>& change) {
    return refusal([&change](json& root, json&) {
      json& arm = root["arms"][0];
      arm.erase("model");
      arm["stored_model"] = "bench arm";
      change(root, arm);
    });
  };
  EXPECT_EQ(unstored_refusal([](json&, json&) {}), "nothing");
  EXPECT_EQ(unstored_refusal([](json&, json& arm) {
              arm["drives"].erase(0);
              for (const char* key : {"encoders", "dac", "enable"}) arm.erase(key);
            }),
            "nothing");
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["drives"][1]["kind"] = "vesc"; }),
              HasSubstr("/arms/0/drives/1/kind is \"vesc\""));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["drives"][1].erase("top_speed_rad_s"); }),
              HasSubstr("/arms/0/drives/1 has no \"top_speed_rad_s\""));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["drives"][1]["id"] = 2; }),
              HasSubstr("/arms/0/drives/2/id is 2, as is "));
  EXPECT_THAT(unstored_refusal([](json& root, json&) { root["links"][0]["can"] = "can1"; }),
              HasSubstr("/links/0/can is \"can1\", the bus of drives"));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["drives"] = json::array(); }),
              HasSubstr("/arms/0/drives is [], allowed is an array of 1 to 7 values"));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["dac"].erase("spi"); }),
              HasSubstr("/arms/0/dac has no \"spi\""));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["enable"]["line"] = "ESTOP"; }),
              HasSubstr("/arms/0/enable/line names the GPIO line \"ESTOP\", which "));
  EXPECT_THAT(unstored_refusal([](json&, json& arm) { arm["encoders"]["joints"][0].erase("count"); }),
              HasSubstr("/arms/0/encoders/joints/0 has no \"count\""));
}

TEST(BoardConfig, AnArmOfDrivesAloneHasNoAmplifiers) {
  using testing::HasSubstr;
  Rewired board(five_bar());
  board.give_drive(0);
  board.give_drive(1);
  EXPECT_THAT(board.refusal(), HasSubstr("/arms/0/encoders/joints names no encoder"));
  board.root["arms"][0].erase("encoders");
  EXPECT_THAT(board.refusal(), HasSubstr("/arms/0/dac is of amplifiers, and every motor has a drive"));
  board.root["arms"][0].erase("dac");
  board.root["arms"][0].erase("enable");
  const BoardConfig config = board.parsed();
  EXPECT_FALSE(config.arms[0].encoders || config.arms[0].dac || config.arms[0].enable);

  // The wrist is sensed only: it has encoders, and no amplifier is needed.
  Rewired wrist(chain(6, 3));
  for (std::size_t j = 0; j < 3; ++j) wrist.give_drive(j);
  wrist.root["arms"][0].erase("dac");
  wrist.root["arms"][0].erase("enable");
  const BoardConfig sensed = wrist.parsed();
  EXPECT_TRUE(sensed.arms[0].encoders.has_value());
  EXPECT_FALSE(sensed.arms[0].dac.has_value());
  EXPECT_FALSE(board::has_own_encoder(sensed.arms[0], 2));
  EXPECT_TRUE(board::has_own_encoder(sensed.arms[0], 3));
  wrist.give_drive(5);
  EXPECT_THAT(wrist.refusal(),
              HasSubstr("/arms/0/drives/5 is a drive, and the arm has no motor at this joint"));
}

TEST(BoardConfig, ChannelsAreOfMotorsAndOfFourOutputs) {
  using testing::HasSubstr;
  EXPECT_THAT(Rewired(chain(5, 5)).refusal(),
              HasSubstr("/arms/0/dac/channels/4 is of a joint beyond the converter's four outputs"));
  Rewired sensed(chain(4, 3));
  sensed.root["arms"][0]["dac"]["channels"][3] = {{"volts_per_ampere", 2}};
  EXPECT_THAT(sensed.refusal(), HasSubstr("/arms/0/dac/channels/3 is of a joint that has no motor"));
  Rewired bare(chain(4, 3));
  bare.root["arms"][0]["dac"]["channels"][2] = nullptr;
  EXPECT_THAT(bare.refusal(), HasSubstr("/arms/0/dac/channels/2 is null, and the joint has no drive"));
}

}  // namespace
}  // namespace thimble::test
