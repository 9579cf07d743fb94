// Frames merged into states: pairs, losses, ends, and the reset with the next scene.
#include "host-tools/viewer/live_state.h"

#include <gtest/gtest.h>

namespace thimble::host {
namespace {

constexpr std::uint8_t kNode = 3;
constexpr link::Micros kNow_us = 1'000'000;

link::Pose pose(float z_m, std::uint8_t sequence, std::uint8_t arm = 0) {
  link::Pose pose;
  pose.z_m = z_m;
  pose.arm = arm;
  pose.sequence = sequence;
  return pose;
}

link::Force force(float z_N, unsigned contacts, std::uint8_t sequence, std::uint8_t arm = 0) {
  link::Force force;
  force.z_N = z_N;
  force.contacts = static_cast<std::uint8_t>(contacts);
  force.arm = arm;
  force.sequence = sequence;
  return force;
}

link::GodObject god_object(std::uint8_t sequence, std::uint8_t arm = 0) {
  link::GodObject god;
  god.arm = arm;
  god.sequence = sequence;
  return god;
}

link::ContactPlane plane(std::uint8_t index, std::uint8_t count, std::uint8_t sequence,
                         const std::array<float, 3>& normal) {
  link::ContactPlane plane;
  plane.index = index;
  plane.count = count;
  plane.sequence = sequence;
  plane.x = normal[0];
  plane.y = normal[1];
  plane.z = normal[2];
  return plane;
}

class Telemetry {
 public:
  explicit Telemetry(std::size_t arms = 1) : state(kNode, arms) {}

  template <class Message>
  bool take(const Message& message, link::Micros now_us = kNow_us) {
    return state.take(link::to_frame(message, kNode), now_us);
  }
  // Tip, force and, in contact, god object of one arm; true when the last one completed the record.
  bool record(std::uint8_t sequence, float z_m, float force_N, unsigned contacts, std::uint8_t arm = 0) {
    bool complete = take(pose(z_m, sequence, arm));
    complete = take(force(force_N, contacts, sequence, arm)) || complete;
    if (contacts != 0) complete = take(god_object(sequence, arm));
    return complete;
  }
  Json arm(std::size_t index = 0) const { return state.json(kNow_us)["arms"][index]; }

