// The heat of the motors survives a restart: judged by an independent integration in double precision.
#include "firmware/store/persistent_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdio>
#include <memory>
#include <vector>

#include "firmware/core/thermal.h"
#include "kinematics/built_in_arms.h"
#include "tests/unit/firmware/audit_entries.h"
#include "tests/unit/firmware/bench.h"

namespace thimble::test {
namespace {

using firmware::Journal;
using firmware::PersistentState;
using firmware::Storage;

constexpr std::uint32_t kMorning = 1800000000;  // UTC
constexpr float kRate_Hz = 1000;
constexpr double kLimit_C = 100;

firmware::Config slow() {
  firmware::Config config;
  config.period_s = 1 / kRate_Hz;
  return config;
}

// The windings as they are: the equations of thermal.h for the currents that the controller gives, at the period, in double. They know
// nothing of restarts.
class TrueMotors {
 public:
  void run(Bench& bench, double seconds) {
    const auto& motor = bench.data[0].axis[0].motor;
    const auto period_s = static_cast<double>(bench.config.period_s);
    for (int i = 0; i < static_cast<int>(seconds / period_s); ++i) {
      bench.tick();
      for (std::size_t j = 0; j < 3; ++j) {
        const auto current_A = static_cast<double>(bench.outputs.arm[0].current_A[j]);
        step(motor, bench.outputs.arm[0].enable ? current_A : 0, period_s, j);
      }
    }
  }
  void rest(const kinematics::MotorModel& motor, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds / 0.01); ++i)
      for (std::size_t j = 0; j < 3; ++j) step(motor, 0, 0.01, j);
  }
  [[nodiscard]] double hottest_C() const { return hottest_C_; }
  [[nodiscard]] double winding_C(std::size_t j) const { return 25 + winding_[j]; }

 private:
  void step(const kinematics::MotorModel& motor, double current_A, double h, std::size_t j) {
    const auto r_wh = static_cast<double>(motor.winding_to_housing_K_W);
    const auto r_ha = static_cast<double>(motor.housing_to_ambient_K_W);
    const double loss =
        current_A * current_A * static_cast<double>(motor.resistance_ohm) * (1 + 0.00393 * winding_[j]);
    const double flow = (winding_[j] - housing_[j]) / r_wh;
    winding_[j] += h * (loss - flow) * r_wh / static_cast<double>(motor.winding_time_constant_s);
    housing_[j] +=
        h * (flow - housing_[j] / r_ha) * r_ha / static_cast<double>(motor.housing_time_constant_s);
    hottest_C_ = std::max(hottest_C_, 25 + winding_[j]);
  }
  std::array<double, 3> winding_{}, housing_{};
  double hottest_C_ = 0;
};

// A hand that presses with all that the arm gives; disarmed before where it is armed.
void press(Bench& bench) {
  if (bench.controller->fault() != Fault::kNone) {
    bench.ticks(300);  // the brake
    ASSERT_EQ(bench.controller->request(Command::kClear), 0);
    bench.ticks(2);
  }
  bench.place({0, 0, 0.001});
  bench.home();
  bench.arm();
  bench.move({0.02, 0.02, -0.015}, 300);
}

float shown_C(const Bench& bench) { return std::ranges::max(bench.shown().arm[0].winding_C); }

// Until telemetry has a record of now.
float model_C(Bench& bench) {
  bench.ticks(200);
  return shown_C(bench);
}

std::unique_ptr<Bench> loaded(firmware::Config config = slow()) {
  auto bench = std::make_unique<Bench>(config);
  bench->load(4000);
  bench->ticks(2);
  return bench;
}

TEST(HeatOverRestart, AMinuteOfHardUseThenARestart) {
  for (const char* reason : {"power_on", "host", "crash", "watchdog"}) {
    const auto bench = loaded();
    TrueMotors motors;
    press(*bench);
    motors.run(*bench, 60);
    const double before_C = motors.hottest_C();
    bench->restart(reason);
    press(*bench);
    motors.run(*bench, 60);
    std::printf("[ figure   ] %s: hottest winding before %.1f C, after %.1f C; the model %.1f C\n", reason,
                before_C, motors.hottest_C(), static_cast<double>(shown_C(*bench)));
    EXPECT_GT(before_C, 85) << "it was hard use";
    EXPECT_LT(motors.hottest_C(), kLimit_C) << reason;
    EXPECT_GE(static_cast<double>(shown_C(*bench)), motors.winding_C(2) - 1);
  }
}

