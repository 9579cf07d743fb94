// Every reason that a controller gives for a refusal has a remedy of its own.
#include "host-tools/client/remedies.h"

#include <gtest/gtest.h>

#include <set>

#include "firmware/core/conditions.h"
#include "firmware/core/stop_timeout.h"
#include "firmware/services/refusal.h"

namespace thimble::host {
namespace {

const std::string kWithout = remedy_of("what nobody knows");

TEST(Remedies, EveryReasonHasOne) {
  std::set<std::string> reasons = {"too_many_objects",
                                   "needs_can_fd_or_lower_rate",
                                   "bus_without_can_fd",
                                   "other_hosts_arm",
                                   "no_key",
                                   "key_damaged",
                                   "sound_arm_image",
                                   firmware::kLacksShortStop};
  for (const firmware::BusyRow& row : firmware::kBusyTable) reasons.insert(row.name);
  for (const firmware::ConditionRow& row : firmware::kConditionTable) {
    reasons.insert(row.name);
    EXPECT_EQ(remedy_of(row.name), row.remedy);
  }
  for (const std::string& reason : reasons) {
    EXPECT_FALSE(remedy_of(reason).empty());
    EXPECT_NE(remedy_of(reason), kWithout) << reason;
  }
  EXPECT_EQ(remedy_of("restarting"), "repeat the command when the controller has started again");
}

TEST(Remedies, OfSeveralReasonsAllAreNamed) {
  EXPECT_EQ(remedy_of("not_homed,no_scene"),
            "home the arm (`thimble home`); upload a scene (`thimble upload`)");
  EXPECT_EQ(remedy_of("board_lacks(lost_ticks_above_5_ms)"), remedy_of("board_lacks"));
}

}  // namespace
}  // namespace thimble::host
