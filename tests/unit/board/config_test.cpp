// The board's configuration: the example of the docs, the bounds of every key, and errors with their
// position.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>

#include "board/common/stop_path.h"
#include "board/linux/board_config.h"
#include "firmware/core/stop_timeout.h"
#include "kinematics/arm.h"
#include "kinematics/built_in_arms.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using board::BoardConfig;
using board::ConfigError;
using board::EncoderConfig;
using board::GpioBias;
using nlohmann::json;

// The first JSON block of docs/board-linux.md.
std::string example() {
  std::ifstream in(THIMBLE_SOURCE_DIR "/docs/board-linux.md");
  const std::string page((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::size_t begin = page.find("```json\n");
  const std::size_t end = page.find("```", begin + 8);
  if (begin == std::string::npos || end == std::string::npos)
    throw std::logic_error("no example in docs/board-linux.md");
  return page.substr(begin + 8, end - begin - 8);
}

BoardConfig parse(const json& root) { return board::parse_board_config(root.dump(), "board.json"); }

// What is said about the example after `change`, and what to do.
ConfigError error_of(const std::function<void(json&)>& change) {
  json root = json::parse(example());
  change(root);
  try {
    (void)parse(root);
  } catch (const ConfigError& error) {
    return error;
  }
  return {"nothing", "nothing"};
}
std::string complaint(const std::function<void(json&)>& change) { return error_of(change).what(); }

TEST(BoardConfig, TheExampleOfTheDocs) {
  const BoardConfig config = board::parse_board_config(example(), "board.json");
  EXPECT_EQ(config.rate_Hz, 1000.0);
  EXPECT_EQ(config.node, 1);
  ASSERT_EQ(config.arms.size(), 1U);
  EXPECT_EQ(config.arms[0].model, "premium-1.5");
  EXPECT_EQ(config.arms[0].encoders->kind, EncoderConfig::Kind::kCounterPoll);
  EXPECT_EQ(config.arms[0].encoders->counter[2].device, "48304180.counter");
  ASSERT_EQ(config.links.size(), 2U);
  EXPECT_EQ(config.links[0].device, "can0");
  EXPECT_EQ(config.links[1].device, "/dev/ttyGS0");
  ASSERT_TRUE(config.watchdog);
  ASSERT_TRUE(config.heartbeat);
  EXPECT_EQ(config.heartbeat->line.name, "HEARTBEAT");
  EXPECT_EQ(config.heartbeat->timeout_us, 5000U);
  EXPECT_EQ(config.priority, 80);
}

TEST(BoardConfig, TheEventLineIsOptional) {
  EXPECT_FALSE(board::parse_board_config(example(), "board.json").event);
  json root = json::parse(example());
  root["event"] = {{"line", "EVENT"}, {"active", "low"}};
  const BoardConfig config = board::parse_board_config(root.dump(), "board.json");
  ASSERT_TRUE(config.event);
  EXPECT_EQ(config.event->name, "EVENT");
  EXPECT_TRUE(config.event->active_low);
  EXPECT_NE(complaint([](json& other) {
              other["event"] = {{"line", "EVENT"}, {"active", "low"}, {"width_ms", 5}};
            }).find("board.json:1: /event/width_ms is not a key of a line"),
            std::string::npos);
}

// Whichever way a contact is wired: closed is active, and the pull is towards open.
TEST(BoardConfig, AnOpenWireIsAnOpenContact) {
  for (const bool low : {false, true}) {
    json root = json::parse(example());
    root["e_stop"]["closed"] = low ? "low" : "high";
    const BoardConfig config = parse(root);
    EXPECT_EQ(config.e_stop.active_low, low);
    EXPECT_EQ(config.e_stop.bias, low ? GpioBias::kPullUp : GpioBias::kPullDown);
  }
}

TEST(BoardConfig, OtherEncoders) {
  json root = json::parse(example());
  json& encoders = root["arms"][0]["encoders"];
  encoders = {{"read", "counter_events"}, {"event", "capture"}, {"joints", json::array()}};
  for (int j = 0; j < 3; ++j) encoders["joints"].push_back({{"counter", "counter0"}, {"count", j}});
  EXPECT_EQ(parse(root).arms[0].encoders->kind, EncoderConfig::Kind::kCounterEvents);
  encoders["joints"][1]["counter"] = "counter1";
  EXPECT_THROW((void)parse(root), ConfigError);
  encoders = {{"read", "gpio"}, {"joints", json::array()}};
  for (const char* joint : {"1", "2", "3"})
    encoders["joints"].push_back(
        {{"line_a", std::string("A") + joint}, {"line_b", std::string("B") + joint}});
  EXPECT_EQ(parse(root).arms[0].encoders->lines[2][1], "B3");
}

TEST(BoardConfig, ErrorsSayWhere) {
  EXPECT_EQ(
      complaint([](json& root) { root["arms"][0]["dac"]["channels"][1]["volts_per_ampere"] = "two"; }),
      "board.json:1: /arms/0/dac/channels/1/volts_per_ampere is \"two\", allowed is a number from -100.0 "
      "to 100.0");
  EXPECT_EQ(complaint([](json& root) { root["arms"][0].erase("dac"); }),
            "board.json:1: /arms/0 has no \"dac\"");
  EXPECT_NE(complaint([](json& root) {
              root["arms"][0]["modle"] = "x";
            }).find("board.json:1: /arms/0/modle is not a key of an arm; did you mean \"model\"?"),
            std::string::npos);
  EXPECT_NE(complaint([](json& root) { root["arms"][0]["model"] = "omega"; }).find("\"premium-1.5\""),
            std::string::npos);
  try {
    (void)board::parse_board_config("{ \"thimble_board\": 1, }", "board.json");
    FAIL() << "this is no JSON";
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("board.json:1: "), std::string::npos);
  }
  EXPECT_THROW((void)board::read_board_config("/nowhere/board.json"), ConfigError);
}

TEST(BoardConfig, ErrorsSayWhatToDo) {
  EXPECT_EQ(error_of([](json& root) { root["rate_Hz"] = 399; }).remedy,
            "give a number from 400.0 to 20000.0");
  EXPECT_EQ(error_of([](json& root) { root["arms"][0].erase("dac"); }).remedy, "add \"dac\"");
  EXPECT_EQ(error_of([](json& root) { root["arms"][0]["modle"] = "x"; }).remedy, "correct the key");
  EXPECT_EQ(error_of([](json& root) { root["arms"][0]["dac"]["channels"][0] = nullptr; }).remedy,
            "describe it, or its drive");
  EXPECT_EQ(error_of([](json& root) {
              root["arms"][0]["rotation_deg"] = {0, 0, 90};
            }).remedy,
            "leave out one of them");
  EXPECT_EQ(error_of([](json& root) { root["arms"][0]["stored_model"] = "x"; }).remedy,
            "leave out one of them");
  try {
    (void)board::read_board_config("/nowhere/board.json");
    FAIL() << "there is no such file";
  } catch (const ConfigError& error) {
    EXPECT_NE(error.remedy.find("examples/board.json"), std::string::npos);
  }
}

TEST(BoardConfig, AnArmHasAModelOrAStoredOne) {
  const ConfigError error = error_of([](json& root) { root["arms"][0].erase("model"); });
  EXPECT_STREQ(error.what(), "board.json:1: /arms/0 has neither \"model\" nor \"stored_model\"");
  EXPECT_EQ(error.remedy,
            "add \"stored_model\", the name of the arm that you upload, or \"model\", one of "
            "\"premium-1.5\", \"wooden\"");
}

// The example with a second arm whose wiring is its own.
json two_arms() {
  json root = json::parse(example());
  json arm = root["arms"][0];
  arm["enable"]["line"] = "AMP_EN_2";
  arm["dac"]["spi"] = "/dev/spidev0.1";
  for (json& joint : arm["encoders"]["joints"]) joint["count"] = 1;
  root["arms"].push_back(arm);
  return root;
}

// A contact that shares its line with another would not be read as what it is, and an output would drive what is not meant.
TEST(BoardConfig, ALineACountAConverterAndALinkHaveOneUse) {
  const auto refused = [](const json& root) -> ConfigError {
    try {
      (void)parse(root);
    } catch (const ConfigError& error) {
      return error;
    }
    return {"nothing", "nothing"};
  };
  EXPECT_STREQ(refused(two_arms()).what(), "nothing");  // drive fault and index are those of both arms
  struct Twice {
    const char* changed;
    json value;
    std::string second, thing, first;
  };
  for (const auto& [changed, value, second, thing, first] : {
           Twice{"/dead_man/line", "ESTOP", "/dead_man/line", "the GPIO line \"ESTOP\"", "/e_stop/line"},
           {"/heartbeat/line", "AMP_EN", "/arms/0/enable/line", "the GPIO line \"AMP_EN\"",
            "/heartbeat/line"},
           {"/event",
            {{"line", "HEARTBEAT"}, {"active", "low"}},
            "/event/line",
            "the GPIO line \"HEARTBEAT\"",
            "/heartbeat/line"},
           {"/arms/0/enable/line", "ESTOP", "/arms/0/enable/line", "the GPIO line \"ESTOP\"", "/e_stop/line"},
           {"/arms/1/enable/line", "AMP_EN", "/arms/1/enable/line", "the GPIO line \"AMP_EN\"",
            "/arms/0/enable/line"},
           {"/arms/1/index/line", "AMP_FAULT", "/arms/1/index/line", "the GPIO line \"AMP_FAULT\"",
            "/arms/0/drive_fault/line"},
           {"/arms/1/index/active", "low", "/arms/1/index/line", "the GPIO line \"ARM_INDEX\"",
            "/arms/0/index/line"},
           {"/arms/0/encoders/joints/2/counter", "48300180.counter", "/arms/0/encoders/joints/2",
            "the count \"48300180.counter\" 0", "/arms/0/encoders/joints/0"},
           {"/arms/1/encoders/joints/1/count", 0, "/arms/1/encoders/joints/1",
            "the count \"48302180.counter\" 0", "/arms/0/encoders/joints/1"},
           {"/arms/1/dac/spi", "/dev/spidev0.0", "/arms/1/dac/spi", "the converter \"/dev/spidev0.0\"",
            "/arms/0/dac/spi"},
           {"/links/1", {{"can", "can0"}}, "/links/1/can", "the interface \"can0\"", "/links/0/can"},
       }) {
    json root = two_arms();
    root[json::json_pointer(changed)] = value;
    const ConfigError error = refused(root);
    EXPECT_EQ(error.what(), "board.json:1: " + second + " names " + thing + ", which board.json:1: " + first +
                                " names too");
    EXPECT_NE(error.remedy, "nothing");
  }
  json root = json::parse(example());
  json& encoders = root["arms"][0]["encoders"];
  encoders = json::parse(R"({"read": "gpio", "joints": [{"line_a": "A1", "line_b": "B1"},
                             {"line_a": "A2", "line_b": "B2"}, {"line_a": "A3", "line_b": "ESTOP"}]})");
  const ConfigError error = refused(root);
  EXPECT_STREQ(error.what(),
               "board.json:1: /arms/0/encoders/joints/2/line_b names the GPIO line \"ESTOP\", which "
               "board.json:1: /e_stop/line names too");
  EXPECT_EQ(error.remedy, "wire each purpose to a line of its own, and name that");
}

