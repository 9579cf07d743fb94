// Every fault that can be injected, and pairs of them, while the arm does something and a hand is at it: how far and how fast the tip
// goes, and what the hand is given, beyond what the hand does itself (fault_trial.h).
//
// The limits, and where they come from, for a tip of 0.08 kg with a hand's 0.05 kg that presses with 6.4 N:
//   seen     what one tick can see. Until it acts, at most 5 periods of 1 ms pass: 6.4 N for 5 ms are 0.032 N s and 0.6 mm
//   shown    what the drive or the encoder's receiver shows, after some ms
//   probed   a dead encoder, or a drive that does not follow, without any such sign, found by the probe before the hand lets go
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include "tests/closed_loop/faults/fault_trial.h"
#include "tests/support/figure.h"
#include "tests/support/generated_docs.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using board::Injection;
using board::PlannedFault;

struct Limits {
  double travel_m, impulse_N_s;
};
constexpr Limits kSeen{.003, .05}, kShown{.010, .1}, kProbed{.020, .2}, kReported{1e9, 1e9};
constexpr double kOff_s = .25 + .002;  // drives off, after the fault was found

struct Case {
  double value = 0;
  Limits limits{};
  bool found = true;  // in contact the drives go off
};

const std::map<Injection, Case>& cases() {
  static const std::map<Injection, Case> kCases = {
      {Injection::kEncoderDead, {.limits = kProbed}},
      {Injection::kEncoderCable, {.limits = kSeen}},
      {Injection::kEncoderPhaseA, {.limits = kProbed}},
      {Injection::kEncoderPhaseB, {.limits = kProbed}},
      {Injection::kEncoderSlip, {.value = 60, .limits = kSeen}},
      {Injection::kEncoderStuck, {.value = 77, .limits = kSeen}},
      {Injection::kSamplesStale, {.limits = kSeen}},
      {Injection::kMotorReversed, {.limits = kReported, .found = false}},
      {Injection::kAmplifierStuck, {.value = 3, .limits = kShown}},
      {Injection::kConverterStuck, {.limits = kProbed}},
      {Injection::kSupply, {.value = .5, .limits = kShown}},
      {Injection::kDriveFault, {.limits = kSeen}},
      {Injection::kEStop, {.limits = kSeen}},
      {Injection::kDeadMan, {.limits = kSeen}},
      {Injection::kTickLost, {.value = 5, .limits = kSeen}},
      {Injection::kTickHung, {.limits = kSeen}},
      // Not found: counts that are lost slowly, and what the loop tolerates.
      {Injection::kEncoderDrift, {.value = 500, .limits = kReported, .found = false}},
      {Injection::kIndexMissing, {.limits = kSeen, .found = false}},
      {Injection::kIndexElsewhere, {.value = .1, .limits = kSeen, .found = false}},
      {Injection::kTickLate, {.value = 1, .limits = kSeen, .found = false}},
      {Injection::kTickJitter, {.value = 1, .limits = kSeen, .found = false}},
      {Injection::kMotorWeak, {.value = .5, .limits = kReported, .found = false}},
  };
  return kCases;
}

// Of link, store and process: in the pairs.
const std::map<Injection, Case>& cases_of_the_board() {
  static const std::map<Injection, Case> kCases = {
      {Injection::kLinkCut, {.limits = kSeen}},
      {Injection::kLinkDelay, {.value = .05, .limits = kSeen}},
      {Injection::kLinkDuplicate, {.limits = kSeen}},
      {Injection::kLinkFlood, {.value = 5000, .limits = kSeen}},
      {Injection::kStorageTorn, {.value = 10, .limits = kSeen}},
      {Injection::kProcessKilled, {.limits = kSeen}},
  };
  return kCases;
}

const Case& case_of(Injection kind) {
  const auto found = cases().find(kind);
  return found != cases().end() ? found->second : cases_of_the_board().at(kind);
}

PlannedFault planned(Injection kind, std::size_t joint) {
  return {.kind = kind, .joint = joint, .value = case_of(kind).value};
}

const char* name_of(Injection kind) {
  return board::injections()[static_cast<std::size_t>(kind)].name.data();
}

// Without a sign of its receiver.
bool is_dead_encoder(Injection kind) {
  return kind == Injection::kEncoderDead || kind == Injection::kEncoderPhaseA ||
         kind == Injection::kEncoderPhaseB;
}

// The worst of what one fault does in all situations.
struct Worst {
  double travel_m = 0, speed_m_s = 0, impulse_N_s = 0, found_s = 0;
  bool always_found = true;
};

