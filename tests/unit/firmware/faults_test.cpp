// One test per row of faults.def: injected while the arm presses, it trips in that tick, stays the first
// reason, keeps the ticks before it, goes through damping to zero whatever is commanded, and clears only by
// command once the cause is gone. The test walks the table: a fault without an injector fails.
#include <gtest/gtest.h>

#include <bit>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "tests/unit/firmware/bench.h"
#include "tests/unit/firmware/fault_rig.h"

namespace thimble::test {
namespace {

using firmware::FaultRow;
using firmware::kFaultTable;
using firmware::Reaction;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

void set_param(Bench& bench, const char* name, float value) {
  const firmware::ParamRow* row = firmware::find_param(name);
  ASSERT_NE(row, nullptr) << name;
  const auto bits = row->type == firmware::ParamType::kFloat ? std::bit_cast<std::uint32_t>(value)
                                                             : static_cast<std::uint32_t>(value);
  ASSERT_EQ(bench.controller->write_param(row->id, bits), firmware::ParamStatus::kOk) << name;
}

// Pressing with 5 N for longer than the ramp, and trembling.
std::unique_ptr<Bench> pressing() {
  auto bench = std::make_unique<Bench>(fault_config());
  scripted_force_N = {0, 0, 5};
  bench->start();
  bench->ticks(1000);
  bench->move({0, 0, -0.003}, 400);
  EXPECT_EQ(bench->mode(), Mode::kArmed);
  EXPECT_NEAR(bench->force_N(), 5.0F, 1e-3F);
  EXPECT_TRUE(any_current(bench->outputs));
  return bench;
}

std::unique_ptr<Bench> five_bar_at_its_reach() {
  firmware::Config config = fault_config();
  config.arms_known = five_bars;
  config.arm[0].model = "five-bar";
  auto bench = std::make_unique<Bench>(config);
  scripted_force_N = {0, 0.2F, 0};
  bench->start();
  bench->ticks(1000);
  EXPECT_EQ(bench->mode(), Mode::kArmed);
  EXPECT_TRUE(any_current(bench->outputs));
  return bench;
}

// A scene, and motors that were never on.
std::unique_ptr<Bench> rested() {
  auto bench = std::make_unique<Bench>(fault_config());
  bench->load();
  bench->ticks(3);
  return bench;
}

// Until the arm lets go: every time that a probe begins to take torque away, the joints move a little, with their torque or against it; and
// come back with the torque.
void move_when_probed(Bench& bench, double with_torque, bool comes_back = true) {
  bench.frozen = true;
  Eigen::Vector3d moved_rad = Eigen::Vector3d::Zero();
  bool probed = false;
  for (int i = 0; i < 8000 && bench.mode() == Mode::kArmed; ++i) {
    const bool probes = (bench.shown().arm[0].limiters & firmware::link::kLimitProbe) != 0;
    if (probes && !probed) {
      const Eigen::Vector3d torque_N_m =
          bench.arms[0].at(bench.joints[0]).jacobian.transpose() * scripted_force_N.cast<double>();
      for (int j = 0; j < 3; ++j) {
        const double count_rad =
            std::abs(static_cast<double>(bench.data[0].axis[static_cast<std::size_t>(j)].rad_per_count()));
        moved_rad[j] = std::copysign(5 * count_rad, with_torque * torque_N_m[j]);
      }
      bench.joints[0] += moved_rad;
    }
    if (!probes && probed && comes_back) bench.joints[0] -= moved_rad;
    probed = probes;
    bench.tick();
  }
}

struct Injector {
  std::unique_ptr<Bench> (*start)();
  void (*inject)(Bench&);  // makes the cause
  int within_ticks;        // from there to the trip
  void (*remove)(Bench&);  // takes the cause away; null: only a restart does
};

const std::map<Fault, Injector>& injectors() {
  static const std::map<Fault, Injector> kInjectors = {
      {Fault::e_stop,
       {pressing, [](Bench& b) { b.inputs.e_stop = true; }, 1, [](Bench& b) { b.inputs.e_stop = false; }}},
      {Fault::encoder_stale,
       {pressing, [](Bench& b) { b.sampling = false; }, 3, [](Bench& b) { b.sampling = true; }}},
      {Fault::encoder_jump, {pressing, [](Bench& b) { b.joints[0][1] += 0.1; }, 1, [](Bench&) {}}},
      {Fault::encoder_frozen,
       {pressing,
        [](Bench& b) {
          b.frozen = true;
          scripted_force_N = {0, 0, 2};
        },
        1300, [](Bench& b) { b.frozen = false; }}},
      {Fault::tip_not_finite,
       {five_bar_at_its_reach,
        [](Bench& b) {
          b.joints[0] += Eigen::Vector3d(.1, -.1, 0);  // there its outer links do not meet
        },
        1, [](Bench& b) { b.joints[0] = b.arms[0].home(); }}},
      {Fault::force_not_finite,
       {pressing,
        [](Bench&) {
          scripted_force_N = {0, kNan, 5};
        },
        1, [](Bench&) { scripted_force_N.setZero(); }}},
      {Fault::torque_not_finite,
       {pressing, [](Bench&) { spoilable_model().inertia.g2 = kNan; }, 1, [](Bench&) { restore_model(); }}},
      {Fault::tick_lost, {pressing, [](Bench& b) { b.inputs.tick += 5; }, 1, [](Bench&) {}}},
      {Fault::motor_hot,
       {pressing, [](Bench&) { spoilable_model().axis[0].motor.max_winding_C = 20; }, 1,
        [](Bench&) { restore_model(); }}},
      {Fault::host_lost,
       {[] {
          auto bench = std::make_unique<Bench>(fault_config());
          set_param(*bench, "host_supervision", 1);
          scripted_force_N = {0, 0, 5};
          bench->start();
          bench->ticks(1000);
          return bench;
        },
        [](Bench& b) { b.alive = false; }, 4002, [](Bench& b) { b.alive = true; }}},
      {Fault::drive_fault,
       {pressing, [](Bench& b) { b.inputs.arm[0].drive_fault = true; }, 1,
        [](Bench& b) { b.inputs.arm[0].drive_fault = false; }}},
      {Fault::homing_timeout,
       {[] {
          firmware::Config config = fault_config();
          config.arm[0].has_index = true;
          auto bench = std::make_unique<Bench>(config);
          set_param(*bench, "homing_timeout", 1);
          bench->load();
          bench->tick();
          EXPECT_EQ(bench->controller->request(Command::kHome), 0);
          return bench;
        },
        [](Bench&) {}, 4003, [](Bench& b) { b.inputs.arm[0].index = true; }}},
      {Fault::bad_config,
       {[] {
          firmware::Config config = fault_config();
          config.arm[0].model = "no such arm";
          auto bench = std::make_unique<Bench>(config);
          bench->load();
          return bench;
        },
        [](Bench&) {}, 1, nullptr}},
      {Fault::host_stop,
       {pressing,
        [](Bench& b) {
          firmware::link::CanFrame frame;
          frame.id = 0x001;
          b.controller->on_frame(frame, b.inputs.time_us);
        },
        1, [](Bench&) {}}},
      {Fault::encoder_line,
       {pressing, [](Bench& b) { b.inputs.arm[0].evidence.line_loss = true; }, 1,
        [](Bench& b) { b.inputs.arm[0].evidence.line_loss = false; }}},
      {Fault::index_mismatch,
       {[] {
          firmware::Config config = fault_config();
          config.arm[0].has_index = true;
          auto bench = std::make_unique<Bench>(config);
          bench->load();
          bench->inputs.arm[0].index = true;
          bench->home();
          bench->ticks(3);
          bench->arm();
          bench->inputs.arm[0].index = false;
          scripted_force_N = {0, 0, 5};
          bench->move({0, 0, -0.01}, 400);
          return bench;
        },
        [](Bench& b) { b.inputs.arm[0].index = true; }, 1,
        [](Bench& b) {
          b.place({0, 0, 0});
          b.ticks(2);
        }}},
      // Counts that run away no faster than the arm may move.
      {Fault::joint_range,
       {pressing,
        [](Bench& b) {
          for (int i = 0; i < 8000 && b.mode() == Mode::kArmed; ++i) {
            b.joints[0][0] += 3e-4;
            b.tick();
          }
        },
        1,
        [](Bench& b) {
          b.joints[0].setZero();
          b.ticks(1);
        }}},
      {Fault::tip_speed,
       {pressing,
        [](Bench& b) {
          for (int i = 0; i < 40 && b.mode() == Mode::kArmed; ++i) {
            b.joints[0][0] += 2e-3;
            b.tick();
          }
        },
        1, [](Bench&) {}}},
      {Fault::current_mismatch,
       {pressing,
        [](Bench& b) {
          b.inputs.arm[0].evidence.current_A = {0, 0, 0};
        },
        6, [](Bench& b) { b.inputs.arm[0].evidence = {}; }}},
      {Fault::supply,
       {pressing, [](Bench& b) { b.inputs.arm[0].evidence.supply_V = 12; }, 22,
        [](Bench& b) { b.inputs.arm[0].evidence = {}; }}},
      {Fault::motor_reversed,
       {pressing, [](Bench& b) { move_when_probed(b, 1); }, 1, [](Bench& b) { b.frozen = false; }}},
      {Fault::watchdog_reset, {rested, [](Bench& b) { b.restart("watchdog"); }, 1, [](Bench&) {}}},
      {Fault::store_corrupt,
       {rested,
        [](Bench& b) {
          b.storage.at(0, firmware::SceneStore::kHeaderBytes + 100) ^= std::byte{1};
          b.restart("power_on");
        },
        1, [](Bench& b) { b.load(); }}},
      {Fault::set_aside,
       {rested,
        [](Bench& b) {
          for (int i = 0; i < 3; ++i) b.restart("crash");
        },
        1, [](Bench& b) { b.load(); }}},
  };
  return kInjectors;
}

class EachFault : public testing::TestWithParam<FaultRow> {
 protected:
  void TearDown() override {
    restore_model();
    scripted_force_N.setZero();
  }
};

TEST_P(EachFault, TripsStaysTrippedAndClears) {
  const FaultRow& row = GetParam();
  const auto found = injectors().find(row.fault);
  ASSERT_NE(found, injectors().end()) << row.name << " has no injector: add one to this file";
  const Injector& injector = found->second;

  const auto bench = injector.start();
  const bool was_armed = bench->mode() == Mode::kArmed;
  injector.inject(*bench);
  int ticks = 0;
  while ((ticks == 0 || bench->controller->fault() == Fault::kNone) && ticks < injector.within_ticks &&
         bench->controller->fault() != row.fault) {
    bench->tick();
    ++ticks;
  }
  if (ticks == 0 && !was_armed) bench->tick();  // it was there before the first tick
  ASSERT_EQ(bench->controller->fault(), row.fault) << row.name;
  std::printf("%s: tripped after %d ticks, then %s\n", row.name, ticks, name(bench->mode()));

  // In the tick of the trip: braking, or zero.
  if (was_armed && row.reaction == Reaction::kDamp) {
    EXPECT_EQ(bench->mode(), Mode::kDamping);
    EXPECT_LT(bench->force_N(), 0.2F + 2.0F * bench->shown().arm[0].tip_velocity_m_s.norm());
  } else {
    EXPECT_EQ(bench->mode(), Mode::kFaulted);
    EXPECT_FALSE(any_current(bench->outputs));
    EXPECT_FALSE(any_enabled(bench->outputs));
  }

  // The last ticks are kept, up to and with the one that tripped.
  const std::uint64_t trip_tick = bench->inputs.tick;
  bench->ticks(3);
  firmware::FrozenTick kept;
  std::size_t count = 0;
  std::uint64_t expected = 0;
  while (bench->controller->freeze_tick(count, kept)) {
    if (count != 0) {
      EXPECT_GT(kept.tick, expected);
    }
    expected = kept.tick;
    ++count;
  }
  EXPECT_EQ(kept.fault, row.fault);
  EXPECT_LE(kept.tick, trip_tick);
  EXPECT_LE(count, firmware::kFreezeTicks);
  if (was_armed) {
    EXPECT_EQ(count, firmware::kFreezeTicks);
  }

  // Trip, then keep commanding: nothing but a clear gets it out, and another fault does not take its place.
  for (int i = 0; i < 1500; ++i) {
    (void)bench->controller->request(i % 3 == 0   ? Command::kArm
                                     : i % 3 == 1 ? Command::kHome
                                                  : Command::kDisarm);
    if (i == 1200) (void)bench->controller->request(Command::kStop);
    bench->tick();
    ASSERT_NE(bench->mode(), Mode::kArmed);
    ASSERT_EQ(bench->controller->fault(), row.fault);
  }
  EXPECT_EQ(bench->mode(), Mode::kFaulted);
  EXPECT_FALSE(any_current(bench->outputs));
  EXPECT_FALSE(any_enabled(bench->outputs));

  if (injector.remove == nullptr) {
    EXPECT_NE(bench->controller->request(Command::kClear), 0);
    bench->tick();
    EXPECT_EQ(bench->controller->fault(), row.fault);
    return;
  }
  injector.remove(*bench);
  bench->ticks(5);
  EXPECT_EQ(bench->controller->fault(), row.fault) << "a fault must not clear itself";
  EXPECT_EQ(bench->controller->request(Command::kClear), 0);
  bench->ticks(2);
  EXPECT_EQ(bench->controller->fault(), Fault::kNone);
  EXPECT_FALSE(bench->controller->freeze_tick(0, kept));
  EXPECT_NE(bench->mode(), Mode::kArmed) << "the old command must not resume";
  if (bench->mode() == Mode::kDisarmed) bench->home();
  bench->arm();
  EXPECT_LT(bench->force_N(), 0.01F) << "the ramp begins anew";
}

INSTANTIATE_TEST_SUITE_P(Faults, EachFault, testing::ValuesIn(kFaultTable),
                         [](const auto& row) { return std::string(row.param.name); });

constexpr float kRates_Hz[] = {1000, 4000, 10000, 20000};

std::unique_ptr<Bench> armed_at(float rate_Hz) {
  firmware::Config config;
  config.period_s = 1.0F / rate_Hz;
  auto bench = std::make_unique<Bench>(config);
  bench->start();
  bench->ticks(static_cast<int>(0.3F * rate_Hz));
  EXPECT_EQ(bench->mode(), Mode::kArmed);
  return bench;
}

// After how long the fault comes, while one tick in `in_time` ends in time and the others take a fifth longer than a period; 0: not in 2 s.
float overloaded_s(float rate_Hz, int in_time) {
  const auto bench = armed_at(rate_Hz);
  for (int i = 1; static_cast<float>(i) < 2 * rate_Hz; ++i) {
    bench->inputs.last_tick_us = (i % in_time == 0 ? 0.5F : 1.2F) * 1e6F / rate_Hz;
    bench->tick();
    if (bench->controller->fault() == Fault::kNone) continue;
    EXPECT_EQ(bench->controller->fault(), Fault::tick_lost);
    EXPECT_EQ(bench->mode(), Mode::kDamping);
    return static_cast<float>(i) / rate_Hz;
  }
  EXPECT_GT(bench->shown().overruns, rate_Hz);
  return 0;
}

TEST(TickLost, TicksThatTakeLongerThanAPeriodAreAFaultAtEveryRate) {
  for (const float rate_Hz : kRates_Hz) {
    EXPECT_NEAR(overloaded_s(rate_Hz, 100'000), 0.1F, 2 / rate_Hz) << rate_Hz;
    EXPECT_NEAR(overloaded_s(rate_Hz, 10), 0.2F, 0.02F) << rate_Hz;
    EXPECT_EQ(overloaded_s(rate_Hz, 4), 0.0F) << rate_Hz;
  }
}

TEST(TickLost, AsManyInARowAsTheParameterSaysAreCountedOnly) {
  for (const float rate_Hz : kRates_Hz) {
    const auto bench = armed_at(rate_Hz);
    for (int i = 0; i < 10; ++i) {
      bench->inputs.tick += 4;
      bench->tick();
      ASSERT_EQ(bench->mode(), Mode::kArmed) << rate_Hz;
    }
    EXPECT_EQ(bench->shown().lost_ticks, 40U);
    bench->inputs.tick += 5;
    bench->tick();
    EXPECT_EQ(bench->controller->fault(), Fault::tick_lost) << rate_Hz;
  }
}

TEST(FaultTable, HasUniqueRowsAndAnInjectorForEach) {
  std::set<int> ids;
  std::set<int> codes;
  std::set<std::string> names;
  for (const FaultRow& row : kFaultTable) {
    EXPECT_TRUE(ids.insert(static_cast<int>(row.fault)).second) << row.name;
    EXPECT_TRUE(codes.insert(row.emergency_code).second) << row.name;
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_GT(std::string(row.cause).size(), 10U) << row.name;
    EXPECT_GT(std::string(row.remedy).size(), 10U) << row.name;
    EXPECT_EQ(injectors().count(row.fault), 1U) << row.name << " has no injector";
    EXPECT_EQ(firmware::find_fault(row.fault)->name, row.name);
  }
  EXPECT_EQ(firmware::find_fault(Fault::kNone), nullptr);
  EXPECT_EQ(injectors().size(), firmware::kFaultCount);
  std::printf("%zu faults, %zu injectors\n", firmware::kFaultCount, injectors().size());
}

// An encoder fault while another fault still brakes: braking by that encoder must end.
TEST(FaultWhileBraking, OfAnEncoderEndsTheBraking) {
  const auto bench = pressing();
  bench->inputs.e_stop = true;
  bench->ticks(10);
  ASSERT_EQ(bench->mode(), Mode::kDamping);
  bench->sampling = false;
  bench->ticks(4);
  EXPECT_EQ(bench->mode(), Mode::kFaulted);
  EXPECT_EQ(bench->controller->fault(), Fault::e_stop) << "the first reason stays";
  EXPECT_FALSE(any_enabled(bench->outputs));
  scripted_force_N.setZero();
}

// A firm hand that holds a thing and loses it: the arm needs time to give way.
TEST(FrozenEncoder, IsNotAnArmThatStoodStillAndIsLetGo) {
  const auto bench = pressing();
  bench->frozen = true;
  bench->ticks(900);
  scripted_force_N.setZero();
  bench->ticks(150);
  EXPECT_EQ(bench->mode(), Mode::kArmed) << "37 ms after";
  bench->frozen = false;
  for (int i = 0; i < 20; ++i) {
    bench->joints[0].array() += 0.0001;  // some counts
    bench->tick();
  }
  bench->ticks(400);
  EXPECT_EQ(bench->mode(), Mode::kArmed);
}

TEST(ReversedMotor, IsNotAHandThatLiftsOffSlowly) {
  const auto bench = pressing();
  move_when_probed(*bench, 1, false);
  EXPECT_EQ(bench->controller->fault(), Fault::kNone);
  EXPECT_GT(bench->shown().probes, 5U);
  scripted_force_N.setZero();
}

TEST(ReversedMotor, IsNotAJointThatGivesWayWhenItsTorqueGoes) {
  const auto bench = pressing();
  move_when_probed(*bench, -1);
  EXPECT_EQ(bench->mode(), Mode::kArmed);
  EXPECT_GT(bench->shown().probes, 5U);
  scripted_force_N.setZero();
}

}  // namespace
}  // namespace thimble::test
