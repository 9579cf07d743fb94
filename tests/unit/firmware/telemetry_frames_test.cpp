// What telemetry sends: classic frames, what is opt-in, and one CAN FD frame for all of it.
#include <gtest/gtest.h>

#include "firmware/link/messages.h"
#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/paddle_image.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;

std::vector<link::CanFrame> frames_heard(Bench& bench, int ticks) {
  std::vector<link::CanFrame> frames;
  for (int i = 0; i < ticks; ++i) {
    bench.tick();
    link::CanFrame frame;
    while (bench.controller->next_frame(frame, bench.inputs.time_us)) frames.push_back(frame);
  }
  return frames;
}

template <class Message>
std::vector<Message> messages_in(const std::vector<link::CanFrame>& frames) {
  std::vector<Message> messages;
  for (const link::CanFrame& frame : frames) {
    Message message;
    if (link::from_frame(frame, 1, message)) messages.push_back(message);
  }
  return messages;
}

void set_telemetry(Bench& bench, const char* name, std::uint32_t value) {
  ASSERT_EQ(bench.controller->write_param(firmware::find_param(name)->id, value), firmware::ParamStatus::kOk);
}

TEST(TelemetryFrames, OptInFramesFollowTheirPose) {
  Bench bench;
  bench.start();
  bench.move({0.01, 0, 0.005}, 400);
  EXPECT_TRUE(messages_in<link::JointAngles>(frames_heard(bench, 400)).empty()) << "nobody asked for them";
  set_telemetry(bench, "telemetry_content",
                link::kContentJointAngles | link::kContentMotorCurrents | link::kContentTemperatures |
                    link::kContentTorque);
  frames_heard(bench, 80);
  const auto frames = frames_heard(bench, 400);
  const auto poses = messages_in<link::Pose>(frames);
  const auto angles = messages_in<link::JointAngles>(frames);
  const auto currents = messages_in<link::MotorCurrents>(frames);
  const auto temperatures = messages_in<link::Temperatures>(frames);
  ASSERT_EQ(poses.size(), 10U);
  ASSERT_EQ(angles.size(), poses.size());
  ASSERT_EQ(currents.size(), poses.size());
  ASSERT_EQ(temperatures.size(), poses.size());
  EXPECT_TRUE(messages_in<link::Torque>(frames).empty()) << "the arm has none";
  const firmware::ArmTelemetry& shown = bench.shown().arm[0];
  for (std::size_t j = 0; j < 3; ++j) {
    EXPECT_NEAR(angles.back().angle_rad[j], shown.joint_rad[static_cast<int>(j)], 2e-4F);
    EXPECT_NEAR(currents.back().current_A[j], shown.current_A[static_cast<int>(j)], 2e-2F);
    EXPECT_NEAR(temperatures.back().winding_C[j], shown.winding_C[j], 0.51F);
  }
  EXPECT_EQ(angles.back().sequence, poses.back().sequence);
}

// A lever that turns about y, on a base that is tilted about x; beside it a built-in arm, which has no orientation.
TEST(TelemetryFrames, TheOrientationIsThatOfTheLastLink) {
  Bench bench;
  const Eigen::AngleAxisf tilt(.5F, Eigen::Vector3f::UnitX());
  bench.config.arm_count = 2;
  bench.config.arm[0].base.rotation = tilt.toRotationMatrix();
  firmware::ArmStore store(bench.storage);
  ASSERT_EQ(upload(store, 0, paddle_image("paddle")), firmware::StoreStatus::kOk);
  bench.restart("power_on");
  bench.load();
  bench.home();
  set_telemetry(bench, "telemetry_content", link::kContentOrientation);
  for (const double turn_rad : {0.0, .3, -.6}) {
    for (int i = 0; i < 1000; ++i) {
      bench.joints[0][0] += turn_rad / 1000;
      frames_heard(bench, 1);
    }
    const float angle_rad = bench.shown().arm[0].joint_rad[0];
    EXPECT_EQ(std::abs(angle_rad) > .1F, turn_rad != 0) << "the lever turns";
    Eigen::Quaternionf wanted(tilt * Eigen::AngleAxisf(angle_rad, Eigen::Vector3f::UnitY()));
    if (wanted.w() < 0) wanted.coeffs() = -wanted.coeffs();
    const auto expect = [&wanted](float x, float y, float z) {
      EXPECT_LT((Eigen::Vector3f(x, y, z) - wanted.vec()).norm(), 2e-4F);
    };
    set_telemetry(bench, "telemetry_fd", 0);
    frames_heard(bench, 80);
    const auto orientations = messages_in<link::Orientation>(frames_heard(bench, 400));
    ASSERT_EQ(orientations.size(), 10U);
    for (const link::Orientation& one : orientations) {
      EXPECT_EQ(one.arm, 0);
      expect(one.x, one.y, one.z);
    }
    set_telemetry(bench, "telemetry_fd", 1);
    frames_heard(bench, 80);
    for (const link::CanFrame& frame : frames_heard(bench, 400)) {
      link::ArmRecord record;
      if (!link::from_frame(frame, 1, record)) continue;
      EXPECT_EQ(frame.size, record.arm == 0 ? 64 : 20);
      if (record.arm == 0) expect(record.orientation[0], record.orientation[1], record.orientation[2]);
    }
  }
}

TEST(TelemetryFrames, OneFdFrameARecord) {
  Bench bench;
  bench.start();
  bench.move({0.01, 0, 0.005}, 200);
  bench.move({0.01, 0, -0.003}, 400);
  set_telemetry(bench, "telemetry_fd", 1);
  frames_heard(bench, 80);
  auto frames = frames_heard(bench, 400);
  const auto records = messages_in<link::ArmRecord>(frames);
  EXPECT_EQ(records.size(), 10U);
  EXPECT_TRUE(messages_in<link::Pose>(frames).empty());
  EXPECT_TRUE(messages_in<link::Force>(frames).empty());
  EXPECT_TRUE(messages_in<link::GodObject>(frames).empty());
  EXPECT_NEAR(records.back().tip_m[2], -0.003F, 1e-4F);
  EXPECT_NEAR(records.back().god_object_m[2], 0.0F, 1e-5F);
  EXPECT_NEAR(records.back().force_N[2], bench.shown().arm[0].force_N.z(), 0.05F);
  EXPECT_EQ(records.back().contacts, 1);
  for (const link::CanFrame& frame : frames) EXPECT_TRUE(!frame.fd || frame.size == 20);
  set_telemetry(bench, "telemetry_content", link::kContentJointAngles);
  frames_heard(bench, 80);
  frames = frames_heard(bench, 40);
  ASSERT_EQ(messages_in<link::ArmRecord>(frames).size(), 1U);
  EXPECT_NEAR(messages_in<link::ArmRecord>(frames)[0].angle_rad[0], bench.shown().arm[0].joint_rad[0], 1e-3F);
  for (const link::CanFrame& frame : frames) EXPECT_TRUE(!frame.fd || frame.size == 64);
}

}  // namespace
}  // namespace thimble::test