TEST(HeatOverRestart, ARestartEveryThirtySecondsForTenMinutes) {
  for (const char* reason : {"power_on", "host", "crash"}) {
    const auto bench = loaded();
    TrueMotors motors;
    for (int i = 0; i < 20; ++i) {
      if (i != 0) bench->restart(reason);
      if (bench->controller->store().image_bytes() == 0) bench->load(4000);  // it was set aside
      press(*bench);
      motors.run(*bench, 30);
    }
    std::printf("[ figure   ] %s every 30 s: hottest winding %.1f C\n", reason, motors.hottest_C());
    EXPECT_GT(motors.hottest_C(), 85);
    EXPECT_LT(motors.hottest_C(), kLimit_C) << reason;
  }
}

// In a room of 25 degC. An ambient of -20, which the parameter allowed once, let the winding reach 157 degC.
TEST(HeatOverRestart, NoValueOfAParameterHeatsTheMotorsBeyondTheirLimit) {
  const auto bench = loaded();
  for (const auto& [param, value] :
       {std::pair(firmware::Param::ambient, firmware::row_of(firmware::Param::ambient).min),
        std::pair(firmware::Param::winding_limit, firmware::row_of(firmware::Param::winding_limit).max)})
    ASSERT_EQ(bench->controller->write_param(firmware::row_of(param).id, std::bit_cast<std::uint32_t>(value)),
              firmware::ParamStatus::kOk);
  TrueMotors motors;
  press(*bench);
  motors.run(*bench, 120);
  std::printf("[ figure   ] ambient and limit at their edges: hottest winding %.1f C\n", motors.hottest_C());
  EXPECT_GT(motors.hottest_C(), 85);
  EXPECT_LT(motors.hottest_C(), kLimit_C);
}

// Otherwise every start would take the motors for cold: 290 degC after eight restarts of half a minute of hard use.
TEST(HeatOverRestart, AStoreThatTakesNothingRefusesArming) {
  for (const bool lies : {false, true}) {
    const auto bench = loaded();
    bench->home();
    bench->storage.lies = lies;
    bench->storage.power_left = 0;
    EXPECT_EQ(bench->controller->request(Command::kArm), 0) << "nothing was to be written yet";
    bench->tick();
    EXPECT_EQ(bench->mode(), Mode::kArmed);
    ASSERT_EQ(bench->controller->request(Command::kDisarm), 0);
    bench->ticks(300);
    EXPECT_EQ(bench->controller->request(Command::kArm), firmware::kStoreFails);
    bench->restart("power_on");
    if (bench->controller->store().image_bytes() == 0) bench->load(4000);
    bench->home();
    EXPECT_NE(bench->controller->request(Command::kArm) & firmware::kStoreFails, 0) << lies;
    bench->storage.power_left = std::numeric_limits<std::size_t>::max();
    bench->ticks(static_cast<int>(6 * kRate_Hz));
    EXPECT_EQ(bench->controller->request(Command::kArm), 0) << "the store takes it again";
  }
}

// A power failure at any moment: the model is never below the motor.
TEST(HeatOverRestart, TheModelIsNotBelowTheMotorWheneverPowerFails) {
  for (const double seconds : {0.05, 0.3, 1.0, 2.5, 4.9, 5.1, 7.7, 12.0}) {
    const auto bench = loaded();
    TrueMotors motors;
    press(*bench);
    motors.run(*bench, seconds);
    bench->restart("power_on");
    const float model = model_C(*bench);
    const double truth = std::max({motors.winding_C(0), motors.winding_C(1), motors.winding_C(2)});
    std::printf("[ figure   ] power fails %.2f s after arming: motor %.1f C, model %.1f C\n", seconds, truth,
                static_cast<double>(model));
    EXPECT_GE(static_cast<double>(model), truth - 2.5);  // it cools for the 0.2 s of model_C()
  }
}

// Hot, disarmed for 10 s, and off.
std::unique_ptr<Bench> hot_and_off(TrueMotors& motors, std::uint32_t utc_s) {
  firmware::Config config = slow();
  config.utc_s = utc_s;
  auto bench = loaded(config);
  press(*bench);
  motors.run(*bench, 120);
  EXPECT_EQ(bench->controller->request(Command::kDisarm), 0);
  motors.run(*bench, 10);
  return bench;
}

