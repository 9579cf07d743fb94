// The event line with a line in memory: written where the level changes, once a tick, and low whenever it is switched off.
#include "board/linux/event_line.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

struct Pin {
  bool level = false;
  bool works = true;
  int writes = 0;
};

class PinOutput final : public board::SwitchOutput {
 public:
  explicit PinOutput(Pin& pin) : pin_(pin) {}
  bool set(bool active) noexcept override {
    ++pin_.writes;
    if (pin_.works) pin_.level = active;
    return pin_.works;
  }

 private:
  Pin& pin_;
};

// The board's loop, tick by tick: the pin has the level of the tick's outputs, so it rises in the tick that takes the mark.
TEST(EventLine, RisesInTheTickThatTakesTheMark) {
  Pin pin;
  board::EventLine line;
  line.open(std::make_unique<PinOutput>(pin));
  Bench bench;
  for (int tick = 1; tick <= 2000; ++tick) {
    const bool marks = tick % 400 == 100;
    if (marks) {
      ASSERT_EQ(bench.controller->write_param(0x0191, 1), firmware::ParamStatus::kOk);
    }
    line.write(bench.tick().event);
    EXPECT_EQ(pin.level, tick % 400 >= 100 && tick % 400 < 140) << tick;
  }
  EXPECT_EQ(pin.writes, 10) << "five pulses, and no system call in the other ticks";
}

TEST(EventLine, ALevelThatCouldNotBeSetIsTriedAgain) {
  Pin pin;
  board::EventLine line;
  line.write(true);  // without a line
  line.off();
  line.open(std::make_unique<PinOutput>(pin));
  pin.works = false;
  line.write(true);
  line.write(true);
  EXPECT_EQ(pin.writes, 2);
  pin.works = true;
  line.write(true);
  line.write(true);
  EXPECT_TRUE(pin.level);
  EXPECT_EQ(pin.writes, 3);
}

TEST(EventLine, IsLowWheneverItIsSwitchedOff) {
  Pin pin;
  board::EventLine line;
  line.open(std::make_unique<PinOutput>(pin));
  line.write(true);
  line.off();
  EXPECT_FALSE(pin.level);
  pin.level = true;  // by the other process
  line.off();
  EXPECT_FALSE(pin.level);
  line.write(true);
  EXPECT_TRUE(pin.level) << "the next event";
}

}  // namespace
}  // namespace thimble::test
