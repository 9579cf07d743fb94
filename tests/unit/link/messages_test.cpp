// The messages: layout on the wire, rounding and clamping, and docs/link.md, whose tables come from
// messages.def.
#include "firmware/link/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <functional>
#include <iomanip>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include "tests/support/generated_docs.h"

namespace thimble::firmware::link {
namespace {

TEST(Messages, PoseOnTheWire) {
  Pose pose;
  pose.x_m = 0.01F;
  pose.y_m = -0.02F;
  pose.z_m = 0.1F;
  pose.arm = 1;
  pose.sequence = 0x0E;
  const CanFrame frame = to_frame(pose, 3);
  EXPECT_EQ(frame.id, 0x183U);
  EXPECT_FALSE(frame.extended);
  const std::array<std::uint8_t, 8> expected = {0x10, 0xE0, 0xE8, 0x03, 0x30, 0xF8, 0x10, 0x27};
  ASSERT_EQ(frame.size, 8);
  EXPECT_TRUE(std::equal(expected.begin(), expected.end(), frame.data.begin()));

  Pose read;
  EXPECT_TRUE(from_frame(frame, 3, read));
  EXPECT_NEAR(read.x_m, 0.01F, 1e-6F);
  EXPECT_NEAR(read.y_m, -0.02F, 1e-6F);
  EXPECT_EQ(read.sequence, 0x0E);
  EXPECT_FALSE(from_frame(frame, 4, read)) << "another node's";
}

TEST(Messages, IdsAreThoseOfTheDesign) {
  EXPECT_EQ(to_frame(EmergencyStop{}, 5).id, 0x001U);
  EXPECT_EQ(to_frame(Emergency{}, 5).id, 0x085U);
  EXPECT_EQ(to_frame(ForceOrder{}, 5).id, 0x105U);
  EXPECT_EQ(to_frame(Pose{}, 5).id, 0x185U);
  EXPECT_EQ(to_frame(Status{}, 5).id, 0x385U);
  EXPECT_EQ(to_frame(BodyPosition{}, 5).id, 0x405U);
  EXPECT_EQ(to_frame(RecordingCheck{}, 5).id, 0x685U);
  EXPECT_EQ(to_frame(Heartbeat{}, 5).id, 0x705U);
  EXPECT_EQ(request_id(5), 0x18DA05F1U);
  EXPECT_EQ(response_id(5), 0x18DAF105U);
}

// There are fifteen base identifiers with a node number below them; more than half are free.
TEST(Messages, AtMostSevenBaseIdentifiersAreUsed) {
  std::set<unsigned> bases;
  visit_messages([&](auto message) {
    using Message = decltype(message);
    if (!Message::kIsFrame || !Message::kPerNode) return;
    EXPECT_EQ(Message::kId % 0x80U, 0U) << Message::kName;
    bases.insert(Message::kId);
  });
  EXPECT_LE(bases.size(), 7U);
}

// One row a message: the pairs below are then tried by one loop, which compiles in a fraction of what a template for each pair takes.
struct FrameMessage {
  const char* name;
  CanFrame frame;
  std::size_t wire_bytes;
  bool (*reads)(const CanFrame& frame);
};

TEST(Messages, FramesOfOneIdentifierAreToldApartByTheirKind) {
  std::vector<FrameMessage> messages;
  visit_messages([&](auto message) {
    using Message = decltype(message);
    if constexpr (Message::kIsFrame) {
      messages.push_back(
          {Message::kName, to_frame(message, 1), wire_size<Message>(), [](const CanFrame& frame) {
             Message read;
             return from_frame(frame, 1, read);
           }});
    }
  });
  ASSERT_GT(messages.size(), 10U);
  for (const FrameMessage& sent : messages) {
    EXPECT_TRUE(is_valid(sent.frame)) << sent.name;
    EXPECT_EQ(sent.frame.fd, sent.wire_bytes > kClassicDataBytes) << sent.name;
    for (const FrameMessage& read : messages) {
      EXPECT_EQ(read.reads(sent.frame), &read == &sent) << sent.name << " as " << read.name;
    }
  }
}

TEST(Messages, WhatIsLeftOutOfAnArmRecordIsZero) {
  ArmRecord record;
  record.god_object_m = {0.01F, 0.02F, 0.03F};
  record.angle_rad.back() = 1.0F;
  record.current_A.back() = -20.0F;
  CanFrame frame = to_frame(record, 1);
  EXPECT_EQ(frame.size, 64);
  ArmRecord read;
  ASSERT_TRUE(from_frame(frame, 1, read));
  EXPECT_NEAR(read.angle_rad.back(), 1.0F, 1e-4F);
  EXPECT_NEAR(read.current_A.back(), -20.0F, 1e-2F);
  EXPECT_EQ(read.winding_C.back(), 0.0F);
  frame.size = least_size<ArmRecord>();
  EXPECT_EQ(frame.size, 20);
  ASSERT_TRUE(from_frame(frame, 1, read));
  EXPECT_NEAR(read.god_object_m[2], 0.03F, 1e-6F);
  EXPECT_EQ(read.angle_rad.back(), 0.0F);
  frame.size = 16;
  EXPECT_FALSE(from_frame(frame, 1, read));
}

TEST(Messages, BitsFollowEachOtherFromTheLowestOfTheByte) {
  Force force;
  force.contacts = 2;
  force.limiters = kLimitSlew | kLimitThermal;
  force.arm = 1;
  const CanFrame felt = to_frame(force, 1);
  EXPECT_EQ(felt.data[0] | felt.data[1] << 8U, 1U | 1U << 4U | 2U << 6U | 10U << 8U);
  RecordingCheck check;
  check.tick = 5;
  check.mode = Mode::kArmed;
  check.command = RecordedCommand::kDisarm;
  check.last = true;
  check.levels.dead_man = check.levels.index[1] = check.levels.drive_fault[3] = true;
  const CanFrame frame = to_frame(check, 1);
  EXPECT_EQ(frame.data[0] | frame.data[1] << 8U, 3U | 5U << 3U | 1U << 14U);
  EXPECT_EQ(frame.data[6] | frame.data[7] << 8U, 3U | 3U << 3U | 1U << 6U | 1U << 9U | 1U << 15U);
  RecordingCheck read;
  ASSERT_TRUE(from_frame(frame, 1, read));
  EXPECT_EQ(read.mode, Mode::kArmed);
  EXPECT_EQ(read.command, RecordedCommand::kDisarm);
  EXPECT_EQ(read.levels, check.levels);
}

TEST(Messages, RecordingMarkOnTheWire) {
  RecordingMark mark;
  mark.tick = 5;
  mark.what = MarkKind::kTrial;
  mark.value = 0x1234;
  mark.before = 0x5678;
  mark.number = 0x9ABC;
  const CanFrame frame = to_frame(mark, 1);
  EXPECT_EQ(frame.id, 0x681U);
  EXPECT_EQ(frame.data[0] | frame.data[1] << 8U, 5U | 5U << 3U | 1U << 14U);
  EXPECT_EQ(frame.data[2] | frame.data[3] << 8U, 0x1234U);
  EXPECT_EQ(frame.data[4] | frame.data[5] << 8U, 0x5678U);
  EXPECT_EQ(frame.data[6] | frame.data[7] << 8U, 0x9ABCU);
}

// That of firmware which does not tell the marks.
TEST(Messages, AShorterRecordingStateHasNoMarks) {
  RecordingState state;
  state.ticks = 7;
  state.marks = 3;
  std::array<std::uint8_t, wire_size<RecordingState>()> bytes{};
  ASSERT_EQ(encode(state, bytes), bytes.size());
  RecordingState read;
  EXPECT_FALSE(decode(std::span(bytes).first(9), read));
  ASSERT_TRUE(decode(std::span(bytes).first(10), read));
  EXPECT_EQ(read.ticks, 7U);
  EXPECT_EQ(read.marks, 0U);
  ASSERT_TRUE(decode(bytes, read));
  EXPECT_EQ(read.marks, 3U);
}

TEST(Messages, NeedleStateOnTheWire) {
  NeedleState needle;
  needle.object = 5;
  needle.arm = 1;
  needle.inside = true;
  needle.torn = 3;
  needle.depth_m = 0.0124F;  // 310 steps
  needle.x_m = -0.002F;
  needle.y_m = 0.001F;
  const CanFrame frame = to_frame(needle, 3);
  EXPECT_EQ(frame.id, 0x403U);
  // kind 5 and object 5 in 10 bits, arm 1 in 2, inside; torn 3 begins at bit 13; depth at bit 19.
  const std::uint32_t head = 5U | 5U << 3U | 1U << 10U | 1U << 12U | 3U << 13U | 310U << 19U;
  const std::array<std::uint8_t, 8> bytes = {static_cast<std::uint8_t>(head),
                                             static_cast<std::uint8_t>(head >> 8U),
                                             static_cast<std::uint8_t>(head >> 16U),
                                             static_cast<std::uint8_t>(head >> 24U),
                                             0x9C,
                                             0xFF,
                                             50,
                                             0};
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), frame.data.begin()));
  NeedleState read;
  ASSERT_TRUE(from_frame(frame, 3, read));
  EXPECT_EQ(read.torn, 3);
  EXPECT_NEAR(read.depth_m, 0.0124F, 1e-6F);
}

