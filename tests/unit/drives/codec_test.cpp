// The worked frames of the drives' protocols, byte for byte, and what a codec must never send or accept.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "board/linux/drives/mit.h"
#include "board/linux/drives/moteus.h"
#include "board/linux/drives/odrive.h"
#include "board/linux/drives/unwrap.h"
#include "tests/unit/drives/hex.h"

namespace thimble::test {
namespace {

using namespace board::drives;

std::string without_blanks(std::string text) {
  std::erase(text, ' ');
  return text;
}

// moteus

TEST(MoteusFrames, TorqueWithDamping) {
  const CanFrame frame = moteus::pack_motion(1, {.0375F, .5F, 20}, moteus::Query::kAll);
  EXPECT_EQ(hex_of(frame),
            without_blanks("01000a 02208000 0d229a99193d 062300000040 05271400 1c0401 1100 130d 5050"));
  EXPECT_EQ(frame.id, 0x8001U);
  EXPECT_TRUE(frame.extended);
  EXPECT_TRUE(frame.fd);
  EXPECT_TRUE(frame.bit_rate_switch);
}

TEST(MoteusFrames, ReplyWithTelemetry) {
  const CanFrame frame =
      frame_of_hex(0x100, "2c0401 80d6fcbd 0000003f 2bf6173d 5c8fc23f 21000a 230d301f00 5050505050", true);
  ASSERT_EQ(frame.size, 32);
  Sample sample;
  EXPECT_EQ(moteus::unpack(1, frame, sample).reply, Reply::kMotion);
  EXPECT_FLOAT_EQ(sample.position_rad, -.123456F * kTurn_rad);
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, .5F * kTurn_rad);
  EXPECT_FLOAT_EQ(sample.torque_N_m, .0371F);
  EXPECT_FLOAT_EQ(sample.current_A, 1.52F);
  EXPECT_EQ(sample.stage, Stage::kOn);
  EXPECT_FLOAT_EQ(sample.supply_V, 24);
  EXPECT_FLOAT_EQ(sample.drive_C, 31);
  EXPECT_EQ(sample.drive_fault, 0U);
}

TEST(MoteusFrames, TheShortFormFitsIn24BytesAndItsReplyIn12) {
  const CanFrame frame = moteus::pack_motion(1, {.0375F, .5F, 0}, moteus::Query::kMotion);
  EXPECT_EQ(hex_of(frame), without_blanks("01000a 02208000 0d229a99193d 062300000040 1e01 505050"));
  Sample sample;
  const CanFrame reply = frame_of_hex(0x100, "2e01 0000803f 00000040 5050", true);
  ASSERT_EQ(reply.size, 12);
  EXPECT_EQ(moteus::unpack(1, reply, sample).reply, Reply::kMotion);
  EXPECT_FLOAT_EQ(sample.position_rad, 6.2831853F);
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, 12.566371F);
}

TEST(MoteusFrames, RepliesFromDrive8OnHave29BitIds) {
  for (const unsigned id : {1U, 7U, 8U, 127U}) {
    CanFrame frame = frame_of_hex(id << 8U, "2e01 0000803f 00000000 5050", true);
    EXPECT_EQ(frame.extended, id >= 8);
    Sample sample;
    EXPECT_EQ(moteus::unpack(static_cast<std::uint8_t>(id), frame, sample).reply, Reply::kMotion);
    EXPECT_EQ(moteus::unpack(static_cast<std::uint8_t>(id - 1U), frame, sample).reply, Reply::kOther);
  }
}

// A code of 96 to 103 in the fault register says who limits.
TEST(MoteusFrames, ALimiterIsNoFault) {
  for (int code = 0; code < 128; ++code) {
    CanFrame frame = frame_of_hex(0x100, "210f00 505050505050505050", true);
    frame.data[2] = static_cast<std::uint8_t>(code);
    Sample sample;
    EXPECT_EQ(moteus::unpack(1, frame, sample).reply, Reply::kTelemetry);
    const bool limits = code >= 96 && code <= 103;
    EXPECT_EQ(sample.drive_fault, limits ? 0U : static_cast<unsigned>(code));
    EXPECT_EQ(sample.limiter != Limiter::kNone, limits);
  }
}