TEST(TimeOff, CoolsByWhatTheBoardsClockKnows) {
  struct Case {
    std::uint32_t off_s;
    bool known;
  };
  for (const Case& off : {Case{0, true}, {100, true}, {600, true}, {12 * 3600, true}, {12 * 3600, false}}) {
    TrueMotors motors;
    const auto bench = hot_and_off(motors, kMorning);
    const float before = model_C(*bench);
    motors.run(*bench, 0.2);
    motors.rest(bench->data[0].axis[0].motor, off.off_s);
    bench->restart("power_on", off.known ? kMorning + 130 + off.off_s : 0);
    const float after = model_C(*bench);
    const double truth = std::max({motors.winding_C(0), motors.winding_C(1), motors.winding_C(2)});
    std::printf("[ figure   ] off for %u s, %s: model %.1f C before, %.1f C after; motor %.1f C\n", off.off_s,
                off.known ? "known" : "unknown", static_cast<double>(before), static_cast<double>(after),
                truth);
    EXPECT_GE(static_cast<double>(after), truth - 0.3);
    if (!off.known || off.off_s <= PersistentState::kClockError_s) {
      EXPECT_GT(after, before - 3);
    } else {
      EXPECT_LT(static_cast<double>(after), truth + 6);
    }
  }
}

TEST(TimeOff, AClockThatGoesBackwardsGivesNoCooling) {
  TrueMotors motors;
  const auto bench = hot_and_off(motors, kMorning);
  const float before = model_C(*bench);
  bench->restart("power_on", kMorning - 100000);
  EXPECT_GT(model_C(*bench), before - 3);
  // Nor when it has gone forwards again.
  bench->restart("power_on", kMorning + 140);
  EXPECT_GT(model_C(*bench), before - 4);
}

// The board is restarted while it is armed, over and over. Neither the time of the heat nor that of the audit record runs ahead of the clock.
TEST(TimeOff, RestartsFromArmedDoNotMoveTheClock) {
  firmware::Config config = slow();
  config.utc_s = kMorning;
  const auto bench = loaded(config);
  for (std::uint32_t start = 1; start <= 10; ++start) {
    press(*bench);
    bench->ticks(5000);
    ASSERT_EQ(bench->mode(), Mode::kArmed);
    const std::uint32_t now_s = kMorning + 30 * start;
    bench->restart("power_on", now_s);
    Journal journal(bench->storage);
    EXPECT_EQ(journal.open()->utc_s, now_s) << start;
    Tester host(*bench);
    EXPECT_EQ(audit_page(host, 0).back().utc_s, now_s) << start;
  }
}

// The board has no clock. Two hosts, a night between them; the second one comes when the board has been on for a while.
TEST(TimeOff, AHostTellsIt) {
  for (const double up_s : {0.5, 300.0}) {
    TrueMotors motors;
    const auto bench = hot_and_off(motors, 0);
    bench->controller->tell_time(kMorning, bench->inputs.time_us);
    motors.run(*bench, 1);
    const float before = model_C(*bench);
    bench->restart("power_on");
    motors.rest(bench->data[0].axis[0].motor, 8 * 3600);
    motors.run(*bench, up_s);
    const float unknown = shown_C(*bench);
    bench->controller->tell_time(kMorning + 8 * 3600 + static_cast<std::uint32_t>(up_s),
                                 bench->inputs.time_us);
    const float known = model_C(*bench);
    std::printf(
        "[ figure   ] on for %.1f s: model %.1f C before the night, %.1f C without a host, %.1f C with\n",
        up_s, static_cast<double>(before), static_cast<double>(unknown), static_cast<double>(known));
    EXPECT_GT(unknown, 35);
    EXPECT_LT(known, 25.5F);
    EXPECT_GE(static_cast<double>(known), motors.winding_C(0) - 0.1);
  }
}

// The arm was used before the host told the time: what it has heated since is not cooled.
TEST(TimeOff, AHostsClockCoolsOnlyWhatWasBefore) {
  TrueMotors motors;
  const auto bench = hot_and_off(motors, 0);
  bench->controller->tell_time(kMorning, bench->inputs.time_us);
  motors.run(*bench, 1);
  bench->restart("power_on");
  motors.rest(bench->data[0].axis[0].motor, 8 * 3600);
  press(*bench);
  motors.run(*bench, 40);
  bench->controller->tell_time(kMorning + 8 * 3600 + 41, bench->inputs.time_us);
  motors.run(*bench, 0.3);
  const double truth = std::max({motors.winding_C(0), motors.winding_C(1), motors.winding_C(2)});
  std::printf("[ figure   ] model %.2f C, motor %.2f C\n", static_cast<double>(shown_C(*bench)), truth);
  EXPECT_GT(truth, 50);
  EXPECT_GE(static_cast<double>(shown_C(*bench)), truth - 0.3);
  EXPECT_LT(static_cast<double>(shown_C(*bench)), truth + 8);
}

// Started without a clock twice, unused between: the night still counts.
TEST(TimeOff, IsNotForgottenByAStartWithoutAClock) {
  TrueMotors motors;
  const auto bench = hot_and_off(motors, kMorning);
  bench->restart("power_on");
  bench->ticks(200000);
  bench->restart("power_on");
  bench->ticks(10);
  bench->controller->tell_time(kMorning + 12 * 3600, bench->inputs.time_us);
  EXPECT_LT(model_C(*bench), 25.5F);
}

