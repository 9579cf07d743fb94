// The messages: layout on the wire, rounding and clamping, and docs/link.md, whose tables come from
// messages.def.
#include "firmware/link/messages.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cstdlib>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <type_traits>

namespace thimble::firmware::link {
namespace {

TEST(Messages, PoseOnTheWire) {
  Pose pose;
  pose.x_m = 0.01F;
  pose.y_m = -0.02F;
  pose.z_m = 0.1F;
  pose.arm = 1;
  pose.sequence = 0xFE;
  const CanFrame frame = to_frame(pose, 3);
  EXPECT_EQ(frame.id, 0x183U);
  EXPECT_FALSE(frame.extended);
  const std::array<std::uint8_t, 8> expected = {0xE8, 0x03, 0x30, 0xF8, 0x10, 0x27, 0x01, 0xFE};
  ASSERT_EQ(frame.size, 8);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), frame.data.begin()));

  Pose read;
  EXPECT_TRUE(from_frame(frame, 3, read));
  EXPECT_NEAR(read.x_m, 0.01F, 1e-6F);
  EXPECT_NEAR(read.y_m, -0.02F, 1e-6F);
  EXPECT_EQ(read.sequence, 0xFE);
  EXPECT_FALSE(from_frame(frame, 4, read)) << "another node's";
}

TEST(Messages, IdsAreThoseOfTheDesign) {
  EXPECT_EQ(to_frame(EmergencyStop{}, 5).id, 0x001U);
  EXPECT_EQ(to_frame(Emergency{}, 5).id, 0x085U);
  EXPECT_EQ(to_frame(ForceOrder{}, 5).id, 0x105U);
  EXPECT_EQ(to_frame(Pose{}, 5).id, 0x185U);
  EXPECT_EQ(to_frame(GodObject{}, 5).id, 0x205U);
  EXPECT_EQ(to_frame(Force{}, 5).id, 0x285U);
  EXPECT_EQ(to_frame(ContactPlane{}, 5).id, 0x305U);
  EXPECT_EQ(to_frame(Status{}, 5).id, 0x385U);
  EXPECT_EQ(to_frame(BodyPosition{}, 5).id, 0x405U);
  EXPECT_EQ(to_frame(BodyRotation{}, 5).id, 0x485U);
  EXPECT_EQ(to_frame(ControlState{}, 5).id, 0x505U);
  EXPECT_EQ(to_frame(TissueState{}, 5).id, 0x585U);
  EXPECT_EQ(to_frame(NeedleState{}, 5).id, 0x605U);
  EXPECT_EQ(to_frame(Heartbeat{}, 5).id, 0x705U);
  EXPECT_EQ(request_id(5), 0x18DA05F1U);
  EXPECT_EQ(response_id(5), 0x18DAF105U);
}

TEST(Messages, ValuesOutOfRangeAreClampedAndNotANumberIsZero) {
  Force force;
  force.x_N = 1e9F;
  force.y_N = -1e9F;
  force.z_N = std::numeric_limits<float>::quiet_NaN();
  Force read;
  ASSERT_TRUE(from_frame(to_frame(force, 1), 1, read));
  EXPECT_NEAR(read.x_N, 32.767F, 1e-4F);
  EXPECT_NEAR(read.y_N, -32.768F, 1e-4F);
  EXPECT_EQ(read.z_N, 0.0F);
}

TEST(Messages, ShortInputIsRefusedAndLongerAccepted) {
  std::array<std::uint8_t, 128> buffer{};
  const std::size_t size = encode(FreezeFrame{}, buffer);
  EXPECT_EQ(size, wire_size<FreezeFrame>());
  FreezeFrame read;
  EXPECT_FALSE(decode(std::span(buffer).first(size - 1), read));
  EXPECT_TRUE(decode(std::span(buffer).first(size + 1), read));
  EXPECT_EQ(encode(FreezeFrame{}, std::span(buffer).first(size - 1)), 0U);
}

TEST(MessagesProperty, EveryMessageComesBack) {
  int messages = 0;
  visit_messages([&](auto prototype) {
    using Message = decltype(prototype);
    ++messages;
    EXPECT_TRUE(rc::check(Message::kName, [] {
      Message sent{};
      visit_fields(sent, [](auto wire_value, const char*, auto& value, float scale, auto&&...) {
        const auto any = *rc::gen::arbitrary<decltype(wire_value)>();
        value = wire::from_wire<std::remove_reference_t<decltype(value)>>(any, scale);
      });
      std::array<std::uint8_t, 128> buffer{};
      const std::size_t size = encode(sent, buffer);
      RC_ASSERT(size == wire_size<Message>());
      Message read{};
      RC_ASSERT(decode(std::span(buffer).first(size), read));
      std::array<std::uint8_t, 128> again{};
      RC_ASSERT(encode(read, again) == size);
      RC_ASSERT(buffer == again);
    }));
  });
  EXPECT_EQ(messages, 27);
}

template <class Wire>
const char* wire_name() {
  if constexpr (std::is_same_v<Wire, float>) return "f32";
  if constexpr (std::is_same_v<Wire, std::uint8_t>) return "u8";
  if constexpr (std::is_same_v<Wire, std::uint16_t>) return "u16";
  if constexpr (std::is_same_v<Wire, std::uint32_t>) return "u32";
  if constexpr (std::is_same_v<Wire, std::int16_t>) return "i16";
  if constexpr (std::is_same_v<Wire, std::int32_t>) return "i32";
}

std::string documented() {
  std::ostringstream out;
  visit_messages([&](auto message) {
    using Message = decltype(message);
    out << "\n### " << Message::kName << "\n\n";
    out << (Message::kIsFrame ? "Frame 0x" : "Record 0x") << std::uppercase << std::hex
        << std::setw(Message::kIsFrame ? 3 : 4) << std::setfill('0') << Message::kId << std::dec
        << (Message::kPerNode ? " + node" : "") << ", " << wire_size<Message>() << " bytes. "
        << Message::kDescription << ".\n\n";
    out << "| byte | type | field | step | unit | |\n|---|---|---|---|---|---|\n";
    std::size_t at = 0;
    visit_fields(message, [&](auto wire_value, const char* name, auto&, float scale, const char* unit,
                              const char* text) {
      out << "| " << at << " | " << wire_name<decltype(wire_value)>() << " | " << name << " | " << scale
          << " | " << unit << " | " << text << " |\n";
      at += sizeof(wire_value);
    });
  });
  return out.str();
}

// With THIMBLE_WRITE_DOCS set the tables are written instead of compared.
TEST(Messages, DocsAreGenerated) {
  const std::string file = std::string(THIMBLE_SOURCE_DIR) + "/docs/link.md";
  const std::string begin = "<!-- messages.def begins -->\n";
  const std::string end = "\n<!-- messages.def ends -->";
  std::ifstream in(file);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t from = text.find(begin);
  const std::size_t to = text.find(end);
  ASSERT_TRUE(from != std::string::npos && to != std::string::npos) << file << " lost its marks";
  const std::string written = text.substr(from + begin.size(), to - from - begin.size());
  if (std::getenv("THIMBLE_WRITE_DOCS") != nullptr) {
    std::ofstream(file) << text.replace(from + begin.size(), written.size(), documented());
    return;
  }
  EXPECT_EQ(written, documented())
      << "write it anew: THIMBLE_WRITE_DOCS=1 link_test --gtest_filter=Messages.Docs*";
}

}  // namespace
}  // namespace thimble::firmware::link