TEST(BoardConfig, TheReferenceBuildsAreRead) {
  for (const char* file :
       {"/board/linux/reference/beaglebone/board.json", "/board/linux/reference/raspberry-pi/board.json",
        "/docs/examples/five-bar/board.json"})
    EXPECT_NO_THROW((void)board::read_board_config(std::string(THIMBLE_SOURCE_DIR) + file)) << file;
}

// The arm of the example's board with its base so, and with a geometry of its own where one is given.
struct Mounted {
  explicit Mounted(json rotation_deg, const kinematics::ArmData* data = nullptr) {
    json root = json::parse(example());
    json& wiring = root["arms"][0];
    wiring.erase("turn_deg");
    wiring["home_m"] = {.1, .2, .3};
    wiring["rotation_deg"] = std::move(rotation_deg);
    if (data != nullptr) {
      for (const char* key : {"dac", "encoders"}) {
        json& list = wiring[key][std::string(key) == "dac" ? "channels" : "joints"];
        list = json::array({list[0]});
      }
    }
    config = board::parse_board_config(root.dump(), "board.json", [data](const auto&) {
      board::StoredArms stored;
      if (data != nullptr) stored[0] = *data;
      return stored;
    });
  }
  // At axes away from home by so many rad.
  [[nodiscard]] kinematics::Posture<float> moved(const Eigen::Vector3f& by_rad) const {
    const kinematics::Arm<float> arm = made();
    kinematics::Posture<float> posture = arm.home_posture();
    kinematics::PerAxis<float> axes = arm.home();
    axes.head<3>() += by_rad;
    arm.move_to(axes, posture);
    return posture;
  }
  [[nodiscard]] kinematics::PerAxis<float> weight_N_m(const Eigen::Vector3f& by_rad) const {
    return made().gravity_torques(moved(by_rad));
  }
  [[nodiscard]] kinematics::Arm<float> made() const {
    return kinematics::Arm<float>(config.arms[0].arm, config.arms[0].base);
  }
  BoardConfig config;
};

