// The device's end of SLCAN, as slcand and python-can use it.
#include "firmware/link/slcan_port.h"

#include <gtest/gtest.h>

#include <string>

namespace thimble::firmware::link {
namespace {

std::string answers(SlcanPort& port, std::string_view bytes) {
  std::string text;
  for (const char byte : bytes) {
    if (port.push(byte) == SlcanPort::Event::kFrame) text += "[frame]";
    text += port.reply();
  }
  return text;
}

TEST(SlcanPort, AnswersWhatSlcandSays) {
  SlcanPort port;
  EXPECT_EQ(answers(port, "C\rS6\rO\r"), "\r\r\r");  // slcand -o -s6
  EXPECT_TRUE(port.open());
  EXPECT_EQ(answers(port, "V\rN\rF\r"), "V1013\rNTHIM\rF00\r");
  EXPECT_EQ(answers(port, "x\r"), "\a");
}

TEST(SlcanPort, GivesFramesOnlyWhileOpen) {
  SlcanPort port;
  EXPECT_EQ(answers(port, "t1232AABB\r"), "\a");
  EXPECT_EQ(answers(port, "O\rt1232AABB\r"), "\r[frame]");
  EXPECT_EQ(port.frame().id, 0x123U);
  EXPECT_EQ(port.frame().size, 2);
  EXPECT_EQ(answers(port, "t12\r"), "\a") << "cut off";
  EXPECT_EQ(answers(port, "C\rt1232AABB\r"), "\r\a");
  EXPECT_FALSE(port.open());
}

TEST(SlcanPort, HearsAStopAlsoWhileClosed) {
  SlcanPort port;
  EXPECT_EQ(answers(port, "t0010\r"), "[frame]");
  EXPECT_EQ(port.frame().id, 1U);
  EXPECT_EQ(answers(port, "T000000010\r"), "\a") << "another identifier";
  EXPECT_FALSE(port.open());
}

TEST(SlcanPort, TellsThatTheHostClosedIt) {
  SlcanPort port;
  EXPECT_EQ(port.push('C'), SlcanPort::Event::kNone);
  EXPECT_EQ(port.push('\r'), SlcanPort::Event::kClosed);
}

}  // namespace
}  // namespace thimble::firmware::link