// A clock that lies does not cool the motors at the starts after it.
TEST(TimeOff, IsNotMadeByATimeBeyondAllClocks) {
  for (const std::uint32_t lie : {0xFFFFFFC0U, 0xFFFFFFFFU, 4102444801U}) {
    TrueMotors motors;
    const auto bench = hot_and_off(motors, kMorning);
    bench->restart("power_on");
    bench->controller->tell_time(lie, bench->inputs.time_us);
    const float before_C = model_C(*bench);
    for (int i = 0; i < 3; ++i) {
      bench->restart("power_on");
      bench->ticks(10);
      EXPECT_GT(model_C(*bench), before_C - 1);
    }
  }
}

TEST(TimeOff, IsToldByAService) {
  TrueMotors motors;
  const auto bench = hot_and_off(motors, kMorning);
  bench->restart("power_on");
  Tester tester(*bench);
  tester.run(100);
  const float before = model_C(*bench);
  const Bytes tell = join({0x31, 0x01, 0x02, 0x09}, big_endian({kMorning + 12 * 3600}));
  EXPECT_EQ(tester.refused(tell), link::Nrc::kNotInThisSession);
  ASSERT_TRUE(tester.ok({0x10, 0x03}));
  EXPECT_EQ(tester.refused({0x31, 0x01, 0x02, 0x09, 1}), link::Nrc::kIncorrectLength);
  EXPECT_TRUE(tester.ok(tell));
  tester.run(200);
  EXPECT_GT(before, 35);
  EXPECT_LT(shown_C(*bench), 25.5F);
}

TEST(Cooling, IsThatOfTheExactSolutionOrSlower) {
  const kinematics::MotorModel motor = kinematics::built_in_arm("premium-1.5").axis[0].motor;
  for (const float seconds : {0.0F, 1.0F, 12.0F, 100.0F, 1000.0F, 43200.0F, 1e9F}) {
    double winding = 70, housing = 40;
    const double h = 0.001;
    const auto t_w = static_cast<double>(motor.winding_time_constant_s),
               t_h = static_cast<double>(motor.housing_time_constant_s);
    const double ratio = static_cast<double>(motor.housing_to_ambient_K_W / motor.winding_to_housing_K_W);
    for (long i = 0; i < static_cast<long>(std::min(static_cast<double>(seconds), 2e4) / h); ++i) {
      const double w = winding;
      winding -= h * (w - housing) / t_w;
      housing += h * ((w - housing) * ratio - housing) / t_h;
    }
    const firmware::Heat heat = firmware::cooled(motor, {70, 40}, seconds);
    EXPECT_GE(static_cast<double>(heat.winding_K), winding - 0.01) << seconds;
    EXPECT_GE(static_cast<double>(heat.housing_K), housing - 0.01) << seconds;
    EXPECT_LT(static_cast<double>(heat.winding_K), winding + 0.5) << seconds;
    EXPECT_LT(static_cast<double>(heat.housing_K), housing + 0.5) << seconds;
  }
}

// The host that wears the flash most: it arms and disarms without a pause, and presses meanwhile.
TEST(Wear, StaysWithinWhatTheJournalSays) {
  firmware::Config config = slow();
  config.period_s = 0.01F;
  const auto bench = loaded(config);
  press(*bench);
  const std::size_t first = bench->storage.erases[4] + bench->storage.erases[5];
  constexpr int kHours = 2;
  for (int i = 0; i < kHours * 3600 * 100; ++i) {
    if (i % 40 == 0) static_cast<void>(bench->controller->request(Command::kDisarm));
    if (i % 40 == 30) static_cast<void>(bench->controller->request(Command::kArm));
    bench->tick();
  }
  const std::size_t erases = bench->storage.erases[4] + bench->storage.erases[5] - first;
  std::printf("[ figure   ] %zu erases in %d h, %zu a day at most\n", erases, kHours,
              Journal::kMostErasesADay);
  EXPECT_GT(erases, Journal::kMostErasesADay * kHours / 24 / 2) << "it is the worst case";
  EXPECT_LE(erases, Journal::kMostErasesADay * kHours / 24 + 1);
}

TEST(Wear, AnArmThatRestsWritesNothing) {
  const auto bench = loaded();
  bench->ticks(700 * 1000);  // beyond the trial
  const Storage& storage = bench->storage;
  const std::vector<std::byte> before(storage.slot(4).begin(), storage.slot(4).end());
  bench->ticks(1000 * 1000);
  EXPECT_TRUE(std::ranges::equal(before, storage.slot(4)));
}

}  // namespace
}  // namespace thimble::test