TEST(Messages, OfAWholeNumberTheLowBitsTravel) {
  RecordingCounts counts;
  counts.tick = 0xFFFF;
  counts.arm = 1;
  RecordingCounts read;
  ASSERT_TRUE(from_frame(to_frame(counts, 1), 1, read));
  EXPECT_EQ(read.tick, 0x7FF);
  EXPECT_EQ(read.arm, 1);
}

TEST(Messages, NumbersThatHaveNames) {
  EXPECT_STREQ(name(Mode::kArmed), "armed");
  EXPECT_STREQ(name(RecordingEnd::kHostForces), "host_forces");
  EXPECT_STREQ(name(static_cast<Mode>(200)), "unknown");
  EXPECT_TRUE(EnumTable<Limiter>::kIsFlagSet);
  visit_enums([](auto table) {
    unsigned long long seen = 0;
    for (const EnumRow& row : decltype(table)::kRows) {
      ASSERT_LT(row.number, 256U);
      const unsigned long long bit = decltype(table)::kIsFlagSet ? row.number : 1ULL << (row.number % 64);
      EXPECT_EQ(seen & bit, 0U) << decltype(table)::kName << ": " << row.name << " has the number of another";
      seen |= bit;
    }
  });
}

// Rows of whole bytes begin at one.
TEST(Messages, FieldsBeginAtBytes) {
  std::size_t fields = 0;
  std::vector<std::string> between_bytes;
  visit_messages([&](auto message) {
    visit_numbers(message, [&](auto row, auto&, Place) {
      using Of = decltype(row);
      ++fields;
      if (Of::kBits == 8 * sizeof(typename Of::Wire) && row.at % 8 != 0) between_bytes.emplace_back(row.name);
    });
  });
  EXPECT_GT(fields, 100U);
  EXPECT_THAT(between_bytes, testing::IsEmpty());
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

// Encodes a message with these bits in its fields, decodes it and encodes it again.
template <class Message>
bool comes_back(const std::function<std::uint32_t()>& bits) {
  Message sent{};
  visit_numbers(sent, [&](auto row, auto& value, Place) {
    using Of = decltype(row);
    if constexpr (!Of::kIsKind)
      value = wire::from_bits<Of, std::remove_reference_t<decltype(value)>>(bits() & wire::kMask<Of::kBits>,
                                                                            row.scale);
  });
  std::array<std::uint8_t, 256> buffer{};
  const std::size_t size = encode(sent, buffer);
  Message read{};
  std::array<std::uint8_t, 256> again{};
  return size == wire_size<Message>() && decode(std::span(buffer).first(size), read) &&
         encode(read, again) == size && buffer == again;
}

TEST(MessagesProperty, EveryMessageComesBack) {
  struct Row {
    const char* name;
    bool (*comes_back)(const std::function<std::uint32_t()>&);
  };
  std::vector<Row> messages;
  visit_messages([&](auto message) {
    using Message = decltype(message);
    messages.push_back({Message::kName, comes_back<Message>});
  });
  EXPECT_EQ(messages.size(), 50U);
  for (const Row& message : messages) {
    EXPECT_TRUE(rc::check(message.name, [&] {
      RC_ASSERT(message.comes_back([] { return *rc::gen::arbitrary<std::uint32_t>(); }));
    }));
  }
}

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

// "u8", "4 bits", "i16[3]". count: 0 for what is no array.
std::string type_name(char letter, std::size_t wire_bits, std::size_t bits, std::size_t count) {
  std::string name = bits == wire_bits ? letter + std::to_string(bits)
                     : bits == 1       ? "1 bit"
                                       : std::to_string(bits) + " bits";
  return count == 0 ? name : name + "[" + std::to_string(count) + "]";
}

template <class Of, class Value>
std::string type_name() {
  using Number = typename Of::Wire;
  std::size_t count = 0;
  if constexpr (kIsArray<Value>) count = std::tuple_size_v<Value>;
  return type_name(std::is_same_v<Number, float> ? 'f'
                   : std::is_signed_v<Number>    ? 'i'
                                                 : 'u',
                   8 * sizeof(Number), Of::kBits, count);
}

template <class Of, class Value>
std::string enum_name() {
  if constexpr (kIsArray<Value>) {
    return enum_name<Of, typename Value::value_type>();
  } else if constexpr (!std::is_void_v<typename Of::Flags>) {
    return EnumTable<typename Of::Flags>::kName;
  } else if constexpr (TableEnum<Value>) {
    return EnumTable<Value>::kName;
  } else {
    return "";
  }
}

void document_row(std::ostream& out, const std::string& name, const std::string& type, unsigned at,
                  std::size_t bits, double step, const char* unit, const std::string& of,
                  const std::string& text) {
  out << "| " << at / 8;
  if (at % 8 != 0 || bits % 8 != 0) out << "." << at % 8;
  out << " | " << type << " | " << name << " | " << step << " | " << unit << " | ";
  if (!of.empty()) out << "[" << of << "](#" << lower(of) << ")" << (text.empty() ? "" : ": ");
  out << text << " |\n";
}

template <class Message>
void document_rows(std::ostream& out, const Message& message, unsigned at, const std::string& prefix) {
  visit_fields(
      message,
      [&](auto row, const auto& value) {
        using Value = std::remove_cvref_t<decltype(value)>;
        if constexpr (kIsPart<Value>) {
          document_rows(out, value, row.at, prefix + row.name + ".");
        } else {
          using Of = decltype(row);
          std::string text = row.description;
          if constexpr (Of::kIsKind)
            text = std::to_string(static_cast<unsigned>(value)) + " (" + name(value) + ")";
          document_row(out, prefix + row.name, type_name<Of, Value>(), row.at, Of::kBits,
                       static_cast<double>(row.scale), row.unit, enum_name<Of, Value>(), text);
        }
      },
      at);
}

std::string documented() {
  std::ostringstream out;
  visit_messages([&](auto message) {
    using Message = decltype(message);
    out << "\n### " << Message::kName << "\n\n";
    out << (Message::kIsFrame ? "Frame 0x" : "Record 0x") << std::uppercase << std::hex
        << std::setw(Message::kIsFrame ? 3 : 4) << std::setfill('0') << Message::kId << std::dec
        << (Message::kPerNode ? " + node" : "") << ", " << wire_size<Message>()
        << (wire_size<Message>() == 1 ? " byte. " : " bytes. ") << Message::kDescription << ".\n\n";
    out << "| byte.bit | type | field | step | unit | |\n|---|---|---|---|---|---|\n";
    document_rows(out, message, 0, "");
  });
  visit_enums([&](auto table) {
    using Table = decltype(table);
    out << "\n### " << Table::kName << "\n\n" << Table::kDescription << ".\n\n";
    out << (Table::kIsFlagSet ? "| mask | name | |" : "| number | name | |") << "\n|---|---|---|\n";
    for (const EnumRow& row : Table::kRows)
      out << "| " << row.number << " | " << row.name << " | " << row.description << " |\n";
  });
  return out.str();
}

// The example runs only in the emulated machine of vm.example_client; this finds an old number within a second.
TEST(Messages, TheExampleSpeaksThisProtocol) {
  std::ifstream file(THIMBLE_SOURCE_DIR "/docs/examples/can_client.py");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_THAT(text, testing::HasSubstr("\nPROTOCOL = " + std::to_string(kProtocolVersion) + " "));
}

TEST(Messages, DocsAreGenerated) { test::expect_generated("docs/link.md", "messages.def", documented()); }

}  // namespace
}  // namespace thimble::firmware::link
