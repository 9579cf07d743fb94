// The law of an order for the axes against its closed form, at every period, and that it always ends.
#include "firmware/sources/axis_drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/support/random.h"

namespace thimble::test {
namespace {

namespace link = firmware::link;
using firmware::Axes;
using firmware::AxisDrive;
using link::AxisEnd;
using link::AxisPhase;

constexpr std::array<float, 6> kPeriods = {1 / 500.0F,  1 / 1000.0F, 1 / 2000.0F,
                                           1 / 4000.0F, 1 / 8000.0F, 1 / 20000.0F};
constexpr int kAxes = 3;

// Limits nothing, does nothing.
link::AxisOrder order_for(float driven_s) {
  link::AxisOrder order;
  order.driven_s = driven_s;
  order.most_torque_N_m.fill(1e3F);
  return order;
}

// A drive and the axes it drives, which are where the test puts them.
struct Rig {
  explicit Rig(float period) : period_s(period) {}
  void start(const link::AxisOrder& order) { drive.start(order, angle); }
  float tick(int axis = 0) { return drive.tick(angle, kAxes, period_s)[axis]; }
  // Until it drives no longer; `before` puts the axes somewhere before each tick. The ticks in which it drove.
  int drive_on(auto&& before) {
    for (int n = 0;; ++n) {
      before(n);
      last_N_m = tick();
      if (drive.phase() != AxisPhase::kDriving) return n;
    }
  }