std::vector<Trial> situations() {
  std::vector<Trial> all;
  for (const char* variant : {"premium-1.5", "wooden"}) {
    for (const double rate_Hz : {1000.0, 4000.0}) {
      Trial trial;
      trial.variant = variant;
      trial.rate_Hz = rate_Hz;
      trial.watch_s = .7;
      trial.sensors = {.current = true, .supply = true, .index = true};
      for (const Doing doing : {Doing::kFree, Doing::kContact, Doing::kHoming, Doing::kMove}) {
        // In free motion the motors carry the arm's weight only, while homing they are off: one rate of each arm will do.
        const bool gentle = doing == Doing::kFree || doing == Doing::kHoming;
        if (gentle && (rate_Hz == 1000) != (trial.variant == "wooden")) continue;
        trial.doing = doing;
        // A wall that leans loads all three joints.
        trial.normal = doing == Doing::kContact ? Eigen::Vector3d(.5, .3, 1) : Eigen::Vector3d(0, 0, 1);
        all.push_back(trial);
      }
    }
  }
  return all;
}

std::string told(const Trial& trial, Injection kind) {
  static constexpr std::array<const char*, 4> kDoing = {"free", "contact", "homing", "move"};
  return std::string(name_of(kind)) + " " + kDoing[static_cast<std::size_t>(trial.doing)] + " " +
         trial.variant + " " + std::to_string(static_cast<int>(trial.rate_Hz)) + " Hz";
}

void expect_within(Trial trial, const References& references, Injection kind, std::size_t joint,
                   const Case& expected, Worst& worst) {
  trial.faults = {planned(kind, joint)};
  trial.sensors.line_loss = kind == Injection::kEncoderCable;  // with it no probe looks for dead encoders
  const Verdict verdict = judge(trial, references);
  const std::string what = told(trial, kind) + " joint " + std::to_string(joint);
  std::printf("%-50s %2d found %7.1f off %7.1f ms  travel %6.2f mm  speed %5.2f m/s  impulse %6.3f N s\n",
              what.c_str(), static_cast<int>(verdict.fault), verdict.found_s.value_or(-.001) * 1e3,
              verdict.off_s.value_or(-.001) * 1e3, verdict.travel_m * 1e3, verdict.speed_m_s,
              verdict.impulse_N_s);
  EXPECT_LE(verdict.travel_m, expected.limits.travel_m) << what;
  EXPECT_LE(verdict.impulse_N_s, expected.limits.impulse_N_s) << what;
  EXPECT_TRUE(!verdict.found_s || (verdict.off_s && *verdict.off_s - *verdict.found_s <= kOff_s)) << what;
  EXPECT_FALSE(verdict.armed_again) << what;
  worst.travel_m = std::max(worst.travel_m, verdict.travel_m);
  worst.speed_m_s = std::max(worst.speed_m_s, verdict.speed_m_s);
  worst.impulse_N_s = std::max(worst.impulse_N_s, verdict.impulse_N_s);
  if (trial.doing != Doing::kContact) return;
  EXPECT_TRUE(verdict.off_s || !expected.found) << what << ": the drives stay on";
  worst.found_s = std::max(worst.found_s, verdict.off_s.value_or(0));
  worst.always_found = worst.always_found && verdict.off_s;
}

std::string table(const std::map<Injection, Worst>& worst) {
  std::string rows =
      "| fault | off after, ms | travel, mm | speed, m/s | impulse, N s |\n|---|---|---|---|---|\n";
  for (const auto& [kind, w] : worst) {
    char row[200];
    const std::string off =
        w.always_found ? std::to_string(std::lround(std::ceil(w.found_s * 1e3))) : "stays on";
    (void)std::snprintf(row, sizeof(row), "| `%s`: %s | %s | %.1f | %.2f | %.3f |\n", name_of(kind),
                        board::injections()[static_cast<std::size_t>(kind)].text.data(), off.c_str(),
                        w.travel_m * 1e3, w.speed_m_s, w.impulse_N_s);
    rows += row;
  }
  rows.pop_back();
  return rows;
}

TEST(FaultsFelt, EveryFaultInEverySituation) {
  std::map<Injection, Worst> worst;
  for (const Trial& trial : situations()) {
    const References both = references(trial);
    for (const auto& [kind, expected] : cases()) {
      const bool of_joint =
          board::injections()[static_cast<std::size_t>(kind)].of == board::InjectionOf::kJoint;
      const bool each = of_joint && trial.doing == Doing::kMove && !is_dead_encoder(kind);
      for (std::size_t joint = each ? 0 : 1; joint < (each ? 3 : 2); ++joint)
        expect_within(trial, both, kind, joint, expected, worst[kind]);
    }
  }
  expect_generated("docs/safety.md", "faults", table(worst));
}

