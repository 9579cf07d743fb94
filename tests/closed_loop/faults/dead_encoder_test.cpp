// What the probes of the encoders find: an encoder that dies while the arm holds a force, with nothing but its counts to tell, and a motor
// with exchanged wires. How soon, what a sound encoder and a still hand feel of the probes, and that nothing sound is taken for a fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iomanip>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "tests/closed_loop/faults/fault_trial.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

using board::Injection;

double setting(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtod(text, nullptr) : otherwise;
}

struct Holding {
  Trial trial;
  std::size_t joint = 0;
};

// A hand that holds the tip in a wall: any arm, direction, force above 0.5 N, stiffness, tremor from none to 50 um.
Holding random_holding(std::mt19937_64& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  Holding holding;
  Trial& trial = holding.trial;
  trial.variant = random() % 2 == 0 ? "premium-1.5" : "wooden";
  trial.rate_Hz = random() % 2 == 0 ? 1000 : 4000;
  const double most_N = trial.variant == "wooden" ? 4.0 : 6.4;
  trial.force_N = std::exp(between(std::log(.6), std::log(most_N)));
  trial.holds.stiffness_N_m = std::exp(between(std::log(200.0), std::log(2000.0)));
  trial.stiffness_N_m = static_cast<float>(between(500, 2000));
  trial.friction = random() % 2 == 0 ? .5F : 0;
  trial.tremor_m = random() % 3 == 0 ? 0 : between(0, 50e-6);
  trial.phase_s = between(0, .4);
  const double lean = between(0, .7), turn = between(0, 2 * std::numbers::pi);
  trial.normal = {std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean)};
  holding.joint = random() % 3;
  return holding;
}

std::string described(const Trial& trial) {
  std::ostringstream text;
  text << std::setprecision(17) << trial.variant << ", " << trial.rate_Hz << " Hz, " << trial.force_N
       << " N, hand " << trial.holds.stiffness_N_m << " N/m, wall " << trial.stiffness_N_m
       << " N/m, friction " << trial.friction << ", normal " << trial.normal.transpose() << ", tremor "
       << trial.tremor_m << ", phase " << trial.phase_s << ", lifts " << trial.lifts_m_s;
  for (const auto& [param, bits] : trial.params)
    text << ", " << firmware::row_of(param).name << ' ' << std::bit_cast<float>(bits);
  return text.str();
}

// Of the joints with kProbed_N or more of the force: a smaller share is not always probed (encoder_probe.h), and the joint gives the hand
// no more than that when it lets go.
constexpr double kProbed_N = .6;
TEST(DeadEncoder, IsFoundWithinHalfASecond) {
  std::mt19937_64 random(static_cast<std::uint64_t>(setting("THIMBLE_DEAD_SEED", 1)));
  const int trials = static_cast<int>(setting("THIMBLE_DEAD_ENCODERS", 24));
  int found = 0, named = 0, with_share = 0;
  double worst_mm = 0, worst_N_s = 0, latest_s = 0, most_not_found_N = 0;
  for (int i = 0; i < trials; ++i) {
    Holding holding = random_holding(random);
    holding.trial.faults = {{.kind = random() % 2 == 0 ? Injection::kEncoderDead : Injection::kEncoderPhaseA,
                             .joint = holding.joint}};
    holding.trial.watch_s = 1;
    const Verdict verdict = judge(holding.trial);
    const bool dead = verdict.fault == firmware::Fault::encoder_frozen;
    const double share_N = verdict.share_N[holding.joint];
    const double after_s = dead ? *verdict.found_s - verdict.last_count_s[holding.joint] : 1.0;
    std::printf(
        "%s %.2f N, tremor %.0f um, joint %zu with %.2f N: %s %.0f ms after its last count, %.2f mm, %.3f N "
        "s\n",
        holding.trial.variant.c_str(), holding.trial.force_N, holding.trial.tremor_m * 1e6, holding.joint,
        share_N, dead ? "found" : "not found", after_s * 1e3, verdict.travel_m * 1e3, verdict.impulse_N_s);
    if (!dead) most_not_found_N = std::max(most_not_found_N, share_N);
    if (share_N < kProbed_N) continue;
    ++with_share;
    found += after_s <= .5 ? 1 : 0;
    named += dead ? 1 : 0;
    latest_s = std::max(latest_s, after_s);
    worst_mm = std::max(worst_mm, verdict.travel_m * 1e3);
    worst_N_s = std::max(worst_N_s, verdict.impulse_N_s);
  }
  figure("dead encoders with a share of 0.6 N or more found within 0.5 s, %", 100.0 * found / with_share,
         ">= 95");
  figure("of them named a fault, %", 100.0 * named / with_share, "reported");
  figure("the greatest share of one that was not found, N", most_not_found_N, "reported");
  figure("the latest after its last count, s", latest_s, "reported");
  figure("travel, mm", worst_mm, "<= 20");
  figure("impulse, N s", worst_N_s, "reported");
  EXPECT_GE(with_share, trials / 4) << "too few to tell";
  EXPECT_GE(found, .95 * with_share);
  EXPECT_LE(worst_mm, 20);
}

