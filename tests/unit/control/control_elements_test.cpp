// The dynamics of a control's coordinate against closed forms, at the tick of 4 kHz.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "control/bodies/control_element.h"
#include "tests/support/figure.h"

namespace thimble::test {
namespace {

using control::ControlElementParams;
using control::ControlElementState;
using std::numbers::pi;

constexpr double kPeriod_s = 1.0 / 4000.0;

void tick(const ControlElementParams& params, ControlElementState& state, double effort, double inertia) {
  advance_control_element(params, state, static_cast<float>(effort), static_cast<float>(inertia),
                          static_cast<float>(kPeriod_s));
}

ControlElementState at(const ControlElementParams& params, float q, float speed = 0.0F) {
  ControlElementState state = start_control_element(params, speed);
  state.q = q;
  return state;
}

// The potential that control_element_effort is to be the slope of, in double and term by term.
double potential(const ControlElementParams& p, double q) {
  const double k = static_cast<double>(p.stiffness), pitch = static_cast<double>(p.detent_pitch);
  double energy = k / 2 * std::pow(q - static_cast<double>(p.rest), 2);
  if (pitch > 0.0)
    energy -= static_cast<double>(p.detent_effort) * pitch / (2 * pi) *
              std::cos(2 * pi * (q - static_cast<double>(p.detent_phase)) / pitch);
  for (std::size_t i = 1; i < p.curve.size(); ++i) {  // trapezoids up to q
    const double a = static_cast<double>(p.curve[i - 1].at()), b = static_cast<double>(p.curve[i].at());
    if (q <= a) break;
    const double fa = static_cast<double>(p.curve[i - 1].effort()),
                 fb = static_cast<double>(p.curve[i].effort());
    const double end = std::min(q, b), f = fa + (fb - fa) * (end - a) / (b - a);
    energy += (fa + f) / 2 * (end - a);
  }
  return energy;
}

TEST(Control, ASpringCentredSliderSwingsWithItsClosedForm) {
  const ControlElementParams params{.stiffness = 200.0F};
  constexpr double kMass_kg = 0.05, kOmega = 63.245553203367585;  // sqrt(200 / 0.05)
  ControlElementState state = at(params, 0.01F);
  double crossing_s = 0, first_s = 0, most_m = 0;
  int crossings = 0;
  for (int i = 0; i < 40000; ++i) {
    const double before = static_cast<double>(state.q);
    tick(params, state, 0.0, kMass_kg);
    const double q = static_cast<double>(state.q);
    if (before < 0.0 && q >= 0.0) {
      crossing_s = (i + before / (before - q)) * kPeriod_s;
      if (crossings++ == 0) first_s = crossing_s;
    }
    if (i > 39000) most_m = std::max(most_m, q);
  }
  const double omega = 2 * pi * (crossings - 1) / (crossing_s - first_s);
  // Semi-implicit Euler: sin(w' T / 2) = w T / 2.
  const double expected = 2 / kPeriod_s * std::asin(kOmega * kPeriod_s / 2);
  figure("frequency against the closed form, relative", omega / kOmega - 1, "1e-4");
  figure("amplitude after 10 s against the start, relative", most_m / 0.01 - 1, "5e-3");
  EXPECT_NEAR(omega / kOmega, 1.0, 1e-4);
  EXPECT_NEAR(omega / expected, 1.0, 1e-5);
  EXPECT_NEAR(most_m, 0.01, 5e-5);
}

TEST(Control, DampingTakesTheAmplitudeOfTheClosedForm) {
  const ControlElementParams params{.stiffness = 200.0F, .damping = 0.5F};
  constexpr double kMass_kg = 0.05, kDecay = 0.5 / (2 * kMass_kg);
  const double omega = std::sqrt(200 / kMass_kg - kDecay * kDecay);
  ControlElementState state = at(params, 0.01F);
  double worst_m = 0;
  for (int i = 1; i < 4000; ++i) {
    tick(params, state, 0.0, kMass_kg);
    const double t = i * kPeriod_s;
    const double expected =
        0.01 * std::exp(-kDecay * t) * (std::cos(omega * t) + kDecay / omega * std::sin(omega * t));
    worst_m = std::max(worst_m, std::abs(static_cast<double>(state.q) - expected));
  }
  figure("damped slider: off the closed form over 1 s, of the amplitude", worst_m / 0.01, "1 %");
  EXPECT_LT(worst_m, 1e-4);
}

const std::array kSnap{scene::CurvePoint(0.0F, 0.2F), scene::CurvePoint(0.002F, 2.2F),
                       scene::CurvePoint(0.003F, 0.7F), scene::CurvePoint(0.005F, 3.0F)};

TEST(Control, EffortIsTheSlopeOfItsPotential) {
  const ControlElementParams params{.stiffness = 50.0F,
                                    .rest = -0.001F,
                                    .detent_pitch = 0.004F,
                                    .detent_phase = 0.0005F,
                                    .detent_effort = 0.8F,
                                    .curve = kSnap};
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const double q = static_cast<double>(static_cast<float>(0.00001 + 0.004979 * i / 1000)), h = 1e-8;
    const double slope = (potential(params, q + h) - potential(params, q - h)) / (2 * h);
    worst = std::max(
        worst, std::abs(-slope - static_cast<double>(control_element_effort(params, static_cast<float>(q)))));
  }
  figure("effort off the slope of the potential, N of 3 N", worst, "2e-3");
  EXPECT_LT(worst, 2e-3);
  // Beyond its ends the curve stays what it was there.
  const ControlElementParams curve{.curve = kSnap};
  EXPECT_EQ(control_element_effort(curve, -1.0F), -0.2F);
  EXPECT_EQ(control_element_effort(curve, 1.0F), -3.0F);
  // Far from the start a detent is what it is there.
  const ControlElementParams knob{.detent_pitch = 0.5F, .detent_effort = 0.02F};
  EXPECT_NEAR(control_element_effort(knob, 90.125F), control_element_effort(knob, 0.125F), 1e-6F);
  EXPECT_NEAR(control_element_effort(knob, 0.125F), -0.02F, 1e-7F);
}

TEST(Control, WithoutLossesEnergyStaysOverAMillionTicks) {
  // Spring, detents and snap-through together: within one detent, and over all of them.
  constexpr double kMass_kg = 0.02;
  for (const float speed : {0.1F, 0.7F}) {
    const ControlElementParams params{
        .stiffness = 400.0F, .rest = 0.003F, .detent_pitch = 0.002F, .detent_effort = 0.5F, .curve = kSnap};
    ControlElementState state = start_control_element(params, speed);
    const auto energy = [&](double q, double v) { return kMass_kg / 2 * v * v + potential(params, q); };
    const double kinetic_J = energy(0.0, static_cast<double>(speed)) - potential(params, 0.0);
    constexpr int kTicks = 1'000'000, kPart = 100'000;
    double first_J = 0, last_J = 0;
    for (int i = 0; i < kTicks; ++i) {
      const double v = static_cast<double>(state.speed);
      const double q = static_cast<double>(state.q);
      tick(params, state, 0.0, kMass_kg);
      // At q the speed is the mean of those before and after: so the scheme is of second order.
      const double now_J = energy(q, (v + static_cast<double>(state.speed)) / 2);
      if (i < kPart) first_J += now_J / kPart;
      if (i >= kTicks - kPart) last_J += now_J / kPart;
    }
    figure("drift of energy over 1e6 ticks, of the kinetic at the start", (last_J - first_J) / kinetic_J,
           "+-1 %");
    EXPECT_NEAR(last_J, first_J, 0.01 * kinetic_J) << speed;
  }
}

TEST(Control, FrictionHoldsWithoutCreepAndThenResists) {
  const ControlElementParams params{.stiffness = 100.0F, .friction = 0.5F};
  ControlElementState state = at(params, 0.004F);  // pulled home with 0.4 N
  for (int i = 0; i < 100000; ++i) tick(params, state, 0.08 * std::sin(0.1 * i), 0.05);
  EXPECT_EQ(state.q, 0.004F);
  EXPECT_EQ(state.speed, 0.0F);

  // Slid across a table: x = v^2 m / (2 F), and there it stays to the bit.
  const ControlElementParams table{.friction = 0.5F};
  ControlElementState puck = at(table, 0.0F, 0.3F);
  for (int i = 0; i < 4000; ++i) tick(table, puck, 0.0, 0.05);
  const float rested = puck.q;
  const double expected = 0.3 * 0.3 * 0.05 / (2 * 0.5);
  figure("way until friction stops it, relative to m v^2 / 2 F", static_cast<double>(rested) / expected - 1,
         "1 %");
  EXPECT_NEAR(static_cast<double>(rested), expected, 0.01 * expected);
  EXPECT_EQ(puck.speed, 0.0F);
  for (int i = 0; i < 4000; ++i) tick(table, puck, 0.499, 0.05);
  EXPECT_EQ(puck.q, rested);
  // A driven one: a = (F - friction) / m.
  for (int i = 0; i < 400; ++i) tick(table, puck, 0.7, 0.05);
  EXPECT_NEAR(static_cast<double>(puck.speed), 0.1 * (0.7 - 0.5) / 0.05, 1e-4);
}

TEST(Control, StopsHoldAndGiveBackTheirRestitution) {
  const ControlElementParams params{.low = -0.01F, .high = 0.01F, .restitution = 0.6F};
  ControlElementState state = at(params, 0.0F, 0.4F);
  std::vector<double> speeds;
  for (int i = 0; i < 4000; ++i) {
    const double before = static_cast<double>(state.speed);
    tick(params, state, 0.0, 0.05);
    EXPECT_LE(std::abs(state.q), 0.01F);
    if (before * static_cast<double>(state.speed) < 0.0)
      speeds.push_back(std::abs(static_cast<double>(state.speed) / before));
  }
  ASSERT_GE(speeds.size(), 2U);
  for (const double ratio : speeds) EXPECT_NEAR(ratio, 0.6, 1e-5);
  // Pushed against a stop: there, at rest, without a buzz.
  for (int i = 0; i < 4000; ++i) tick(params, state, 2.0, 0.05);
  for (int i = 0; i < 4000; ++i) {
    tick(params, state, 2.0, 0.05);
    ASSERT_EQ(state.q, 0.01F);
    ASSERT_EQ(state.speed, 0.0F);
  }
  tick(params, state, -2.0, 0.05);
  EXPECT_LT(state.q, 0.01F);
}

// Pressed ever so slowly by a soft spring, the snap is passed at once, and back at another place: the loop between is
// the energy that the click takes.
TEST(Control, ASnapThroughHasHysteresisUnderASoftFinger) {
  const ControlElementParams params{.damping = 0.5F, .low = 0.0F, .high = 0.005F, .curve = kSnap};
  constexpr double kFinger_N_m = 500.0, kMass_kg = 0.01;  // softer than the -1500 N/m of the snap
  ControlElementState state = start_control_element(params);
  const auto press = [&](double finger_m) {
    for (int i = 0; i < 2; ++i)
      tick(params, state, std::max(0.0, kFinger_N_m * (finger_m - static_cast<double>(state.q))), kMass_kg);
    return kFinger_N_m * (finger_m - static_cast<double>(state.q));
  };
  constexpr int kSteps = 40000;
  constexpr double kDeep_m = 0.010;
  double snap_N = 0, release_q = 1, work_J = 0, before_N = 0;
  bool through = false;
  double peak_N = 0;
  for (int i = 0; i <= 2 * kSteps; ++i) {
    const double finger_m = kDeep_m * (i <= kSteps ? i : 2 * kSteps - i) / kSteps;
    const double q = static_cast<double>(state.q);
    const double force_N = std::max(press(finger_m), 0.0);
    if (i > 0) work_J += (force_N + before_N) / 2 * kDeep_m / kSteps * (i <= kSteps ? 1.0 : -1.0);
    before_N = force_N;
    if (i <= kSteps && !through) {
      peak_N = std::max(peak_N, force_N);
      if (static_cast<double>(state.q) > 0.0025) {
        through = true;
        snap_N = peak_N;
      }
    }
    if (i > kSteps && q > 0.0025 && static_cast<double>(state.q) <= 0.0025) release_q = finger_m;
  }
  // Stationary points: press at the peak (2 mm, 2.2 N), release at the valley (3 mm, 0.7 N).
  const double press_finger_m = 0.002 + 2.2 / kFinger_N_m, release_finger_m = 0.003 + 0.7 / kFinger_N_m;
  figure("snap at, N", snap_N, "2.2 +- 1 %");
  figure("snaps back with the finger at, mm", release_q * 1e3, "4.4 +- 2 %");
  EXPECT_NEAR(snap_N, 2.2, 0.022);
  EXPECT_NEAR(release_q, release_finger_m, 0.02 * release_finger_m);
  // The loop between the two jumps, in the finger's force over the finger's way.
  // Branch up: F on the curve's first line; branch down: on its last one.
  const auto area = [&](double k, double f0, double q0, double from, double to) {
    const auto force = [&](double x) { return kFinger_N_m * (k * (x - q0) + f0) / (k + kFinger_N_m); };
    return (force(from) + force(to)) / 2 * (to - from);
  };
  const double expected_J = area(1000.0, 0.2, 0.0, release_finger_m, press_finger_m) -
                            area(1150.0, 0.7, 0.003, release_finger_m, press_finger_m);
  figure("energy that a press and release takes, mJ", work_J * 1e3, "closed form +- 3 %");
  EXPECT_NEAR(work_J, expected_J, 0.03 * expected_J);
}

TEST(Control, ASwitchHasHysteresisEitherWay) {
  for (const float sign : {1.0F, -1.0F}) {
    const ControlElementParams params{.has_switch = true, .on_at = sign * 0.004F, .off_at = sign * 0.002F};
    ControlElementState state = start_control_element(params);
    EXPECT_FALSE(state.on);
    int changes = 0;
    const auto go = [&](float to) {
      for (int i = 0; i < 50; ++i) {  // trembling on the way
        const bool was = state.on;
        state.q = sign * (to + (i % 2 == 0 ? 0.0009F : -0.0009F));
        state.speed = 0.0F;
        tick(params, state, 0.0, 0.05);
        changes += was != state.on ? 1 : 0;
      }
    };
    go(0.003F);
    EXPECT_FALSE(state.on);
    go(0.0041F);
    EXPECT_TRUE(state.on);
    go(0.003F);
    EXPECT_TRUE(state.on);
    go(0.0019F);
    EXPECT_FALSE(state.on);
    EXPECT_EQ(changes, 2);
  }
  // It starts as its place has it.
  EXPECT_TRUE(control::start_control_element({.has_switch = true, .on_at = -0.1F, .off_at = -0.2F}).on);
}

TEST(Control, StableAtTheStiffestThatPasses) {
  // sqrt(k / m) = kMaxControlRate_rad_s, at 4 kHz and at the 1 kHz of a slow board.
  constexpr float kMass_kg = 0.01F;
  const float k = control::kMaxControlRate_rad_s * control::kMaxControlRate_rad_s * kMass_kg;
  const ControlElementParams params{.detent_pitch = 0.002F,
                                    .detent_effort = k * 0.002F / (2.0F * std::numbers::pi_v<float>)};
  for (const float period_s : {2.5e-4F, 1.0e-3F}) {
    ControlElementState state = at(params, 0.0002F);
    float most = 0.0F;
    for (int i = 0; i < 100000; ++i) {
      advance_control_element(params, state, 0.0F, kMass_kg, period_s);
      most = std::max(most, std::abs(state.q));
    }
    figure("stiffest detent: swing from 0.2 mm, mm", static_cast<double>(most) * 1e3, "< 0.3");
    EXPECT_LT(most, 0.0003F);
  }
}

}  // namespace
}  // namespace thimble::test
