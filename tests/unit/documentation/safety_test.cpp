// The hazards of docs/safety.md: what stops each, and which tests show it. The table is generated from here, and each test that it names
// exists.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/generated_docs.h"

namespace thimble::test {
namespace {

struct Hazard {
  std::string_view what, stopped_by, bar;
  std::vector<std::string> tests;
};

const std::vector<Hazard> kHazards = {
    {"too great a force, or one that comes at once",
     "`max_force`, the arm's own limit, `force_slew`; what a limit keeps back going in it does not give "
     "coming out",
     "never over the limits; no energy from 10 000 writes and swaps in contact beyond what a tick's sampling "
     "gives",
     {"Limits.ForceNeverExceedsClampSlewOrRamp", "Limits.RandomWritesAndSwapsInContactGiveNoEnergy"}},
    {"sensor, motor, drive or tick fails with a hand at the arm",
     "the faults of [faults.md](faults.md): brakes or off",
     "the table below; a pair of faults: both limits together",
     {"FaultsFelt.EveryFaultInEverySituation", "FaultsFelt.PairsOfFaultsAtRandom"}},
    {"an encoder dies unnoticed while the arm holds a force",
     "line-loss receivers, or the probe",
     "found within 0.5 s in 95 % of the joints with 0.6 N or more; 20 mm",
     {"DeadEncoder.IsFoundWithinHalfASecond", "DeadEncoder.AStillHandAtThreeNewtonFeelsLittle"}},
    {"the servo hangs; its process is stopped or killed",
     "guardian, heartbeat and hardware watchdog ([wiring](board-linux.md))",
     "off within max(2 ms, (`lost_ticks` + 1) periods), at most 5 ms",
     {"Guardian.ActsWhenTheServoHangs", "Guardian.ActsWhenTheBoardIsStopped",
      "StopTimeout.IsBetween2And5MsAndToleratesTheLostTicks", "vm.board_failures"}},
    {"a motor drive on CAN falls silent or restarts, has another configuration, or its host is gone",
     "the other drives brake, then all are off; its own watchdog; not armed ([below](#motor-drives-on-can))",
     "10 to 20 ticks after the last command, 25 ms for mini-cheetah and CubeMars; never on again by itself",
     {"DriveTraps.WhenTheHostIsSilentEachDriveDoesWhatItsKindDoes",
      "DriveTraps.ADriveThatRestartsIsNotEnabledAgain", "DriveTraps.AWatchdogThatIsOffRefusesArming",
      "vm.board_drives"}},
    {"a stop is overtaken by another request",
     "a stop waits for nothing, and is answered after the tick that obeyed it",
     "every stop of random orders without a pause is obeyed",
     {"Disarm.RandomOrdersWithoutAPause", "Disarm.IsHeardWhileAnotherRequestFromTheAddressIsPending"}},
    {"nobody can stop it",
     "`thimble stop`, Esc and the button on the page, `stop()` in Python, the e-stop input",
     "repeated until the status confirms it",
     {"e2e.hosts", "viewer.page.browser"}},
    {"an arm that moves by itself meets a person",
     "force limit of the move, blocked, sign of life every 0.5 s",
     "brakes within 0.1 s of whatever ends it; 0.5 s after the host's last sign",
     {"GuardedMove.StopsAtTheForceLimitAndGoesBack", "GuardedMove.EveryStopStopsIt",
      "GuardedMove.ItsEndInsideASolidOfTheSceneThrowsNothing"}},
    {"an axis is driven for a commissioning",
     "the order's limits of torque, way, speed and energy, `max_force` times the lever, sign of life every "
     "0.5 s",
     "ends in the tick of a stop or a limit; 0.5 s after the host's last sign",
     {"AxisSource.EveryStopEndsItInItsTick", "AxisSource.NoAxisPushesMoreThanTheMaxForce",
      "AxisDrive.AnyOrderIsLimitedAndEnds"}},
    {"the host vanishes, or a recorder is killed while armed",
     "`host_supervision`; a watcher disarms",
     "disarmed however it ends",
     {"e2e.record"}},
    {"a motor overheats, also over restarts",
     "thermal model, in the journal; `store_fails` where the store does not take it",
     "never below the motor's own temperature; below its limit",
     {"HeatOverRestart.ARestartEveryThirtySecondsForTenMinutes",
      "HeatOverRestart.TheModelIsNotBelowTheMotorWheneverPowerFails",
      "HeatOverRestart.AStoreThatTakesNothingRefusesArming",
      "Thermal.IsNotBelowTheMotorHoweverLongTheLoopStands"}},
    {"the board crashes again and again with a scene or parameters",
     "`set_aside`: the fourth start is without them",
     "three crashes",
     {"CrashLoop.AfterThreeCrashesTheFourthStartIsWithoutTheScene"}},
    {"the board works with another arm than the one on the table: its stored image is damaged",
     "`store_corrupt`, and `board_lacks(sound_arm_image)` until an image has been uploaded; neither an older "
     "image nor the built-in arm takes its place",
     "not armed, wherever the image or its header is damaged, the mark of the slot excepted; power lost at "
     "any "
     "byte of an upload leaves the old arm, the new one, or a board that does not arm",
     {"ArmStore.DamageIsAFaultAndKeepsTheArmFromArmingUntilTheNextUpload",
      "ArmStore.SurvivesPowerLossAtEveryByte", "ArmStore.DamageOutlivesAnUploadThatIsBrokenOffAtAnyByte",
      "e2e.model_upload"}},
    {"the board drives an arm with the wiring of another one",
     "`stored_model` names the arm that `thimble-board` is wired for: with another one nothing of it is "
     "opened, and "
     "`board_lacks(no_stored_model)` refuses to arm; after the upload of an arm the program starts anew, "
     "with that "
     "arm's signs and ratios",
     "not armed",
     {"BoardConfig.AnArmThatTheStoreMustHaveIsWiredWhenItHasIt", "vm.board_drives"}},
    {"an arm is not what its file says",
     "`thimble commission`; `arm_not_commissioned` while its file has not passed, or was changed since, and "
     "`max_force` is above 1 N; `allow_uncommissioned` is in the audit record",
     "not armed; armed with 1 N, no greater `max_force` is taken",
     {"Uncommissioned.OnlySuchAnArmIsRefused", "Uncommissioned.ArmedItStaysBelow",
      "Uncommissioned.TheBraveAllowItAndItIsRecorded", "e2e.model_upload"}},
    {"a damaged store",
     "`store_corrupt`: what is damaged is left out",
     "said at the start",
     {"StoreCorrupt.IsSaidOfTheNewestContentsAndNotOfAnInterruptedSave"}},
    {"another user's program or a web page commands the arm",
     "[SECURITY.md](../SECURITY.md)",
     "refused",
     {"e2e.other_users", "e2e.view_hostile", "e2e.simulator"}},
    {"two programs command at once, or one that must not",
     "the lease, and the key ([link.md](link.md#who-commands))",
     "every command refused, every stop obeyed, in random orders of three hosts; nothing but the proof opens",
     {"Lease.RandomOrdersOfThreeHosts", "Access.NothingButTheProofOpens", "e2e.access"}},
    {"bytes that nobody trusts",
     "bounds in every reader",
     "no crash in the kept corpora and in random bytes",
     {"fuzz"}},
    {"what nobody has thought of",
     "random play with faults, hosts, stops and restarts",
     "no fault without a reason in an hour; a day in the long check",
     {"Endurance.OneHandPlaysOnAndOn", "Endurance.AnotherHandPlaysOnAndOn"}},
};

std::string text_of_tests() {
  std::string text;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(THIMBLE_SOURCE_DIR "/tests")) {
    const std::string name = entry.path().filename().string();
    if (!name.ends_with("_test.cpp") && name != "CMakeLists.txt") continue;
    std::ifstream in(entry.path());
    text.append(std::istreambuf_iterator<char>(in), {});
  }
  return text;
}

TEST(Safety, EveryHazardHasItsTests) {
  const std::string tests = text_of_tests();
  std::string rows = "| hazard | what stops it | bar of the tests | tests |\n|---|---|---|---|\n";
  for (const Hazard& hazard : kHazards) {
    std::string names;
    for (const std::string& test : hazard.tests) {
      names += (names.empty() ? "`" : ", `") + test + "`";
      const std::size_t dot = test.find('.');
      const bool of_gtest = test.front() >= 'A' && test.front() <= 'Z';
      const std::string known = of_gtest ? "(" + test.substr(0, dot) + ", " + test.substr(dot + 1) + ")"
                                         : test.substr(test.rfind('.') + 1);
      EXPECT_NE(tests.find(known), std::string::npos) << "no test is named " << test;
    }
    rows += "| " + std::string(hazard.what) + " | " + std::string(hazard.stopped_by) + " | " +
            std::string(hazard.bar) + " | " + names + " |\n";
  }
  rows.pop_back();
  expect_generated("docs/safety.md", "hazards", rows);
}

}  // namespace
}  // namespace thimble::test