// The hand lets go at some time after the encoder has died: if it is before the probe has found it, the force pushes the tip.
TEST(DeadEncoder, WhenTheHandLetsGoFirst) {
  std::mt19937_64 random(static_cast<std::uint64_t>(setting("THIMBLE_DEAD_SEED", 1)));
  const int trials = static_cast<int>(setting("THIMBLE_DEAD_ENCODERS", 24));
  std::vector<double> travel_mm, speed_m_s;
  for (int i = 0; i < trials; ++i) {
    Holding holding = random_holding(random);
    const double go_s = std::uniform_real_distribution(0.0, 1.0)(random);
    holding.trial.faults = {{.kind = Injection::kEncoderDead, .joint = holding.joint}};
    holding.trial.hand = {{.kind = Injection::kHandLetsGo, .at_s = go_s}};
    const Verdict verdict = judge(holding.trial);
    if (verdict.found_s && *verdict.found_s < go_s) {
      EXPECT_LE(verdict.travel_m, .020);
    }
    travel_mm.push_back(verdict.travel_m * 1e3);
    speed_m_s.push_back(verdict.speed_m_s);
  }
  std::ranges::sort(travel_mm);
  std::ranges::sort(speed_m_s);
  for (const double part : {.5, .8, .9, 1.0}) {
    const auto at = static_cast<std::size_t>(part * (trials - 1));
    figure("travel of " + std::to_string(static_cast<int>(part * 100)) + " % of them at most, mm",
           travel_mm[at], "reported");
    figure("speed of as many, m/s", speed_m_s[at], "reported");
  }
}

// What a still hand feels of the probes, pressed against walls of any direction.
TEST(DeadEncoder, AStillHandAtThreeNewtonFeelsLittle) {
  std::mt19937_64 random(static_cast<std::uint64_t>(setting("THIMBLE_DEAD_SEED", 1)) + 3);
  const int trials = static_cast<int>(setting("THIMBLE_DEAD_ENCODERS", 24));
  for (const char* variant : {"premium-1.5", "wooden"}) {
    double most = 0, most_change = 0;
    for (int i = 0; i < trials; ++i) {
      Trial trial = random_holding(random).trial;
      trial.variant = variant;
      trial.force_N = 3;
      trial.tremor_m = 0;
      trial.watch_s = 1;
      const std::vector<Sample> sound = sound_run(trial);
      const Verdict verdict = judge(trial, {sound, sound});  // of the force alone
      std::printf(
          "%s, %.0f Hz, hand %.0f N/m, wall %.0f N/m, shares %.2f %.2f %.2f N: %u probes in 1 s, sag %.1f "
          "%%, "
          "change %.1f %%\n",
          variant, trial.rate_Hz, trial.holds.stiffness_N_m, static_cast<double>(trial.stiffness_N_m),
          verdict.share_N[0], verdict.share_N[1], verdict.share_N[2], verdict.probes, verdict.sag * 100,
          verdict.change * 100);
      EXPECT_EQ(verdict.fault, firmware::Fault::kNone);
      most = std::max(most, verdict.sag);
      most_change = std::max(most_change, verdict.change);
    }
    figure(std::string(variant) + ": sag of 3 N felt by a still hand, %", most * 100, "<= 10");
    figure(std::string(variant) + ": change of it in any direction, %", most_change * 100, "reported");
    EXPECT_LE(most, .10) << variant;
  }
}

// Not found: a joint with a small share of the force, which is not probed, and one that the reversed motor keeps in motion. What the hand
// feels meanwhile is in the table of FaultsFelt.EveryFaultInEverySituation.
TEST(ReversedMotor, InAHandIsFound) {
  std::mt19937_64 random(static_cast<std::uint64_t>(setting("THIMBLE_DEAD_SEED", 1)) + 9);
  const int trials = static_cast<int>(setting("THIMBLE_DEAD_ENCODERS", 24));
  int with_share = 0;
  std::vector<double> found_s;
  for (int i = 0; i < trials; ++i) {
    Holding holding = random_holding(random);
    holding.trial.faults = {{.kind = Injection::kMotorReversed, .joint = holding.joint}};
    holding.trial.watch_s = 3;
    const Verdict verdict = look(holding.trial);
    const double share_N = verdict.share_N[holding.joint];
    std::printf("%s hand %.0f N/m, wall %.0f N/m, %.2f N, joint %zu with %.2f N: fault %d after %.2f s\n",
                holding.trial.variant.c_str(), holding.trial.holds.stiffness_N_m,
                static_cast<double>(holding.trial.stiffness_N_m), holding.trial.force_N, holding.joint,
                share_N, static_cast<int>(verdict.fault), verdict.found_s.value_or(-1));
    if (share_N < kProbed_N) continue;
    ++with_share;
    if (verdict.found_s) found_s.push_back(*verdict.found_s);
  }
  std::ranges::sort(found_s);
  const auto count = static_cast<double>(found_s.size());
  figure("reversed motors with a share of 0.6 N or more found within 3 s, %", 100 * count / with_share,
         ">= 60");
  if (!found_s.empty()) {
    figure("half of them within, s", found_s[found_s.size() / 2], "reported");
    figure("the latest, s", found_s.back(), "reported");
  }
  EXPECT_GE(count, .6 * with_share);
}