// The highest rates of the boards: no limit is another one there.
TEST(FaultsFelt, EveryFaultInContactAtFastRates) {
  for (const double rate_Hz : {10'000.0, 20'000.0}) {
    Trial trial;
    trial.rate_Hz = rate_Hz;
    trial.watch_s = .7;
    trial.sensors = {.current = true, .supply = true, .index = true};
    trial.normal = {.5, .3, 1};
    const References both = references(trial);
    Worst unused;
    for (const auto& [kind, expected] : cases()) expect_within(trial, both, kind, 1, expected, unused);
  }
}

// Two faults, the second up to 0.2 s after the first, whatever the hand does meanwhile: no more than both limits together, from the
// instant of the first. THIMBLE_FAULT_PAIRS: how many; THIMBLE_FAULT_SEED.
TEST(FaultsFelt, PairsOfFaultsAtRandom) {
  const auto setting = [](const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text != nullptr ? static_cast<int>(std::strtol(text, nullptr, 10)) : otherwise;
  };
  Random random(static_cast<std::uint64_t>(setting("THIMBLE_FAULT_SEED", 1)));
  std::vector<Trial> where = situations();
  std::vector<Injection> kinds;
  for (const auto& [kind, expected] : cases())
    if (expected.limits.travel_m < kReported.travel_m) kinds.push_back(kind);
  for (const auto& [kind, expected] : cases_of_the_board()) kinds.push_back(kind);
  Worst worst;
  for (int i = 0; i < setting("THIMBLE_FAULT_PAIRS", 24); ++i) {
    Trial trial = where[random.below(where.size())];
    trial.arms = trial.doing == Doing::kContact && random.below(3) == 0 ? 2 : 1;
    trial.friction = trial.doing == Doing::kContact && random.below(2) == 0 ? .5F : 0;
    trial.tremor_m = random.uniform(0, 30e-6);
    trial.supervised = random.below(2) == 0;
    if (random.below(2) == 0) trial.hand = {{.kind = Injection::kHandHolds}};
    if (trial.hand.empty() && trial.doing != Doing::kMove && random.below(2) == 0)
      trial.hand = {{.kind = Injection::kHandPushes, .force_N = 2 * random.direction(), .for_s = .1}};
    const std::array<Injection, 2> pair = {kinds[random.below(kinds.size())],
                                           kinds[random.below(kinds.size())]};
    trial.faults = {planned(pair[0], random.below(3)), planned(pair[1], random.below(3))};
    trial.faults[1].at_s = random.uniform(0, .2);
    // A joint that the move does not need is not watched well enough: the test after this one has its figures.
    for (PlannedFault& fault : trial.faults)
      if (trial.doing == Doing::kMove && is_dead_encoder(fault.kind)) fault.joint = 1;
    trial.sensors.line_loss = pair[0] == Injection::kEncoderCable || pair[1] == Injection::kEncoderCable;
    const Verdict verdict = judge(trial);
    const std::string what = told(trial, pair[0]) + " of joint " + std::to_string(*trial.faults[0].joint) +
                             ", " + name_of(pair[1]) + " of joint " + std::to_string(*trial.faults[1].joint) +
                             " after " + std::to_string(trial.faults[1].at_s).substr(0, 5) + " s";
    const Limits a = case_of(pair[0]).limits, b = case_of(pair[1]).limits;
    std::printf("%-100s %2d travel %6.2f mm  speed %5.2f m/s  impulse %6.3f N s\n", what.c_str(),
                static_cast<int>(verdict.fault), verdict.travel_m * 1e3, verdict.speed_m_s,
                verdict.impulse_N_s);
    EXPECT_LE(verdict.travel_m, a.travel_m + b.travel_m) << what;
    EXPECT_LE(verdict.impulse_N_s, a.impulse_N_s + b.impulse_N_s) << what;
    EXPECT_TRUE(!verdict.found_s || (verdict.off_s && *verdict.off_s - *verdict.found_s <= kOff_s)) << what;
    EXPECT_FALSE(verdict.armed_again) << what;
    worst.travel_m = std::max(worst.travel_m, verdict.travel_m);
    worst.impulse_N_s = std::max(worst.impulse_N_s, verdict.impulse_N_s);
  }
  figure("pairs of faults: travel, mm", worst.travel_m * 1e3, "<= both limits");
  figure("pairs of faults: impulse, N s", worst.impulse_N_s, "<= both limits");
}

