// SLCAN against the lines that slcand's and CANable's documents show, round trips, and whatever bytes there
// are.
#include "firmware/link/slcan.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace thimble::firmware::link {
namespace {

std::string line_of(const CanFrame& frame) {
  SlcanLine line;
  return {line.data(), encode_slcan(frame, line)};
}

std::vector<SlcanParser::Event> parse(SlcanParser& parser, std::string_view text) {
  std::vector<SlcanParser::Event> events;
  for (const char c : text) {
    const SlcanParser::Event event = parser.push(c);
    if (event != SlcanParser::Event::kNone) events.push_back(event);
  }
  return events;
}

using Events = std::vector<SlcanParser::Event>;
constexpr auto kFrame = SlcanParser::Event::kFrame;
constexpr auto kCommand = SlcanParser::Event::kCommand;
constexpr auto kAck = SlcanParser::Event::kAck;
constexpr auto kRefused = SlcanParser::Event::kRefused;
constexpr auto kBad = SlcanParser::Event::kBad;

CanFrame frame_of(std::uint32_t id, bool extended, std::vector<std::uint8_t> bytes) {
  CanFrame frame;
  frame.id = id;
  frame.extended = extended;
  frame.size = static_cast<std::uint8_t>(bytes.size());
  std::copy(bytes.begin(), bytes.end(), frame.data.begin());
  return frame;
}

TEST(Slcan, LinesOfTheKernelsDocument) {
  // Linux, drivers/net/can/slcan: t1230, t4563112233, T12ABCDEF2AA55, r1230.
  EXPECT_EQ(line_of(frame_of(0x123, false, {})), "t1230\r");
  EXPECT_EQ(line_of(frame_of(0x456, false, {0x11, 0x22, 0x33})), "t4563112233\r");
  EXPECT_EQ(line_of(frame_of(0x12ABCDEF, true, {0xAA, 0x55})), "T12ABCDEF2AA55\r");
  CanFrame remote = frame_of(0x123, false, {});
  remote.remote = true;
  EXPECT_EQ(line_of(remote), "r1230\r");
  remote.extended = true;
  remote.size = 4;
  EXPECT_EQ(line_of(remote), "R000001234\r");

  SlcanParser parser;
  EXPECT_EQ(parse(parser, "T12ABCDEF2AA55\r"), Events{kFrame});
  EXPECT_EQ(parser.frame(), frame_of(0x12ABCDEF, true, {0xAA, 0x55}));
  EXPECT_EQ(parse(parser, "t4563112233\rr1230\r"), (Events{kFrame, kFrame}));
  EXPECT_TRUE(parser.frame().remote);
}

TEST(Slcan, FdLines) {
  CanFrame frame = frame_of(0x7FF, false, std::vector<std::uint8_t>(12, 0x5A));
  frame.fd = true;
  EXPECT_EQ(line_of(frame), "d7FF9" + std::string("5A5A5A5A5A5A5A5A5A5A5A5A") + "\r");
  frame.bit_rate_switch = true;
  EXPECT_EQ(line_of(frame).substr(0, 5), "b7FF9");
  frame.extended = true;
  EXPECT_EQ(line_of(frame).substr(0, 10), "B000007FF9");
  frame.bit_rate_switch = false;
  EXPECT_EQ(line_of(frame).substr(0, 10), "D000007FF9");
}

TEST(Slcan, CommandsAndAnswers) {
  SlcanParser parser;
  EXPECT_EQ(parse(parser, "C\rS8\rO\r"), (Events{kCommand, kCommand, kCommand}));
  EXPECT_EQ(std::string(parser.command().data(), parser.command().size()), "O");
  EXPECT_EQ(parse(parser, "\r\a\r"), (Events{kAck, kRefused, kAck}));
  EXPECT_EQ(parse(parser, "t1230\r\n"), Events{kFrame}) << "a terminal sends CR LF";
}

TEST(Slcan, BadLinesAreDroppedWhole) {
  SlcanParser parser;
  for (const char* line :
       {"t\r", "t12\r", "t123\r", "t1239001122334455667788\r", "t12g0\r", "t1232AA\r", "t1231AA55\r",
        "t8000\r", "T200000000\r", "T1234567\r", "r1230AA\r", "d7FF95A\r", "t1232A G5\r"}) {
    EXPECT_EQ(parse(parser, line), Events{kBad}) << line;
  }
  EXPECT_EQ(parser.bad_lines(), 13U);
  const std::string too_long = "T" + std::string(500, '0');
  EXPECT_EQ(parse(parser, too_long + "\r"), Events{kBad});
  EXPECT_EQ(parse(parser, "t1231AA\r"), Events{kFrame}) << "and the next is good again";
}

TEST(Slcan, FramesThatCannotBeOnABusAreNotEncoded) {
  EXPECT_EQ(line_of(frame_of(0x800, false, {})), "");
  CanFrame frame = frame_of(1, false, {});
  frame.size = 9;
  EXPECT_EQ(line_of(frame), "");
  frame.fd = true;
  EXPECT_EQ(line_of(frame), "");
  frame.size = 12;
  EXPECT_NE(line_of(frame), "");
  frame.remote = true;
  EXPECT_EQ(line_of(frame), "");
}

CanFrame arbitrary_frame() {
  CanFrame frame;
  frame.extended = *rc::gen::arbitrary<bool>();
  frame.id = *rc::gen::inRange<std::uint32_t>(0, frame.extended ? 0x20000000U : 0x800U);
  frame.fd = *rc::gen::arbitrary<bool>();
  frame.bit_rate_switch = frame.fd && *rc::gen::arbitrary<bool>();
  frame.remote = !frame.fd && *rc::gen::arbitrary<bool>();
  frame.size = size_of_length_code(*rc::gen::inRange<std::uint8_t>(0, frame.fd ? 16 : 9));
  if (!frame.remote) {
    for (std::size_t i = 0; i < frame.size; ++i) frame.data[i] = *rc::gen::arbitrary<std::uint8_t>();
  }
  return frame;
}

TEST(SlcanProperty, RoundTripInAnySlices) {
  EXPECT_TRUE(rc::check("encode, then parse, is the frame", [] {
    const CanFrame frame = arbitrary_frame();
    SlcanParser parser;
    const std::string line = line_of(frame);
    RC_ASSERT(!line.empty());
    const bool noise = *rc::gen::arbitrary<bool>();
    const Events events = parse(parser, noise ? "Tzz\r" + line : line);
    RC_ASSERT(events == (noise ? Events{kBad, kFrame} : Events{kFrame}));
    RC_ASSERT((frame.remote ? parser.frame().id == frame.id : parser.frame() == frame));
  }));
}

TEST(SlcanProperty, ATruncatedLineIsNeverAnotherFrame) {
  EXPECT_TRUE(rc::check("cut lines are bad", [] {
    CanFrame frame = arbitrary_frame();
    const std::string line = line_of(frame);
    const auto keep = *rc::gen::inRange<std::size_t>(1, line.size() - 1);
    SlcanParser parser;
    RC_ASSERT(parse(parser, line.substr(0, keep) + "\r") == Events{kBad});
  }));
}

TEST(SlcanProperty, AnyBytesAreSurvived) {
  EXPECT_TRUE(rc::check("no byte breaks it", [] {
    SlcanParser parser;
    for (const char c : *rc::gen::arbitrary<std::string>()) {
      if (parser.push(c) == kFrame) RC_ASSERT(is_valid(parser.frame()));
    }
    (void)parse(parser, "\r");
    RC_ASSERT(parse(parser, "t1231AA\r") == Events{kFrame});
  }));
}

}  // namespace
}  // namespace thimble::firmware::link