// As floats these registers can hold anything.
TEST(MoteusFrames, AFaultThatIsNoNumberIsAFault) {
  for (const char* code :
       {"0000c07f", "0000807f", "000080bf", "00007f4b"}) {  // NaN, infinity, -1, 16 million
    Sample sample;
    (void)moteus::unpack(1, frame_of_hex(0x100, std::string("2d0f") + code + "5050", true), sample);
    EXPECT_NE(sample.drive_fault, 0U) << code;
    (void)moteus::unpack(1, frame_of_hex(0x100, std::string("2d0c") + code + "5050", true), sample);
    EXPECT_EQ(sample.home_state, 0) << code;
  }
}

TEST(MoteusFrames, TheMostNegativeIntegerIsNoValue) {
  Sample sample;
  EXPECT_EQ(moteus::unpack(1, frame_of_hex(0x100, "25010080 25021027 50505050", true), sample).reply,
            Reply::kMotion);
  EXPECT_TRUE(std::isnan(sample.position_rad));
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, 2.5F * kTurn_rad);
}

TEST(MoteusFrames, ARefusedRegisterIsNamed) {
  Sample sample;
  const auto out = moteus::unpack(1, frame_of_hex(0x100, "30a70203 50505050", true), sample);
  EXPECT_EQ(out.reply, Reply::kRejected);
  EXPECT_EQ(out.rejected_register, 0x127);
  EXPECT_EQ(out.error, 3);
}

TEST(MoteusFrames, DiagnosticText) {
  EXPECT_EQ(hex_of(moteus::pack_text(1, "conf get x\n")),
            "40010b636f6e66206765742078"
            "0a420130"
            "505050");
  Sample sample;
  EXPECT_EQ(moteus::unpack(1, frame_of_hex(0x100, "410103 302e31 5050", true), sample).text, "0.1");
}

// No bytes at all may be read beyond the frame or taken for values.
TEST(MoteusFrames, RandomRepliesAreBoundedAndAMalformedOneChangesNothing) {
  std::mt19937 random(1);
  for (int i = 0; i < 20'000; ++i) {
    CanFrame frame = frame_of_hex(0x100, "", true);
    frame.size = firmware::link::fd_size(random() % 65);
    for (std::uint8_t& byte : frame.data)
      byte = static_cast<std::uint8_t>(random() % 4 == 0 ? 0x20 + random() % 16 : random());
    Sample sample;
    sample.position_rad = 1;
    const auto out = moteus::unpack(1, frame, sample);
    if (out.reply == Reply::kMalformed) {
      EXPECT_EQ(sample.position_rad, 1);
    }
    EXPECT_LE(out.text.size(), frame.size);
  }
}

// ODrive

TEST(OdriveFrames, WorkedExamples) {
  const CanFrame loop = odrive::pack_axis_state(3, odrive::AxisState::kClosedLoop);
  EXPECT_EQ(loop.id, 0x067U);
  EXPECT_EQ(hex_of(loop), "0800000000000000");
  const CanFrame modes = odrive::pack_controller_modes(3, odrive::ControlMode::kTorque);
  EXPECT_EQ(modes.id, 0x06BU);
  EXPECT_EQ(hex_of(modes), "0100000001000000");
  const CanFrame torque = odrive::pack_torque(3, .25F);
  EXPECT_EQ(torque.id, 0x06EU);
  EXPECT_EQ(hex_of(torque), "0000803e");
  Sample sample;
  EXPECT_EQ(odrive::unpack(3, false, 1, frame_of_hex(0x069, "0000b0bf0000003f"), sample).reply,
            Reply::kMotion);
  EXPECT_FLOAT_EQ(sample.position_rad, -1.375F * kTurn_rad);
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, .5F * kTurn_rad);
}