  float period_s;
  float last_N_m = 0;
  Axes angle = Axes::Zero();
  AxisDrive drive;
};

const auto kStill = [](int) {};

TEST(AxisDrive, ATorqueIsItsClosedForm) {
  for (const float period_s : kPeriods) {
    for (const float frequency_Hz : {0.0F, 1.0F, 37.5F, 240.0F, 1000.0F}) {
      link::AxisOrder order = order_for(0.4F);
      order.axis = 1;
      order.offset_N_m = 0.02F;
      order.slope_N_m_s = -0.3F;
      order.amplitude_N_m = 0.05F;
      order.frequency_Hz = frequency_Hz;
      Rig rig(period_s);
      rig.angle << 0.1F, -0.2F, 0.3F, Axes::Zero().tail(Axes::RowsAtCompileTime - 3);
      rig.start(order);
      double worst_N_m = 0;
      for (int n = 0; n < std::lround(0.4F / period_s); ++n) {
        const double time_s = n * static_cast<double>(period_s);
        const double turns = time_s * static_cast<double>(frequency_Hz);
        const double law_N_m =
            0.02 - 0.3 * time_s + 0.05 * std::cos(2 * std::numbers::pi * (turns - std::floor(turns)));
        worst_N_m = std::max(worst_N_m, std::abs(static_cast<double>(rig.tick(1)) - law_N_m));
        EXPECT_EQ(rig.drive.torque_N_m()[0], 0.0F);
        EXPECT_EQ(rig.drive.torque_N_m()[2], 0.0F);
      }
      EXPECT_LT(worst_N_m, 5e-5) << period_s << " s, " << frequency_Hz << " Hz";
      EXPECT_EQ(rig.drive.phase(), AxisPhase::kDriving);
      EXPECT_FALSE(rig.drive.follows());
      EXPECT_EQ(rig.tick(1), 0.0F) << "it is over";
    }
  }
}

TEST(AxisDrive, AToneIsATorqueForAMinute) {
  for (const float period_s : kPeriods) {
    link::AxisOrder order = order_for(60.0F);
    order.amplitude_N_m = 1.0F;
    order.frequency_Hz = 1000.0F;
    Rig rig(period_s);
    rig.start(order);
    float most = 0;
    const int driven = rig.drive_on([&](int) {
      ASSERT_TRUE(std::isfinite(rig.last_N_m));
      most = std::max(most, std::abs(rig.last_N_m));
    });
    EXPECT_EQ(driven, std::lround(60.0 / static_cast<double>(period_s)));
    EXPECT_LE(most, 1.0F + 1e-6F);
    if (HasFatalFailure()) return;
  }
}

TEST(AxisDrive, TheWayIsATrapezoidOfSpeed) {
  constexpr float kMove_s = 0.2F;
  constexpr double kTop = 1 / 0.75, kRise = kTop / 0.25;  // of the whole way, in parts of move_s
  for (const float period_s : kPeriods) {
    // Of one axis the spring shows s, of the other the damper shows s'; both stand still at 0 on a way of 1 rad.
    link::AxisOrder order = order_for(kMove_s + 0.01F);
    order.move_s = kMove_s;
    order.to_rad = {1, 1};
    order.stiffness_N_m_rad[0] = 1;
    order.damping_N_m_s_rad[1] = 1;
    Rig rig(period_s);
    rig.start(order);
    const double step = static_cast<double>(period_s / kMove_s);
    double way = 0, last = 0;
    for (double at = 0; at < 1.04; at += step) {
      const double place = static_cast<double>(rig.tick(0));
      const double speed = static_cast<double>(rig.drive.torque_N_m()[1] * kMove_s);
      const double law = std::clamp(std::min(kRise * at, kRise * (1 - at)), 0.0, kTop);
      EXPECT_NEAR(speed, law, 1e-4) << at;
      EXPECT_LT(std::abs(speed - last), kRise * step + 1e-4) << "continuous";
      way += 0.5 * (speed + last) * step;
      EXPECT_NEAR(place, way, 0.5 * kRise * step * step + 1e-4) << "the integral of the speed";
      last = speed;
    }
    EXPECT_EQ(rig.drive.torque_N_m()[0], 1.0F) << "all of the way, to the bit";
    EXPECT_EQ(rig.drive.torque_N_m()[1], 0.0F);
    EXPECT_TRUE(rig.drive.follows());
  }
}

// An axis at a constant speed: the filtered speed has a closed form.
TEST(AxisDrive, SpringAndDamperAreTheirClosedForm) {
  constexpr double kSpeed = 0.7, kStiffness = 2.0, kDamping = 0.05, kTo = 0.2;
  for (const float period_s : kPeriods) {
    link::AxisOrder order = order_for(0.2F);
    order.axis = 2;  // of the torque, which is none
    order.to_rad[0] = static_cast<float>(kTo);
    order.stiffness_N_m_rad[0] = static_cast<float>(kStiffness);
    order.damping_N_m_s_rad[0] = static_cast<float>(kDamping);
    Rig rig(period_s);
    rig.start(order);
    const double period = static_cast<double>(period_s);
    const double left = 1 - period / (static_cast<double>(AxisDrive::kFilter_s) + period);
    for (int n = 0; n < std::lround(0.2F / period_s); ++n) {
      const double angle = kSpeed * n * period;
      rig.angle[0] = static_cast<float>(angle);
      const double law = kStiffness * (kTo - angle) - kDamping * kSpeed * (1 - std::pow(left, n));
      ASSERT_NEAR(static_cast<double>(rig.tick()), law, 2e-4) << period_s << " s, tick " << n;
    }
  }
}

TEST(AxisDrive, NoAxisHasMoreThanItsMostTorque) {
  link::AxisOrder order = order_for(1.0F);
  order.offset_N_m = -5.0F;
  order.to_rad = {0, 9, 9};
  order.stiffness_N_m_rad = {0, 7, 7};
  order.most_torque_N_m = {0.25F, 0.5F, 0.0F};
  Rig rig(1 / 4000.0F);
  rig.start(order);
  EXPECT_EQ(rig.tick(), -0.25F);
  EXPECT_EQ(rig.drive.torque_N_m()[1], 0.5F);
  EXPECT_EQ(rig.drive.torque_N_m()[2], 0.0F);
}

TEST(AxisDrive, StartsWithoutAJump) {
  for (const float period_s : kPeriods) {
    for (const float first_move_s : {0.05F, 0.3F}) {  // the second one is still on its way when it is held
      link::AxisOrder order = order_for(0.1F);
      order.hold = true;
      order.move_s = first_move_s;
      order.stiffness_N_m_rad[0] = 5;
      order.to_rad[0] = 1.3F;
      Rig rig(period_s);
      rig.angle[0] = 1.0F;
      rig.start(order);
      EXPECT_EQ(rig.tick(), 0.0F) << "from where it is";
      float last_N_m = 0;
      for (int n = 0; n < std::lround(0.15F / period_s); ++n) last_N_m = rig.tick();
      ASSERT_EQ(rig.drive.phase(), AxisPhase::kHolding);
      EXPECT_GT(last_N_m, 0.5F) << "the axis is stuck, and pulled";
      order.to_rad[0] = 0.8F;
      order.move_s = 0.1F;
      rig.start(order);
      EXPECT_EQ(rig.drive.phase(), AxisPhase::kDriving);
      EXPECT_EQ(rig.drive.end(), AxisEnd::kNotYet);
      EXPECT_NEAR(rig.tick(), last_N_m, first_move_s < 0.1F ? 1e-6F : 25.0F * period_s) << period_s;
      for (int n = 0; n < std::lround(0.2F / period_s); ++n) {
        last_N_m = rig.drive.torque_N_m()[0];
        EXPECT_NEAR(rig.tick(), last_N_m, 1.01F * 5 * 0.5F / 0.1F / 0.75F * period_s);
      }
      EXPECT_NEAR(rig.drive.torque_N_m()[0], 5 * (0.8F - 1.0F), 1e-5F);
    }
  }
}

TEST(AxisDrive, EndsAndIsLetGoInTheRightTick) {
  for (const float period_s : kPeriods) {
    for (const float driven_s : {0.0F, 0.002F, 0.1F, 1.0F, 60.0F}) {
      for (const float coast_s : {0.0F, 0.006F, 5.0F}) {
        link::AxisOrder order = order_for(driven_s);
        order.coast_s = coast_s;
        order.offset_N_m = 1;
        Rig rig(period_s);
        rig.start(order);
        const int driven = rig.drive_on(kStill);
        const double period = static_cast<double>(period_s);
        EXPECT_EQ(driven, std::lround(static_cast<double>(driven_s) / period)) << period_s;
        EXPECT_EQ(rig.drive.driven_ticks(), static_cast<std::uint32_t>(driven));
        EXPECT_EQ(rig.drive.end(), AxisEnd::kTime);
        EXPECT_EQ(rig.last_N_m, 0.0F);
        int coasted = 1;
        for (; rig.drive.active(); ++coasted) {
          EXPECT_TRUE(rig.drive.under_way());
          ASSERT_EQ(rig.tick(), 0.0F);
        }
        EXPECT_EQ(coasted, std::max(1L, std::lround(static_cast<double>(coast_s) / period)));
        EXPECT_EQ(rig.tick(), 0.0F) << "and nothing comes after it";
      }
    }
  }
}

// What ends it, while it drives, while it holds, and while it holds without having driven.
TEST(AxisDrive, EndsWhereItGoesTooFarTooFastOrTakesTooMuch) {
  struct Case {
    AxisEnd end;
    float most;    // of the limit
    float step;    // of the axis in a tick
    double ticks;  // until it ends
  };
  for (const float period_s : kPeriods) {
    const double block = std::ceil(static_cast<double>(AxisDrive::kSpeedTime_s / period_s) - 1e-3);
    const std::array<Case, 6> cases = {{{AxisEnd::kWay, 0.0105F, 0.001F, 11},
                                        {AxisEnd::kWay, 0.0105F, -0.001F, 11},
                                        {AxisEnd::kSpeed, 2.0F, 2.1F * period_s, block},
                                        {AxisEnd::kSpeed, 2.0F, -2.1F * period_s, block},
                                        {AxisEnd::kEnergy, 0.0105F, 0.001F, 11},
                                        {AxisEnd::kEnergy, 0.0105F, 0.002F, 6}}};
    for (const Case& c : cases) {
      for (const float driven_s : {10.0F, 0.1F, 0.0F}) {
        link::AxisOrder order = order_for(driven_s);
        order.hold = driven_s < 1.0F;
        order.coast_s = 0.1F;
        order.axis = 1;
        order.offset_N_m = 1;
        order.to_rad[1] = 1000.0F;
        order.stiffness_N_m_rad[1] = 1;
        order.most_torque_N_m[1] = 1;  // so that torque and energy are known
        if (c.end == AxisEnd::kWay) order.most_way_rad = {0, c.most};
        if (c.end == AxisEnd::kSpeed) order.most_speed_rad_s = {0, c.most};
        if (c.end == AxisEnd::kEnergy) order.most_energy_J = c.most;
        Rig rig(period_s);
        rig.start(order);
        const int still = driven_s == 0.1F ? static_cast<int>(std::lround(0.2F / period_s)) : 0;
        for (int n = 0; n <= still; ++n) EXPECT_EQ(rig.tick(1), 1.0F);
        EXPECT_EQ(rig.drive.phase(),
                  order.hold && (still != 0 || driven_s == 0.0F) ? AxisPhase::kHolding : AxisPhase::kDriving);
        int ticks = 0;
        while (rig.drive.phase() != AxisPhase::kCoasting && ticks < 1000) {
          rig.angle[0] += 7 * c.step;  // an axis without a limit
          rig.angle[1] += c.step;
          rig.tick(1);
          ++ticks;
        }
        // The sum of the periods of a stretch may end a tick late, and the first one have begun while it stood still.
        const double early = c.end == AxisEnd::kSpeed && still != 0 ? block : 0;
        EXPECT_GE(ticks, c.ticks - early);
        EXPECT_LE(ticks, c.ticks + early + (c.end == AxisEnd::kSpeed ? 1 : 0))
            << period_s << " s, end " << static_cast<int>(c.end) << ", driven " << driven_s;
        EXPECT_EQ(rig.drive.end(), c.end);
        EXPECT_EQ(rig.drive.torque_N_m()[1], 0.0F) << "in that tick";
        for (int n = 0; n <= std::lround(0.1F / period_s); ++n) rig.tick();
        EXPECT_FALSE(rig.drive.active());
      }
    }
  }
}

TEST(AxisDrive, GoesOnBelowItsLimits) {
  for (const float period_s : kPeriods) {
    link::AxisOrder order = order_for(1.0F);
    order.offset_N_m = 1;
    order.most_way_rad[0] = 1.0F;
    order.most_speed_rad_s[0] = 1.0F;
    order.most_energy_J = 1.0F;
    Rig rig(period_s);
    rig.start(order);
    const int driven = rig.drive_on([&](int n) { rig.angle[0] = 0.95F * static_cast<float>(n) * period_s; });
    EXPECT_EQ(driven, std::lround(1.0F / period_s));
    EXPECT_EQ(rig.drive.end(), AxisEnd::kTime);
    // What a hand gives back is not taken.
    rig.start(order);
    rig.drive_on([&](int n) { rig.angle[0] = 0.95F - 0.95F * static_cast<float>(n) * period_s; });
    EXPECT_EQ(rig.drive.end(), AxisEnd::kTime);
  }
}

// The energy of an order is its own: the one before held with a torque, and the axis moves as the next one begins.
TEST(AxisDrive, TheEnergyBeginsAnew) {
  link::AxisOrder order = order_for(0.0F);
  order.hold = true;
  order.to_rad[0] = 1.0F;
  order.stiffness_N_m_rad[0] = 10.0F;
  Rig rig(1 / 1000.0F);
  rig.start(order);
  EXPECT_EQ(rig.tick(), 10.0F);
  link::AxisOrder next = order_for(0.1F);
  next.most_energy_J = 0.01F;
  rig.angle[0] = 0.1F;  // 1 J of the old torque
  rig.start(next);
  EXPECT_EQ(rig.drive_on(kStill), 100);
  EXPECT_EQ(rig.drive.end(), AxisEnd::kTime);
}

TEST(AxisDrive, HoldsUntilItIsStopped) {
  link::AxisOrder order = order_for(0.05F);
  order.hold = true;
  order.stiffness_N_m_rad[0] = 3;
  order.to_rad[0] = 0.1F;
  order.offset_N_m = 0.7F;
  Rig rig(1 / 4000.0F);
  rig.start(order);
  EXPECT_NEAR(rig.tick(), 1.0F, 1e-6F);
  rig.drive_on(kStill);
  EXPECT_NEAR(rig.last_N_m, 0.3F, 1e-6F) << "the torque is over, the place is held";
  for (int n = 0; n < 40000; ++n) ASSERT_EQ(rig.tick(), rig.last_N_m);
  EXPECT_EQ(rig.drive.phase(), AxisPhase::kHolding);
  EXPECT_FALSE(rig.drive.under_way());
  rig.drive.stop();
  EXPECT_FALSE(rig.drive.active());
  EXPECT_EQ(rig.drive.end(), AxisEnd::kTime) << "it had ended";
  EXPECT_EQ(rig.drive.torque_N_m()[0], 0.0F);
  rig.start(order);
  rig.tick();
  rig.drive.stop();
  EXPECT_EQ(rig.drive.end(), AxisEnd::kStopped);
}

TEST(AxisDrive, WhatIsNotFiniteComesOut) {
  link::AxisOrder order = order_for(1.0F);
  order.stiffness_N_m_rad[0] = 1;
  order.damping_N_m_s_rad[1] = 1;
  Rig rig(1 / 4000.0F);
  rig.start(order);
  EXPECT_EQ(rig.tick(), 0.0F);
  rig.angle[0] = rig.angle[1] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_TRUE(std::isnan(rig.tick(0)));
  EXPECT_TRUE(std::isnan(rig.drive.torque_N_m()[1]));
}

TEST(AxisDrive, AnyOrderIsLimitedAndEnds) {
  Random random(48);
  const auto number = [&](double low, double high) { return static_cast<float>(random.uniform(low, high)); };
  std::array<int, 6> ends{};
  for (int trial = 0; trial < 3000; ++trial) {
    const float period_s = kPeriods[random.below(kPeriods.size())];
    link::AxisOrder order = order_for(random.below(8) == 0 ? 0.0F : number(0, 0.05));
    order.axis = static_cast<std::uint8_t>(random.below(kAxes));
    order.hold = random.below(3) == 0;
    order.coast_s = random.below(4) == 0 ? 0.0F : number(0, 0.02);
    order.move_s = random.below(4) == 0 ? 0.0F : number(0, 0.1);
    order.offset_N_m = number(-1, 1);
    order.slope_N_m_s = number(-10, 10);
    order.amplitude_N_m = number(-1, 1);
    order.frequency_Hz = number(0, 1000);
    if (random.below(2) == 0) order.most_energy_J = number(0, 0.05);
    for (std::size_t j = 0; j < kAxes; ++j) {
      order.to_rad[j] = number(-1, 1);
      order.stiffness_N_m_rad[j] = random.below(2) == 0 ? 0.0F : number(0, 50);
      order.damping_N_m_s_rad[j] = number(0, 1);
      order.most_torque_N_m[j] = number(0, 2);
      if (random.below(2) == 0) order.most_way_rad[j] = number(0, 0.1);
      if (random.below(2) == 0) order.most_speed_rad_s[j] = number(0, 30);
    }
    Rig rig(period_s);
    rig.start(order);
    const float longest = (order.driven_s + order.coast_s) / period_s + 1.5F;
    int ticks = 0;
    for (; rig.drive.active() && static_cast<float>(ticks) <= longest; ++ticks) {
      const Axes& torque_N_m = rig.drive.tick(rig.angle, kAxes, period_s);
      for (int j = 0; j < kAxes; ++j) {
        ASSERT_LE(std::abs(torque_N_m[j]), order.most_torque_N_m[static_cast<std::size_t>(j)]);
        rig.angle[j] += number(-3, 3) * period_s + 2 * torque_N_m[j] * period_s;
      }
    }
    if (rig.drive.active()) {
      EXPECT_TRUE(order.hold && rig.drive.phase() != AxisPhase::kDriving) << trial;
      rig.drive.stop();
    }
    EXPECT_LE(static_cast<float>(ticks), longest + 1);
    ++ends[static_cast<std::size_t>(rig.drive.end())];
  }
  for (const AxisEnd end : {AxisEnd::kTime, AxisEnd::kWay, AxisEnd::kSpeed, AxisEnd::kEnergy})
    EXPECT_GT(ends[static_cast<std::size_t>(end)], 50) << static_cast<int>(end);
}

}  // namespace
}  // namespace thimble::test