// A rod on one hinge, about z of its base: where the base leans by roll and pitch, its centre of mass at the angle q is as high as
// r (-sin pitch cos q + cos pitch sin roll sin q), whatever the yaw.
TEST(BoardConfig, ATiltedBaseTiltsTheWeightOfARod) {
  constexpr float kMass_kg = .3F, kRadius_m = .12F;
  kinematics::ArmData rod = kinematics::built_in_arm("premium-1.5");
  rod.has_inertia = false;
  rod.geometry = {};
  rod.geometry.chain.count = 1;
  rod.geometry.driven[0] = true;
  rod.geometry.body_count = 1;
  rod.geometry.body[0] = {.mass_kg = kMass_kg, .centre_m = {kRadius_m, 0, 0}};
  for (const auto& [roll, pitch, yaw] :
       {std::tuple{0., 0., 70.}, {90., 0., 0.}, {30., -20., 0.}, {30., -20., 130.}, {-15., 50., -40.}}) {
    const Mounted mounted({roll, pitch, yaw}, &rod);
    for (const float q : {-1.1F, 0.F, .7F}) {
      const double a = roll * std::numbers::pi / 180, b = pitch * std::numbers::pi / 180;
      const auto angle = static_cast<double>(q);
      const double expected_N_m =
          static_cast<double>(kMass_kg * kinematics::kGravity_m_s2 * kRadius_m) *
          (std::sin(b) * std::sin(angle) + std::cos(b) * std::sin(a) * std::cos(angle));
      EXPECT_NEAR(static_cast<double>(mounted.weight_N_m({q, 0, 0})[0]), expected_N_m, 1e-6)
          << roll << ' ' << pitch << ' ' << yaw << " at " << q;
    }
  }
}