TEST(OdriveFrames, TheWatchdogOfBothFirmwares) {
  Sample sample;
  EXPECT_EQ(odrive::unpack(3, false, 1, frame_of_hex(0x061, "0008000001000000"), sample).reply,
            Reply::kTelemetry);
  EXPECT_EQ(sample.stage, Stage::kTimedOut);
  EXPECT_EQ(sample.drive_fault, odrive::kWatchdogError05);
  sample = {};
  EXPECT_EQ(odrive::unpack(3, true, 1, frame_of_hex(0x061, "0000000101030000"), sample).reply,
            Reply::kTelemetry);
  EXPECT_EQ(sample.stage, Stage::kTimedOut);
  EXPECT_EQ(sample.drive_fault, odrive::kWatchdogError06);
  sample = {};  // 0.5: bytes 5 to 7 are errors; 0.6: a result
  (void)odrive::unpack(3, true, 1, frame_of_hex(0x061, "0000000001030000"), sample);
  EXPECT_EQ(sample.stage, Stage::kOff);
  (void)odrive::unpack(3, false, 1, frame_of_hex(0x061, "0000000001010000"), sample);
  EXPECT_EQ(sample.stage, Stage::kFaulted);
}

TEST(OdriveFrames, OwnRequestAndCommandAreNoAnswers) {
  Sample sample;
  for (const CanFrame& own :
       {odrive::pack_request(3, odrive::Message::kEstimates), odrive::pack_clear_errors(3, false)})
    EXPECT_EQ(odrive::unpack(3, false, 1, own, sample).reply, Reply::kOther);
  EXPECT_EQ(odrive::unpack(3, false, 1, odrive::pack_torque(3, 1), sample).reply, Reply::kOther);
  EXPECT_EQ(odrive::unpack(3, false, 1, frame_of_hex(0x069, "0000b0bf"), sample).reply, Reply::kMalformed);
  EXPECT_EQ(odrive::unpack(2, false, 1, frame_of_hex(0x069, "0000b0bf0000003f"), sample).reply,
            Reply::kOther);
  EXPECT_TRUE(std::isnan(sample.position_rad));
}

// MIT mode and Damiao

const mit::Ranges k4310 = mit::ranges_of(12.5F, 30, 10);

TEST(MitFrames, WorkedExamples) {
  const mit::Codes codes{mit::truncated(0, k4310.position), mit::truncated(0, k4310.velocity), 0,
                         mit::truncated(.1F, k4310.kd), mit::truncated(.5F, k4310.torque)};
  EXPECT_EQ(hex_of(mit::pack(1, codes, false)), without_blanks("7fff 7ff0 0005 1865"));
  const mit::Codes zero{mit::truncated(0, k4310.position), mit::truncated(0, k4310.velocity), 0, 0,
                        mit::truncated(0, k4310.torque)};
  EXPECT_EQ(hex_of(mit::pack(1, zero, false)), without_blanks("7fff 7ff0 0000 07ff"));
  EXPECT_NEAR(mit::value_of(zero.torque, k4310.torque), -2.44e-3, 5e-6);
  EXPECT_NEAR(mit::value_of(zero.position, k4310.position), -.19e-3, 1e-6);
  EXPECT_NEAR(mit::value_of(zero.velocity, k4310.velocity), -7.3e-3, 5e-5);
  EXPECT_EQ(hex_of(mit::pack_magic(1, mit::Magic::kEnable, false)), "fffffffffffffffc");
}