// No hand is at an arm that moves by itself. A dead encoder of a joint that the move does not need drifts for long before a torque shows
// it: reported, in docs/safety.md under what is not covered.
TEST(FaultsFelt, DeadEncodersOfAnArmThatMovesByItself) {
  for (Trial trial : situations()) {
    if (trial.doing != Doing::kMove) continue;
    const References both = references(trial);
    for (std::size_t joint = 0; joint < 3; ++joint) {
      trial.faults = {planned(Injection::kEncoderDead, joint)};
      const Verdict verdict = judge(trial, both);
      const std::string what = trial.variant + " " + std::to_string(static_cast<int>(trial.rate_Hz)) +
                               " Hz, joint " + std::to_string(joint);
      figure(what + ": travel, mm", verdict.travel_m * 1e3, joint == 1 ? "<= 20" : "reported");
      figure(what + ": speed, m/s", verdict.speed_m_s, "reported");
      if (joint == 1) {
        EXPECT_LE(verdict.travel_m, kProbed.travel_m) << what;
      }
    }
  }
}

// No value of a parameter makes a force last that nothing renews, nor the watch over a move duller.
TEST(FaultsFelt, NoParameterMakesThemWorse) {
  for (Trial trial : situations()) {
    if (trial.doing == Doing::kContact) {
      trial.params = {{firmware::Param::encoder_stale_ticks, 100}};
      trial.faults = {planned(Injection::kSamplesStale, 0)};
    } else if (trial.doing == Doing::kMove) {
      trial.params = {{firmware::Param::encoder_frozen, std::bit_cast<std::uint32_t>(2.0F)},
                      {firmware::Param::encoder_frozen_time, std::bit_cast<std::uint32_t>(10.0F)}};
      trial.faults = {planned(Injection::kEncoderDead, 1)};
    } else {
      continue;
    }
    const Verdict verdict = judge(trial);
    const bool stale = trial.doing == Doing::kContact;
    const std::string what = told(trial, trial.faults[0].kind);
    figure(what + ": off after, ms", verdict.off_s.value_or(1e6) * 1e3, stale ? "<= 5" : "reported");
    figure(what + ": travel, mm", verdict.travel_m * 1e3, stale ? "<= 3" : "<= 20");
    EXPECT_LE(verdict.travel_m, stale ? kSeen.travel_m : kProbed.travel_m) << what;
    EXPECT_TRUE(verdict.off_s && (!stale || *verdict.off_s < .005 + 1e-6)) << what;
  }
}

// Nobody measures the currents, and the hand leaves the wall slowly: no probe begins, and the last force stays. Reported, in docs/safety.md
// under what is not covered.
TEST(FaultsFelt, AStuckConverterThatNobodyMeasures) {
  for (const char* variant : {"premium-1.5", "wooden"}) {
    Trial trial;
    trial.variant = variant;
    trial.lifts_m_s = .05;
    trial.friction = .5F;
    trial.watch_s = 1;
    trial.faults = {planned(Injection::kConverterStuck, 0)};
    const Verdict verdict = judge(trial);
    figure(std::string(variant) + ": off after, ms", verdict.off_s.value_or(-.001) * 1e3, "reported");
    figure(std::string(variant) + ": impulse in a second, N s", verdict.impulse_N_s, "reported");
  }
}

TEST(FaultsFelt, WhatCanBeInjected) {
  static constexpr std::array<const char*, 3> kOf = {"joint", "arm", "board"};
  std::string rows = "| fault | of | value | |\n|---|---|---|---|\n";
  for (const board::InjectionRow& row : board::injections())
    rows += "| `" + std::string(row.name) + "` | " + kOf[static_cast<std::size_t>(row.of)] + " | " +
            std::string(row.unit) + " | " + std::string(row.text) + " |\n";
  rows.pop_back();
  expect_generated("docs/safety.md", "injections", rows);
}

// A fault of the arm's hardware without a case would not be judged. What else can be injected (link, store, process, hand) is in
// docs/safety.md with the test that has it.
TEST(FaultsFelt, NoFaultOfAnArmIsForgotten) {
  for (const board::InjectionRow& row : board::injections()) {
    if (row.of == board::InjectionOf::kBoard || row.kind >= Injection::kHandLetsGo) continue;
    EXPECT_TRUE(cases().contains(row.kind)) << row.name;
  }
}

}  // namespace
}  // namespace thimble::test
