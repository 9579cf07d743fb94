// SafetySwitch: open at once, closed only after debouncing.
#include "board/common/safety_switch.h"

#include <gtest/gtest.h>

namespace thimble::test {
namespace {

using board::SafetySwitch;

TEST(SafetySwitch, StartsOpenAndClosesWhenSettled) {
  SafetySwitch contact(5);
  for (int tick = 1; tick < 5; ++tick) EXPECT_FALSE(contact.update(true, false)) << tick;
  for (int tick = 0; tick < 5; ++tick) EXPECT_TRUE(contact.update(true, false));
}

TEST(SafetySwitch, OpensAtOnceAndBouncesDoNotCloseIt) {
  SafetySwitch contact(3);
  for (int tick = 0; tick < 10; ++tick) (void)contact.update(true, false);
  EXPECT_FALSE(contact.update(false, true));
  for (int bounce = 0; bounce < 20; ++bounce) {
    EXPECT_FALSE(contact.update(true, false));
    EXPECT_FALSE(contact.update(true, false));
    EXPECT_FALSE(contact.update(false, false));
  }
}

// The contact opened and closed again between two samples: only the edge tells.
TEST(SafetySwitch, AnOpeningBetweenTwoSamplesCounts) {
  SafetySwitch contact(2);
  (void)contact.update(true, false);
  EXPECT_TRUE(contact.update(true, false));
  EXPECT_FALSE(contact.update(true, true));
  EXPECT_FALSE(contact.update(true, false));
  EXPECT_TRUE(contact.update(true, false));
}

TEST(SafetySwitch, NoTicksToSettleIsOne) {
  SafetySwitch contact(0);
  EXPECT_TRUE(contact.update(true, false));
  EXPECT_FALSE(contact.update(false, false));
}

}  // namespace
}  // namespace thimble::test