TEST(MitFrames, DamiaoReply) {
  Sample sample;
  const CanFrame frame = frame_of_hex(0x11, "11 8ca2 754 865 29 26");
  EXPECT_EQ(mit::unpack(Kind::kDamiao, 1, 0x11, k4310, 0, frame, sample).reply, Reply::kMotion);
  EXPECT_EQ(sample.stage, Stage::kOn);
  EXPECT_NEAR(sample.position_rad, 1.2339, 5e-5);
  EXPECT_NEAR(sample.velocity_rad_s, -2.5128, 5e-5);
  EXPECT_NEAR(sample.torque_N_m, .4957, 5e-5);
  EXPECT_EQ(sample.drive_C, 41);
  EXPECT_EQ(sample.motor_C, 38);
}

TEST(MitFrames, DamiaoErrorNibble) {
  for (unsigned nibble = 0; nibble < 16; ++nibble) {
    CanFrame frame = frame_of_hex(0x11, "01 8ca2 754 865 29 26");
    frame.data[0] = static_cast<std::uint8_t>(nibble << 4U | 1U);
    Sample sample;
    (void)mit::unpack(Kind::kDamiao, 1, 0x11, k4310, 0, frame, sample);
    EXPECT_EQ(sample.drive_fault, nibble <= 1 ? 0 : nibble);
    EXPECT_EQ(sample.stage, nibble == 0     ? Stage::kOff
                            : nibble == 1   ? Stage::kOn
                            : nibble == 0xD ? Stage::kTimedOut
                                            : Stage::kFaulted);
  }
}

TEST(MitFrames, AnotherMotorOnTheSameReplyIdIsNotTaken) {
  Sample sample;
  const CanFrame frame = frame_of_hex(0, "02 8ca2 754 865 80");
  EXPECT_EQ(mit::unpack(Kind::kMiniCheetah, 1, 0, {}, 0, frame, sample).reply, Reply::kOther);
  EXPECT_EQ(mit::unpack(Kind::kMiniCheetah, 2, 0, {}, 0, frame, sample).reply, Reply::kMotion);
  EXPECT_NEAR(sample.supply_V, 128 * 40.0 / 255, 1e-4);
}

// With every value at its limits, beyond them, and NaN excluded: a motion command is never enable, disable, zero or clear.
TEST(MitFrames, NoMotionCommandIsAMagicFrame) {
  mit::Codes top{0xFFFF, 0xFFF, 0xFFF, 0xFFF, 0xFFF};
  for (const unsigned last : {0xFFBU, 0xFFCU, 0xFFDU, 0xFFEU, 0xFFFU}) {
    top.torque = static_cast<std::uint16_t>(last);
    const CanFrame frame = mit::pack(1, top, false);
    for (const auto magic :
         {mit::Magic::kClearError, mit::Magic::kEnable, mit::Magic::kDisable, mit::Magic::kZero})
      EXPECT_NE(hex_of(frame), hex_of(mit::pack_magic(1, magic, false)));
  }
  std::mt19937 random(2);
  std::uniform_real_distribution<float> any(-1e4F, 1e4F);
  mit::Dither dither;
  for (int i = 0; i < 20'000; ++i) {
    const CanFrame frame = mit::pack(1, dither.codes({any(random), any(random)}, k4310), false);
    EXPECT_FALSE(hex_of(frame).starts_with("ffffffff"));
  }
}

// Damping acts against velocity 0, which no code means either.
TEST(MitFrames, TheMeanOfDitheredTorqueIsExact) {
  for (const float damping : {0.0F, .05F, 1.0F, 5.0F})
    for (const float torque : {0.0F, 1e-4F, -.0031F, .5F, -9.5F}) {
      mit::Dither dither;
      double sum = 0;
      constexpr int kTicks = 1000;
      for (int i = 0; i < kTicks; ++i) {
        const mit::Codes codes = mit::codes_of(mit::pack(1, dither.codes({torque, damping}, k4310), false));
        const double kd = static_cast<double>(mit::value_of(codes.kd, k4310.kd));
        const double at_rest = static_cast<double>(mit::value_of(codes.torque, k4310.torque)) +
                               kd * static_cast<double>(mit::value_of(codes.velocity, k4310.velocity));
        EXPECT_NEAR(at_rest, static_cast<double>(torque), 1.01 * static_cast<double>(k4310.torque.step()));
        sum += at_rest;
      }
      EXPECT_NEAR(sum / kTicks, static_cast<double>(torque), 6e-6) << torque << ' ' << damping;
    }
}