// The arm that is built in: overhead its weight pulls the other way, and positions and forces are those of the world.
TEST(BoardConfig, ATiltedBaseTurnsPositionsAndForces) {
  const Eigen::Vector3f by_rad(.3F, -.2F, .25F), home_m(.1F, .2F, .3F);
  const Mounted level({0, 0, 0}), overhead({180, 0, 0}), tilted({20, -35, 60});
  EXPECT_TRUE(overhead.weight_N_m(by_rad).head<3>().isApprox(-level.weight_N_m(by_rad).head<3>(), 1e-5F));
  EXPECT_GT(level.weight_N_m(by_rad).head<3>().norm(), .01F);
  const auto turn = [](double degrees, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(degrees * std::numbers::pi / 180, axis);
  };
  const Eigen::Matrix3f R = (turn(60, Eigen::Vector3d::UnitZ()) * turn(-35, Eigen::Vector3d::UnitY()) *
                             turn(20, Eigen::Vector3d::UnitX()))
                                .toRotationMatrix()
                                .cast<float>();
  const auto before = level.moved(by_rad), after = tilted.moved(by_rad);
  EXPECT_TRUE(tilted.moved(Eigen::Vector3f::Zero()).tip_m.isApprox(home_m, 1e-5F));
  EXPECT_LT((after.tip_m - home_m - R * (before.tip_m - home_m)).norm(), 1e-6F);
  EXPECT_TRUE(after.jacobian.leftCols<3>().isApprox(R * before.jacobian.leftCols<3>(), 1e-5F));
  // turn_deg is the yaw alone, and leaves the base level to the last bit.
  json root = json::parse(example());
  root["arms"][0]["turn_deg"] = 60;
  const Eigen::Matrix3f yaw = parse(root).arms[0].base.rotation;
  EXPECT_TRUE(yaw.isApprox(turn(60, Eigen::Vector3d::UnitZ()).toRotationMatrix().cast<float>(), 1e-6F));
  EXPECT_EQ(yaw.row(2), Eigen::RowVector3f::UnitZ());
}

