// The display of `thimble monitor`: magnitudes and signs of forces, and no line wider than the terminal.
#include "host-tools/cli/monitor_screen.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace thimble::host {
namespace {

namespace link = firmware::link;
using testing::HasSubstr;
using testing::Not;

link::CanFrame force_frame(float x_N, float z_N, std::uint8_t contacts) {
  link::Force force;
  force.x_N = x_N;
  force.z_N = z_N;
  force.contacts = contacts;
  return link::to_frame(force, 1);
}

MonitorScreen with_force(float x_N, float z_N, bool utf8 = true) {
  MonitorScreen screen("premium-1.5 on board sim", 1, utf8);
  link::Status status;
  status.mode = link::Mode::kArmed;
  status.limiters = link::kLimitClamp;
  status.tick_rate_Hz = 4000;
  status.worst_tick_s = 12e-6F;
  screen.take(link::to_frame(status, 1));
  link::Pose pose;
  pose.x_m = 0.0123F;
  pose.y_m = -0.004F;
  screen.take(link::to_frame(pose, 1));
  screen.take(force_frame(x_N, z_N, 1));
  screen.step();
  return screen;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) all.push_back(line);
  return all;
}

std::size_t count(const std::string& text, const std::string& what) {
  std::size_t n = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
  return n;
}

TEST(MonitorScreen, SaysWhyItIsNoLongerArmedUntilItIsAgain) {
  MonitorScreen screen = with_force(0.0F, 1.0F);
  link::Status status;
  status.mode = link::Mode::kReady;
  screen.take(link::to_frame(status, 1));
  screen.stopped("the dead-man switch was released");
  EXPECT_THAT(screen.text(120), HasSubstr("ready (the dead-man switch was released)"));
  status.mode = link::Mode::kArmed;
  screen.take(link::to_frame(status, 1));
  EXPECT_THAT(screen.text(120), Not(HasSubstr("released")));
}

TEST(MonitorScreen, SaysNoModeBeforeItHasHeardOne) {
  MonitorScreen screen("premium-1.5 on board sim", 1, true);
  screen.take(force_frame(0.0F, 1.0F, 1));
  screen.step();
  EXPECT_THAT(screen.text(120), HasSubstr("waiting for its status"));
  EXPECT_THAT(screen.text(120), Not(HasSubstr("disarmed")));
}

TEST(MonitorScreen, SaysHowTheControllerDoes) {
  const std::string text = with_force(0.0F, 1.0F).text(120);
  EXPECT_THAT(text, HasSubstr("armed"));
  EXPECT_THAT(text, HasSubstr("no fault"));
  EXPECT_THAT(text, HasSubstr("4000 Hz, worst tick 12.0 us"));
  EXPECT_THAT(text, HasSubstr("limiters: clamp"));
  EXPECT_THAT(text, HasSubstr("x   12.30   y   -4.00   z    0.00 mm   contacts 1"));
}

TEST(MonitorScreen, BarsGrowWithTheForceToItsSide) {
  const std::vector<std::string> all =
      lines(with_force(-1.0F, 2.0F, false).text(80));  // scale 5 N: 30 characters
  EXPECT_THAT(all[2], HasSubstr("######|"));
  EXPECT_EQ(count(all[2], "#"), 6U);
  EXPECT_EQ(count(all[3], "#"), 0U);
  EXPECT_THAT(all[4], HasSubstr("|############"));
  EXPECT_EQ(count(all[4], "#"), 12U);
  EXPECT_EQ(count(lines(with_force(-1.0F, 2.0F).text(80))[4], "█"), 12U);
}

TEST(MonitorScreen, TheCurveHasTheLargestForceOfEachStep) {
  MonitorScreen screen = with_force(0.0F, 1.0F, true);
  for (const float force_N : {0.0F, 0.5F, 0.25F}) {
    screen.take(force_frame(0.0F, force_N, 0));
    screen.take(force_frame(0.0F, 0.0F, 0));
    screen.step();
  }
  EXPECT_THAT(screen.text(80), HasSubstr("█ ▄▂"));
  EXPECT_THAT(screen.text(80), HasSubstr("most 1.00 of 1 N"));
}

TEST(MonitorScreen, SaysWhatTheTipHasToLeave) {
  MonitorScreen screen = with_force(0.0F, 0.0F);
  EXPECT_THAT(screen.text(80), Not(HasSubstr("move out")));
  link::Inside inside;
  inside.object = 3;
  screen.take(link::to_frame(inside, 1));
  EXPECT_THAT(screen.text(80), HasSubstr("  inside object 3: move out\n"));
  screen.name(3, "lamp");
  for (int i = 0; i < 5; ++i) screen.step();
  EXPECT_THAT(screen.text(80), HasSubstr("  inside lamp: move out\n"));
  screen.step();
  EXPECT_THAT(screen.text(80), Not(HasSubstr("move out"))) << "nothing told it for half a second";
}

TEST(MonitorScreen, NoLineIsLongerThanTheTerminal) {
  MonitorScreen screen = with_force(3.0F, -7.0F);
  for (int i = 0; i < 1000; ++i) screen.step();
  for (const std::size_t columns : {0U, 1U, 7U, 20U, 37U, 80U, 300U, 1000U}) {
    for (const std::string& line : lines(screen.text(columns))) {
      EXPECT_LE(
          static_cast<std::size_t>(std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; })),
          columns);
    }
  }
}

TEST(MonitorScreen, AFaultIsNamedAndAnotherNodeIsNone) {
  MonitorScreen screen("x", 1, true);
  link::Status status;
  status.mode = link::Mode::kFaulted;
  status.fault = 1;
  screen.take(link::to_frame(status, 2));
  EXPECT_THAT(screen.text(80), HasSubstr("waiting for its status"));
  screen.take(link::to_frame(status, 1));
  EXPECT_THAT(screen.text(80), HasSubstr("FAULT e_stop"));
  EXPECT_THAT(screen.text(80), Not(HasSubstr("arm 0")));
}

}  // namespace
}  // namespace thimble::host