TEST(MitFrames, RegistersOfDamiao) {
  EXPECT_EQ(hex_of(mit::pack_read_register(0x101, 23, false)), "0101331700000000");
  EXPECT_EQ(mit::pack_read_register(1, 23, true).id, 0x7FFU);
  Sample sample;
  const CanFrame answer = frame_of_hex(0x11, "0100 33 17 00002041");
  const auto out = mit::unpack(Kind::kDamiao, 1, 0x11, k4310, 23, answer, sample);
  EXPECT_EQ(out.reply, Reply::kAnswer);
  EXPECT_EQ(out.value, 0x41200000U);  // 10.0
  // Not asked for: a motion reply.
  EXPECT_EQ(mit::unpack(Kind::kDamiao, 1, 0x11, k4310, 0, answer, sample).reply, Reply::kMotion);
}

// One full turn, in hex, in every protocol.
TEST(Units, OneTurn) {
  Sample sample;
  (void)moteus::unpack(1, frame_of_hex(0x100, "2e01 0000803f 0000803f 5050", true), sample);
  EXPECT_FLOAT_EQ(sample.position_rad, 6.2831853F);
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, 6.2831853F);
  sample = {};
  (void)odrive::unpack(3, true, 1, frame_of_hex(0x069, "0000803f0000803f"), sample);
  EXPECT_FLOAT_EQ(sample.position_rad, 6.2831853F);
  EXPECT_FLOAT_EQ(sample.velocity_rad_s, 6.2831853F);
  sample = {};
  (void)mit::unpack(Kind::kDamiao, 1, 0x11, k4310, 0, frame_of_hex(0x11, "11 c056 9ac 7ff 00 00"), sample);
  EXPECT_NEAR(sample.position_rad, 6.2831853, 2e-4);
  EXPECT_NEAR(sample.velocity_rad_s, 6.2831853, 7.4e-3);
  // Damping b is b 2 pi in units of turns: ODrive's velocity gain (1 / 2 pi N m s/rad is 1.0), moteus's kd.
  EXPECT_EQ(hex_of(odrive::pack_damping(3, .15915494F)), "0000803f00000000");
  EXPECT_FLOAT_EQ(moteus::kd_scale_of(.15915494F, 2), .5F);
}

TEST(Wrap, IsContinuedByTheNearestAndAJumpIsSeen) {
  const float range = 65536 * k4310.position.step();
  Unwrap unwrap(range, .5F);
  std::uint16_t code = 0x8000;
  double expected = static_cast<double>(mit::value_of(code, k4310.position));
  ASSERT_TRUE(unwrap.take(static_cast<float>(expected)));
  std::mt19937 random(3);
  for (int i = 0; i < 10'000; ++i) {  // the 16 bits overflow, as motorcontrol's do
    const int step = static_cast<int>(random() % 2001) - 800;
    code = static_cast<std::uint16_t>(code + step);
    expected += step * static_cast<double>(k4310.position.step());
    EXPECT_TRUE(unwrap.take(mit::value_of(code, k4310.position)));
    ASSERT_NEAR(unwrap.position_rad(), expected, 1e-3);
  }
  EXPECT_FALSE(
      unwrap.take(mit::value_of(static_cast<std::uint16_t>(code + 16'472), k4310.position)));  // a turn
  EXPECT_TRUE(unwrap.take(mit::value_of(static_cast<std::uint16_t>(code + 16'472), k4310.position)));
}

}  // namespace
}  // namespace thimble::test