// What hot motors do not give cannot move a joint when a probe takes it away: encoder_frozen at the first hand. And no other joint gets it
// during the probe: motor_reversed at the second hand where the torques were scaled, but not the compensation of the weight.
TEST(DeadEncoder, HotMotorsOfASoundArmAreProbedToo) {
  Trial premium;
  premium.rate_Hz = 1000;
  premium.force_N = 5.6277337594881178;
  premium.holds.stiffness_N_m = 1293.4897221444246;
  premium.stiffness_N_m = 1767.48193359375F;
  premium.friction = .5F;
  premium.normal = {-.0042278982599870093, .053432583932694046, .99856250873472052};
  premium.tremor_m = 19.883873138736649e-6;
  premium.phase_s = .11237585917270328;
  premium.lifts_m_s = -.22841509781715253e-3;
  premium.watch_s = 6;
  premium.params = {{firmware::Param::winding_limit, std::bit_cast<std::uint32_t>(38.190483093261719F)}};
  Trial wooden = premium;
  wooden.variant = "wooden";
  wooden.rate_Hz = 4000;
  wooden.force_N = 2.7670749154808512;
  wooden.holds.stiffness_N_m = 895.48294157662383;
  wooden.stiffness_N_m = 1558.7889404296875F;
  wooden.normal = {-.066801598441740925, -.21477798560276223, .97437567875334818};
  wooden.tremor_m = 24.448561334639751e-6;
  wooden.phase_s = .22252076767558077;
  wooden.lifts_m_s = 0;
  wooden.params = {{firmware::Param::winding_limit, std::bit_cast<std::uint32_t>(37.136238098144531F)}};
  for (const Trial& trial : {premium, wooden}) {
    const Verdict verdict = look(trial);
    EXPECT_EQ(verdict.fault, firmware::Fault::kNone) << trial.variant;
    EXPECT_GE(verdict.probes, 10U) << trial.variant;
  }
}

// THIMBLE_STILL_S: simulated seconds, of which the suite runs few.
TEST(DeadEncoder, ASoundEncoderIsNotTakenForADeadOne) {
  std::mt19937_64 random(static_cast<std::uint64_t>(setting("THIMBLE_DEAD_SEED", 1)) + 7);
  const double seconds = setting("THIMBLE_STILL_S", 20);
  std::array<double, 3> held_s{};  // without, with less, with more tremor than 20 um
  std::array<std::uint32_t, 3> probes{};
  for (double done_s = 0, each_s = 0; done_s < seconds; done_s += each_s) {
    Holding holding = random_holding(random);
    each_s = holding.trial.watch_s = random() % 2 == 0 ? 2 : 6;
    // Half of the hands rest; the others come out of the wall, or go on into it, slowly enough for a probe.
    if (random() % 2 == 0) holding.trial.lifts_m_s = std::uniform_real_distribution(-.3e-3, .6e-3)(random);
    // A third of the arms are so hot, from the begin or soon, that the motors give less than the force.
    if (random() % 3 == 0)
      holding.trial.params = {
          {firmware::Param::winding_limit,
           std::bit_cast<std::uint32_t>(std::uniform_real_distribution(36.0F, 60.0F)(random))}};
    const Verdict verdict = look(holding.trial);
    EXPECT_EQ(verdict.fault, firmware::Fault::kNone) << described(holding.trial);
    const double tremor_m = holding.trial.tremor_m;
    const std::size_t kind = tremor_m == 0 ? 0 : tremor_m < 20e-6 ? 1 : 2;
    held_s[kind] += each_s;
    probes[kind] += verdict.probes;
  }
  constexpr std::array<const char*, 3> kTremor = {"none", "below 20 um", "20 to 50 um"};
  for (std::size_t kind = 0; kind < 3; ++kind)
    if (held_s[kind] > 0)
      figure(std::string("probes a minute of contact, tremor ") + kTremor[kind],
             60 * probes[kind] / held_s[kind], "reported");
}

}  // namespace
}  // namespace thimble::test