// The stop path acts within 5 ms, whatever the configuration says.
TEST(BoardConfig, NothingMakesTheStopPathSlower) {
  EXPECT_EQ(complaint([](json& root) { root["rate_Hz"] = 399; }),
            "board.json:1: /rate_Hz is 399, allowed is a number from 400.0 to 20000.0");
  EXPECT_EQ(complaint([](json& root) { root["heartbeat"]["timeout_ms"] = 5.1; }),
            "board.json:1: /heartbeat/timeout_ms is 5.1, allowed is a number from 2.0 to 5.0");
}

TEST(StopTimeout, IsBetween2And5MsAndToleratesTheLostTicks) {
  using firmware::stop_timeout_us;
  EXPECT_EQ(stop_timeout_us(250'000, 4), 2000U);
  EXPECT_EQ(stop_timeout_us(250'000, 9), 2500U);
  EXPECT_EQ(stop_timeout_us(250'000, 19), 5000U);
  EXPECT_EQ(stop_timeout_us(250'000, 20), std::nullopt);
  EXPECT_EQ(stop_timeout_us(1'000'000, 4), 5000U);
  EXPECT_EQ(stop_timeout_us(1'000'000, 5), std::nullopt);
  EXPECT_EQ(stop_timeout_us(2'500'000, 1), 5000U);
  EXPECT_EQ(stop_timeout_us(333'333, 14), 4999U);
  EXPECT_EQ(stop_timeout_us(20'000'000, 1000), std::nullopt);
}

TEST(StopTimeout, OfTheSavedParameters) {
  TestStorage storage;
  const auto saved = [&storage](std::uint32_t lost_ticks) {
    firmware::Params params;
    firmware::ParamStore store(storage);
    store.load(params);
    EXPECT_EQ(params.write(firmware::row_of(firmware::Param::lost_ticks).id, lost_ticks, true),
              firmware::ParamStatus::kOk);
    EXPECT_EQ(store.save(params), firmware::StoreStatus::kOk);
    return board::saved_stop_path(storage, 4000);
  };
  EXPECT_EQ(saved(9).timeout_us, 2500U);
  EXPECT_STREQ(saved(9).lacks, "");
  EXPECT_STREQ(saved(20).lacks, "lost_ticks_above_5_ms");
  EXPECT_EQ(saved(20).timeout_us, 2000U);
}

// Every key of the example: an unknown one beside it, and itself with a value of a wrong kind, are refused by
// name.
TEST(BoardConfig, EveryKeyIsChecked) {
  const json root = json::parse(example());
  int keys = 0;
  const std::function<void(const json&, const json::json_pointer&)> walk = [&](const json& value,
                                                                               const json::json_pointer& at) {
    if (value.is_object()) {
      EXPECT_NE(
          complaint([&](json& changed) { changed[at]["unknown"] = 1; }).find((at / "unknown").to_string()),
          std::string::npos)
          << at;
      for (const auto& [key, child] : value.items()) walk(child, at / key);
    } else if (value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i) walk(value[i], at / i);
    }
    if (at.empty()) return;
    EXPECT_NE(complaint([&](json& changed) { changed[at] = nullptr; }).find(at.to_string() + " is null"),
              std::string::npos)
        << at;
    ++keys;
  };
  walk(root, json::json_pointer());
  EXPECT_GT(keys, 40);
}

TEST(BoardConfig, Bounds) {
  const auto refused = [](const char* pointer, const json& value) {
    return complaint([&](json& root) {
             root[json::json_pointer(pointer)] = value;
           }).find(std::string(pointer) + " is ") != std::string::npos;
  };
  EXPECT_TRUE(refused("/rate_Hz", 99.9));
  EXPECT_TRUE(refused("/rate_Hz", 20001));
  EXPECT_TRUE(refused("/node", 0));
  EXPECT_TRUE(refused("/node", 128));
  EXPECT_TRUE(refused("/node", 1.5));
  EXPECT_TRUE(refused("/thimble_board", 2));
  EXPECT_TRUE(refused("/arms", json::array()));
  EXPECT_TRUE(refused("/links", json::array()));
  EXPECT_TRUE(refused("/links/0", json::object()));
  EXPECT_TRUE(refused("/e_stop/closed", "yes"));
  EXPECT_TRUE(refused("/realtime/priority", 99));
  EXPECT_TRUE(refused("/arms/0/dac/channels/0/volts_per_ampere", 0));
  EXPECT_TRUE(refused("/serial_number", ""));
}

}  // namespace
}  // namespace thimble::test