  LiveState state;
};

TEST(LiveState, KnowsNothingAtFirst) {
  const Telemetry t(2);
  const Json json = t.state.json(kNow_us);
  EXPECT_FALSE(json.contains("mode"));
  EXPECT_EQ(json["arms"], Json::parse("[null, null]"));
  EXPECT_EQ(json["bodies"], Json::array());
}

TEST(LiveState, ARecordIsCompleteOnce) {
  Telemetry t;
  EXPECT_FALSE(t.take(pose(0.01F, 1)));
  EXPECT_TRUE(t.take(force(0, 0, 1))) << "in free space without a god object";
  EXPECT_FALSE(t.take(link::Status{}));
  EXPECT_EQ(t.arm()["god_m"], t.arm()["tip_m"]);
  EXPECT_FALSE(t.take(pose(-0.001F, 2)));
  EXPECT_FALSE(t.take(force(1, 1, 2))) << "its god object follows";
  EXPECT_TRUE(t.take(god_object(2)));
  EXPECT_EQ(t.arm()["god_m"], Json({0, 0, 0}));
  EXPECT_EQ(t.arm()["contacts"], 1);
  EXPECT_EQ(t.state.sequence(), 2);
}

TEST(LiveState, ARecordWithALostFrameEndsWithTheNext) {
  Telemetry t;
  EXPECT_TRUE(t.record(1, 0, 0, 0));
  EXPECT_FALSE(t.take(pose(0, 2)));  // its force is lost
  EXPECT_TRUE(t.take(pose(0, 3)));
  EXPECT_TRUE(t.take(force(0, 0, 3)));
}

TEST(LiveState, TwoArmsAreOneRecord) {
  Telemetry t(2);
  EXPECT_FALSE(t.record(7, 0.01F, 0, 0, 0));
  EXPECT_TRUE(t.record(7, 0.02F, 0, 0, 1));
  EXPECT_EQ(t.arm(1)["tip_m"], Json({0, 0, 0.02}));
  Telemetry one;
  EXPECT_TRUE(one.record(1, 0, 0, 0, 0));
  EXPECT_FALSE(one.record(1, 0, 0, 0, 1)) << "an arm that the device does not have";
}

link::JointAngles angles(std::uint8_t part, std::uint8_t sequence, const std::array<float, 3>& rad) {
  link::JointAngles angles;
  angles.part = part;
  angles.sequence = sequence;
  angles.angle_rad = rad;
  return angles;
}

TEST(LiveState, AnglesOfJointsBelongToTheRecord) {
  Telemetry t;
  t.state = LiveState(kNode, 1, {4, 0});
  EXPECT_TRUE(t.record(1, 0.01F, 0, 0)) << "the device may tell no angles";
  EXPECT_FALSE(t.state.joints(0));
  EXPECT_FALSE(t.take(angles(0, 1, {0.1F, 0.2F, 0.3F})));
  EXPECT_FALSE(t.state.joints(0)) << "one is missing";
  EXPECT_FALSE(t.take(angles(1, 1, {0.4F, 0, 0})));
  ASSERT_TRUE(t.state.joints(0));
  EXPECT_EQ(t.state.joints(0)->axes.size(), 4U);
  EXPECT_NEAR(t.state.joints(0)->axes[3], 0.4, 1e-4);
  EXPECT_NEAR(t.state.joints(0)->tip_m[2], 0.01, 1e-6);

  EXPECT_FALSE(t.record(2, 0.02F, 0, 0)) << "the angles of this record follow, as those of the last one";
  EXPECT_FALSE(t.take(angles(0, 2, {0, 0, 0})));
  EXPECT_FALSE(t.take(angles(1, 1, {0, 0, 0}))) << "of another record";
  EXPECT_TRUE(t.take(angles(1, 2, {0.5F, 0, 0})));
  EXPECT_NEAR(t.state.joints(0)->axes[3], 0.5, 1e-4);
  EXPECT_NEAR(t.state.joints(0)->tip_m[2], 0.02, 1e-6);

  EXPECT_FALSE(t.record(3, 0.03F, 0, 0));
  EXPECT_NEAR(t.state.joints(0)->tip_m[2], 0.02, 1e-6) << "axes and tip of one record";
  EXPECT_TRUE(t.record(4, 0.04F, 0, 0)) << "the device tells no angles any more";
  EXPECT_FALSE(t.state.joints(0));
}

TEST(LiveState, FramesOfOthersAreNone) {
  Telemetry t;
  EXPECT_FALSE(t.state.take(link::to_frame(pose(1, 1), 4), kNow_us));
  EXPECT_TRUE(t.arm().is_null());
}

TEST(LiveState, VelocityOverLostRecords) {
  Telemetry t;
  t.state.set_record_period(0.01);
  for (std::uint8_t i = 250; i != 30;
       i = static_cast<std::uint8_t>(i + (i % 3 == 0 ? 2 : 1)))  // some are lost, and 255 is passed
    t.record(i, 0.001F * static_cast<float>(static_cast<std::uint8_t>(i - 250)), 0, 0);
  EXPECT_NEAR(t.arm()["velocity_m_s"][2].get<double>(), 0.1, 1e-3);
}

TEST(LiveState, EnergyIsTheWorkSinceTheContactBegan) {
  Telemetry t;
  t.record(1, 0.01F, 0, 0);
  for (std::uint8_t i = 0; i <= 10; ++i)  // pressed 2 mm into 500 N/m
    t.record(static_cast<std::uint8_t>(2 + i), -0.0002F * i, 0.1F * i, 1);
  EXPECT_NEAR(t.arm()["energy_J"].get<double>(), -0.5 * 500 * 4e-6, 1e-6);
  t.record(13, 0.01F, 0, 0);
  EXPECT_NEAR(t.arm()["energy_J"].get<double>(), -0.5 * 500 * 4e-6, 1e-6) << "as it ended";
  t.record(14, 0, 0, 1);
  EXPECT_EQ(t.arm()["energy_J"], 0.0);
  t.record(15, 0.01F, 0, 0);
  t.record(16, -0.002F, 1, 1);
  EXPECT_NEAR(t.arm()["energy_J"].get<double>(), -0.5 * 500 * 4e-6, 1e-6) << "it began between two records";
}

TEST(LiveState, SolidsAroundTheTipUntilNothingRenewsThem) {
  Telemetry t;
  t.record(1, 0, 0, 0);
  EXPECT_EQ(t.arm()["inside"], Json::array());
  link::Inside inside;
  inside.object = 3;
  t.take(inside);
  inside.object = 63;
  t.take(inside, kNow_us + 200'000);
  EXPECT_EQ(t.arm()["inside"], Json({3, 63}));
  EXPECT_EQ(t.state.json(kNow_us + 400'000)["arms"][0]["inside"], Json({63})) << "it has left the other";
  inside.arm = 1;
  t.take(inside);
  t.state.forget_scene();
  EXPECT_EQ(t.arm()["inside"], Json::array());
}

TEST(LiveState, PlanesAreThoseOfTheNewestPicture) {
  Telemetry t;
  t.record(1, -0.001F, 1, 2);
  t.take(plane(0, 2, 5, {0, 0, 1}));
  t.take(plane(1, 2, 5, {1, 0, 0}));
  t.take(plane(1, 2, 5, {1, 0, 0}));
  EXPECT_EQ(t.arm()["planes"], Json::parse(R"([{"normal": [0, 0, 1]}, {"normal": [1, 0, 0]}])"));
  t.take(plane(0, 1, 6, {0, 1, 0}));
  EXPECT_EQ(t.arm()["planes"], Json::parse(R"([{"normal": [0, 1, 0]}])"));
  EXPECT_EQ(t.state.json(kNow_us + 400'000)["arms"][0]["planes"], Json::array()) << "nothing renews it";
  t.record(2, 0.001F, 0, 0);
  EXPECT_EQ(t.arm()["planes"], Json::array()) << "contact lost";
}

TEST(LiveState, ThePictureOfAScene) {
  Telemetry t;
  link::BodyPosition position;
  position.object = 4;
  position.sequence = 1;
  position.x_m = 0.01F;
  t.take(position);
  EXPECT_EQ(t.state.json(kNow_us)["bodies"], Json::array()) << "its rotation follows";
  link::BodyRotation rotation;
  rotation.object = 4;
  rotation.sequence = 2;
  t.take(rotation);
  EXPECT_EQ(t.state.json(kNow_us)["bodies"], Json::array()) << "of another picture";
  rotation.sequence = 1;
  rotation.z = 1;
  t.take(rotation);
  link::ControlElementState control;
  control.object = 5;
  control.on = true;
  control.q = 0.25F;
  t.take(control);
  link::TissueState tissue;
  tissue.object = 6;
  tissue.arm = 1;
  tissue.pressed = true;
  tissue.x_m = 0.01F;
  tissue.y_m = 0.02F;
  tissue.depth_m = 0.003F;
  t.take(tissue);
  link::NeedleState needle;
  needle.object = 7;
  needle.inside = true;
  needle.torn = 3;
  needle.depth_m = 0.004F;
  t.take(needle);
  const Json json = t.state.json(kNow_us);
  EXPECT_EQ(json["bodies"],
            Json::parse(R"([{"object": 4, "position_m": [0.01, 0, 0], "rotation": [0, 0, 0, 1]}])"))
      << json;
  EXPECT_EQ(json["controls"], Json::parse(R"([{"object": 5, "q": 0.25, "on": true}])"));
  EXPECT_EQ(
      json["tissues"],
      Json::parse(R"([{"object": 6, "arm": 1, "pressed": true, "at_m": [0.01, 0.02], "depth_m": 0.003}])"));
  EXPECT_EQ(json["needles"],
            Json::parse(
                R"([{"object": 7, "arm": 0, "inside": true, "at_m": [0, 0], "depth_m": 0.004, "torn": 3}])"));
  t.state.forget_scene();
  for (const char* part : {"bodies", "controls", "tissues", "needles"})
    EXPECT_EQ(t.state.json(kNow_us)[part], Json::array());
}

TEST(LiveState, WhyItIsNoLongerArmed) {
  Telemetry t;
  link::DeviceState state;
  state.mode = link::Mode::kReady;
  t.state.take_state(state);
  EXPECT_FALSE(t.state.json(kNow_us).contains("stopped_by"));
  state.stopped_by = link::StoppedBy::kDeadMan;
  t.state.take_state(state);
  EXPECT_EQ(t.state.json(kNow_us)["stopped_by"], "dead_man");
  EXPECT_EQ(t.state.json(kNow_us)["stopped_by_text"], "the dead-man switch was released");
  link::Status status;
  status.mode = link::Mode::kArmed;
  t.take(status);
  EXPECT_FALSE(t.state.json(kNow_us).contains("stopped_by"));
  status.mode = link::Mode::kDamping;
  t.take(status);
  EXPECT_FALSE(t.state.json(kNow_us).contains("stopped_by")) << "an old reason";
}

TEST(LiveState, StatusAndFaults) {
  Telemetry t;
  link::Status status;
  status.mode = link::Mode::kFaulted;
  status.fault = 1;
  status.limiters = link::kLimitSlew;
  status.tick_rate_Hz = 4000;
  t.take(status);
  t.take(link::Emergency{0x9001, 1, 1, 77});
  const Json json = t.state.json(kNow_us);
  EXPECT_EQ(json["mode"], "faulted");
  EXPECT_EQ(json["fault_name"], "e_stop");
  EXPECT_EQ(json["limiters"], Json::array({"slew"}));
  EXPECT_EQ(t.state.take_emergency(), 1);
  EXPECT_EQ(t.state.take_emergency(), std::nullopt);
  t.take(link::Emergency{});
  EXPECT_EQ(t.state.take_emergency(), std::nullopt) << "cleared";
}

}  // namespace
}  // namespace thimble::host
