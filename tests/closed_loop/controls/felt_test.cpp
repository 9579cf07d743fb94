// The force of a control element on a fingertip, through scene file, compiler and renderer, against the
// element's own effort.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "tests/closed_loop/bodies/body_run.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"
#include "tests/support/sanitizers.h"
#include "tests/support/units.h"

namespace thimble::test {
namespace {

using std::numbers::pi;

// One object that is a control; what the material and the body say besides is given.
std::string one_control(const std::string& shape, const std::string& material, const std::string& body,
                        const std::string& control, const std::string& pose = "{}") {
  std::string text = R"("objects": [{"name": "control", "shape": )";
  text.append(shape).append(R"(, "pose": )").append(pose);
  text.append(R"(, "material": {)").append(material).append("}");
  text.append(R"(, "body": {)").append(body).append(R"(, "control": {)").append(control).append("}}}]");
  return text;
}

// A hand that goes straight to a place at a steady speed.
template <typename EachTick>
void go(BodyRun& run, const Vector3d& to, double speed_m_s, const EachTick& each) {
  const Vector3d from = run.tips()[0];
  const int ticks =
      std::max(1, static_cast<int>(std::ceil((to - from).norm() / (speed_m_s * run.period_s()))));
  for (int i = 1; i <= ticks; ++i) {
    run.tick({from + (to - from) * (1.0 * i / ticks)});
    each();
  }
}
void go(BodyRun& run, const Vector3d& to, double speed_m_s) {
  go(run, to, speed_m_s, [] {});
}

double q(const BodyRun& run) { return static_cast<double>(run.body(0).q); }

// A box of 20 x 20 x 20 mm that slides along x; the tip pushes its left side.
constexpr const char* kBox = R"({"box": {"size_m": [0.02, 0.02, 0.02]}})";
const std::string kAlongX = R"("motion": "slide", "mass_kg": 0.04, "axis": [1, 0, 0])";

TEST(Slider, ItsSpringIsFelt) {
  BodyRun run(
      one_control(kBox, R"("stiffness_N_m": 800)", kAlongX, R"("stiffness_N_m": 150, "damping_N_s_m": 2)"),
      {{-.015, 0, 0}});
  double worst_N = 0, most_m = 0;
  go(run, {-.0101, 0, 0}, .05);
  go(run, {.012, 0, 0}, .002, [&] {
    worst_N = std::max(worst_N, std::abs(run.force_N(0).x() + 150 * q(run)));
    most_m = std::max(most_m, q(run));
  });
  // The damper takes 2 N s/m x 2 mm/s = 4 mN of it.
  figure("slider: force off k q over 18 mm, N of 2.7 N", worst_N, "0.02");
  EXPECT_LT(worst_N, .02);
  EXPECT_GT(most_m, .018);
}

TEST(Slider, LeftToItselfItSwingsBackAsTheClosedFormSays) {
  constexpr double kMass_kg = .04, kStiffness = 150;
  for (const double damping : {.5, 2.0, 15.0}) {
    BodyRun run(one_control(kBox, R"("stiffness_N_m": 800)", kAlongX,
                            R"("stiffness_N_m": 150, "damping_N_s_m": )" + std::to_string(damping)),
                {{-.015, 0, 0}});
    go(run, {.012, 0, 0}, .02);
    run.run(2.0);
    const double start_m = q(run);
    ASSERT_GT(start_m, .015);
    const double decay = damping / (2 * kMass_kg);
    const double omega2 = kStiffness / kMass_kg - decay * decay;
    const double omega = std::sqrt(std::abs(omega2));
    double worst_m = 0;
    run.tick({{.012, 0, .05}});  // off over its top: that tick was free already
    for (int i = 1; i < 4000; ++i) {
      const double t = i * run.period_s();
      const double x = omega2 > 0 ? std::cos(omega * t) + decay / omega * std::sin(omega * t)
                                  : std::cosh(omega * t) + decay / omega * std::sinh(omega * t);
      worst_m = std::max(worst_m, std::abs(q(run) - start_m * std::exp(-decay * t) * x));
      run.tick();
    }
    figure("slider let go, off the closed form, of the amplitude; damping " + std::to_string(damping),
           worst_m / start_m, "2 %");
    EXPECT_LT(worst_m, .02 * start_m);
  }
}

// A button of 10 mm height, its top at z = 0, pressed down; curve as in the scene `buttons`.
constexpr const char* kCap = R"({"cylinder": {"radius_m": 0.009, "height_m": 0.01}})";
const std::string kDown = R"("motion": "slide", "mass_kg": 0.02, "axis": [0, 0, -1])";
const std::string kClick = R"("damping_N_s_m": 0.5, "low_m": 0, "high_m": 0.0035,
  "curve_m_N": [[0, 0.3], [0.0015, 2.0], [0.0022, 0.8], [0.0035, 1.6]], "switch": {"on_at_m": 0.002, "off_at_m": 0.001})";
constexpr const char* kBelow = R"({"position_m": [0, 0, -0.005]})";

double curve_N(double q) {
  if (q < .0015) return .3 + 1.7 * q / .0015;
  if (q < .0022) return 2.0 - 1.2 * (q - .0015) / .0007;
  return .8 + .8 * (q - .0022) / .0013;
}

TEST(Button, UnderAHardTipTheWholeCurveIsFeltBothWays) {
  // 4000 N/m is harder than the -1714 N/m of the snap, so every place of the curve is held.
  BodyRun run(one_control(kCap, R"("stiffness_N_m": 4000)", kDown, kClick, kBelow), {{0, 0, .001}});
  double worst_N = 0, most_m = 0;
  const auto compare = [&] {
    const double force_N = run.force_N(0).z();
    if (q(run) <= 1e-5 || q(run) >= .0035) return;  // at the stops a stop pushes too
    worst_N = std::max(worst_N, std::abs(force_N - curve_N(q(run))));
    most_m = std::max(most_m, q(run));
  };
  go(run, {0, 0, -.004}, .002, compare);
  go(run, {0, 0, .001}, .002, compare);
  figure("button: force off its curve, pressing and releasing, N of 2 N", worst_N, "0.02");
  EXPECT_LT(worst_N, .02);
  EXPECT_GT(most_m, .0034);
}

TEST(Button, UnderASoftTipItClicks) {
  constexpr double kTip_N_m = 700;
  BodyRun run(one_control(kCap, R"("stiffness_N_m": 700, "damping_N_s_m": 1)", kDown, kClick, kBelow),
              {{0, 0, .001}});
  double peak_N = 0, peak_at_s = 0, after_N = 1e9, low_after_s = 0;
  go(run, {0, 0, -.0047}, .005, [&] {
    const double force_N = run.force_N(0).z();
    if (peak_N < force_N && after_N > 1e8) {
      peak_N = force_N;
      peak_at_s = run.time_s();
    } else if (peak_N > 1.9 && force_N < after_N) {
      after_N = force_N;
      low_after_s = run.time_s();
    }
  });
  // It snaps at 2 N with the tip 1.5 mm + 2 N / 700 N/m deep, and then rests where the last branch meets the
  // tip's spring.
  const double tip_m = .0015 + 2.0 / kTip_N_m, rising = .8 / .0013;
  const double rests_m = (kTip_N_m * tip_m - .8 + rising * .0022) / (kTip_N_m + rising);
  const double expected_N = kTip_N_m * (tip_m - rests_m);
  figure("click: force at which it snaps, N", peak_N, "2.0 +- 2 %");
  figure("click: drop at the snap, N", peak_N - after_N,
         "at least the closed form's " + std::to_string(2 - expected_N));
  figure("click: from the peak to the bottom, ms", 1e3 * (low_after_s - peak_at_s), "< 40");
  EXPECT_NEAR(peak_N, 2.0, .04);
  EXPECT_GT(peak_N - after_N, 2 - expected_N - .02);
  EXPECT_LT(peak_N - after_N, 2 * (2 - expected_N));  // it overshoots, by no more than an undamped spring
  EXPECT_LT(low_after_s - peak_at_s, .04);
}

TEST(Button, APressAndReleaseCostsTheHandWhatItsHysteresisTakes) {
  constexpr double kTip_N_m = 700;
  BodyRun run(one_control(kCap, R"("stiffness_N_m": 700, "damping_N_s_m": 1)", kDown, kClick, kBelow),
              {{0, 0, .001}});
  double work_J = 0, before_N = 0, tip_m = .001;
  const auto sum = [&] {
    const double force_N = run.force_N(0).z(), z = run.tips()[0].z();
    work_J += .5 * (force_N + before_N) * (z - tip_m);
    before_N = force_N;
    tip_m = z;
  };
  go(run, {0, 0, -.0052}, .001, sum);
  go(run, {0, 0, .001}, .001, sum);
  // Between the two jumps of the tip's depth the branches differ: area of the loop. Series of the tip and a
  // branch effort = e + k (q - q0).
  const auto force = [&](double depth_m, double e, double k, double q0) {
    return kTip_N_m * (e + k * (depth_m - q0)) / (kTip_N_m + k);
  };
  const double snap_m = .0015 + 2.0 / kTip_N_m, back_m = .0022 + .8 / kTip_N_m;
  const auto area = [&](double e, double k, double q0) {
    return .5 * (force(snap_m, e, k, q0) + force(back_m, e, k, q0)) * (snap_m - back_m);
  };
  const double expected_J = area(.3, 1.7 / .0015, 0) - area(.8, .8 / .0013, .0022);
  figure("work on the hand by a press and release, mJ", 1e3 * work_J,
         std::to_string(-1e3 * expected_J) + " +- 6 %");
  EXPECT_LT(work_J, 0);
  EXPECT_NEAR(-work_J, expected_J, .06 * expected_J);  // the dampers take a little more
}

TEST(Button, NoWayOfPressingTakesEnergyOutOfIt) {
  // Pressed and let go at random, with no damper and no friction that could hide a gain; the tip ends free of
  // it each time.
  Random random(3);
  double most_J = -1, sum_J = 0;
  constexpr int kPaths = kUnderSanitizers ? 6 : 60;
  for (int path = 0; path < kPaths; ++path) {
    BodyRun run(one_control(kCap, R"("stiffness_N_m": 700)", kDown + R"(, "restitution": 1)",
                            R"("low_m": 0, "high_m": 0.0035,
                               "curve_m_N": [[0, 0.3], [0.0015, 2.0], [0.0022, 0.8], [0.0035, 1.6]])",
                            kBelow),
                {{0, 0, .001}});
    double work_J = 0;
    Vector3d force_N = Vector3d::Zero(), tip_m = run.tips()[0];
    const auto sum = [&] {
      work_J += .5 * (run.force_N(0) + force_N).dot(run.tips()[0] - tip_m);
      force_N = run.force_N(0);
      tip_m = run.tips()[0];
    };
    for (int stroke = 0; stroke < 12; ++stroke) {
      const Vector3d to(random.uniform(-.004, .004), random.uniform(-.004, .004),
                        random.uniform(-.006, .001));
      go(run, to, std::pow(10.0, random.uniform(-2.5, -.7)), sum);
    }
    go(run, {0, 0, .003}, .05, sum);
    ASSERT_EQ(run.contacts(0), 0);
    most_J = std::max(most_J, work_J);
    sum_J += work_J;
  }
  figure("most work on the hand of " + std::to_string(kPaths) + " random pressings, mJ", 1e3 * most_J, "< 0");
  figure("their mean, mJ", 1e3 * sum_J / kPaths, "reported");
  EXPECT_LT(most_J, 0);
}

TEST(Button, TheSwitchGoesOnOnceAndOffOnceAPress) {
  BodyRun run(one_control(kCap, R"("stiffness_N_m": 700, "damping_N_s_m": 1)", kDown, kClick, kBelow),
              {{0, 0, .001}});
  int ons = 0, offs = 0, presses = 0;
  double on_m = 1, off_m = 0, before_m = 0;
  bool was = false;
  int tick = 0;
  const auto watch = [&] {
    const bool on = run.body(0).on;
    if (on && !was) {
      ++ons;
      on_m = std::min(on_m, q(run));
      EXPECT_LT(before_m, .002F);
      EXPECT_GE(q(run), .002 - 1e-9);
    }
    if (!on && was) {
      ++offs;
      off_m = std::max(off_m, q(run));
      EXPECT_LE(q(run), .001 + 1e-9);
    }
    was = on;
    before_m = q(run);
  };
  for (const double speed : {.003, .02, .1, .3}) {
    go(run, {0, 0, -.0052}, speed, watch);
    for (; tick % 400 != 399; ++tick) {  // a trembling finger
      run.tick({{0, 0, -.0052 + .0003 * std::sin(.06 * tick)}});
      watch();
    }
    ++tick;
    ++presses;
    EXPECT_EQ(ons, presses);
    go(run, {0, 0, .003}, speed, watch);
    run.run(.05);
    watch();
    EXPECT_EQ(offs, presses);
  }
  figure("switch events on for 4 presses", ons, "4");
  figure("switch events off for 4 presses", offs, "4");
}

// A lever that stands 20 mm above its pivot, 20 degrees to the left; the tip pushes it sideways near its end.
const std::string kToggle = R"("damping_N_m_s_rad": 0.0005, "low_deg": 0, "high_deg": 40,
  "curve_deg_N_m": [[0, 0.01], [8, 0.025], [20, 0], [32, -0.025], [40, -0.01]], "switch": {"on_at_deg": 28, "off_at_deg": 12})";

struct Toggle {
  BodyRun run{
      one_control(R"({"capsule": {"radius_m": 0.004, "height_m": 0.02}})",
                  R"("stiffness_N_m": 700, "damping_N_s_m": 1)",
                  R"("motion": "turn", "mass_kg": 0.03, "axis": [0, 1, 0], "pivot_m": [0, 0, 0])", kToggle,
                  R"({"position_m": [-0.0041042, 0, 0.0112763], "rotation_deg": [0, -20, 0]})"),
      {{-.03, 0, .017}}};
  // From beside it at the height of 17 mm towards x, off upwards, and a second for it to come to rest.
  void push(double from_m, double to_m) {
    run.tick({{from_m, 0, .08}});
    go(run, {from_m, 0, .017}, .5);
    go(run, {to_m, 0, .017}, .05);
    run.tick({{to_m, 0, .08}});
    run.run(1);
  }
  [[nodiscard]] double angle_deg() const { return q(run) / kDegree; }
  [[nodiscard]] bool on() const { return run.body(0).on; }
};

TEST(Toggle, HasTwoStatesAndStaysWhereItWasLeft) {
  Toggle toggle;
  toggle.run.run(1);
  EXPECT_NEAR(toggle.angle_deg(), 0, 1e-3);
  EXPECT_FALSE(toggle.on());
  toggle.push(-.03, .008);
  figure("toggle pushed over, degrees", toggle.angle_deg(), "40");
  EXPECT_NEAR(toggle.angle_deg(), 40, 1e-3);
  EXPECT_TRUE(toggle.on());
  toggle.run.run(5);
  EXPECT_NEAR(toggle.angle_deg(), 40, 1e-3);
  EXPECT_TRUE(toggle.on());
  toggle.push(.03, -.008);
  figure("toggle pushed back, degrees", toggle.angle_deg(), "0");
  EXPECT_NEAR(toggle.angle_deg(), 0, 1e-3);
  EXPECT_FALSE(toggle.on());
}

TEST(Toggle, PushedNotFarEnoughItComesBack) {
  Toggle toggle;
  toggle.push(-.03, -.006);
  EXPECT_NEAR(toggle.angle_deg(), 0, 1e-3);
  EXPECT_FALSE(toggle.on());
}

TEST(Toggle, ItsSwitchHasHysteresis) {
  // Slowly over and back by a tip that is harder than the lever's snap: on beyond 28 degrees, off below 12.
  Toggle toggle;
  double on_deg = 0, off_deg = 99;
  const auto watch = [&] {
    if (toggle.on() && on_deg == 0) on_deg = toggle.angle_deg();
    if (on_deg > 0 && !toggle.on()) off_deg = std::min(off_deg, toggle.angle_deg());
  };
  go(toggle.run, {.008, 0, .017}, .01, watch);
  toggle.run.tick({{.03, 0, .08}});
  go(toggle.run, {.03, 0, .017}, .5, watch);
  go(toggle.run, {-.008, 0, .017}, .01, watch);
  figure("toggle goes on at, degrees", on_deg, "28 to 29");
  EXPECT_GE(on_deg, 28 - 1e-3);
  EXPECT_LE(on_deg, 29);
  EXPECT_LE(off_deg, 12);
  EXPECT_FALSE(toggle.on());
}

// A dial turned by a fingertip that sticks on its top, 15 mm from its axis: the tip can pull it as well as
// push.
constexpr double kRadius_m = .015;
const std::string kDialBody = R"("motion": "turn", "mass_kg": 0.05, "axis": [0, 0, 1])";
const std::string kRubber = R"("stiffness_N_m": 800, "static_friction": 5)";

struct Dial {
  explicit Dial(const std::string& control)
      : run(one_control(R"({"cylinder": {"radius_m": 0.02, "height_m": 0.01}})", kRubber, kDialBody, control,
                        kBelow),
            {{kRadius_m, 0, .001}}) {
    go(run, {kRadius_m, 0, -.002}, .01);
  }
  // The tip round to an angle; each(angle of the tip) after every tick.
  template <typename EachTick>
  void turn(double from_deg, double to_deg, double deg_per_s, const EachTick& each) {
    const int ticks = static_cast<int>(std::abs(to_deg - from_deg) / (deg_per_s * run.period_s()));
    for (int i = 1; i <= ticks; ++i) {
      const double a = kDegree * (from_deg + (to_deg - from_deg) * i / ticks);
      run.tick({{kRadius_m * std::cos(a), kRadius_m * std::sin(a), -.002}});
      each(a);
    }
  }
  // About the axis, of the dial on the hand.
  [[nodiscard]] double torque_N_m() const { return run.tips()[0].cross(run.force_N(0)).z(); }
  BodyRun run;
};

TEST(Knob, TheTorqueOfItsDetentsIsTheSlopeOfTheirPotential) {
  constexpr double kTorque = .008, kPitch = 30, kSpeed_deg_s = 6;
  Dial dial(R"("damping_N_m_s_rad": 0.0005, "detents": {"pitch_deg": 30, "torque_N_m": 0.008})");
  double worst = 0, work_J = 0, most_J = 0, before = dial.torque_N_m(), angle = 0, highest = -1, lowest = 1;
  dial.turn(0, 90, kSpeed_deg_s, [&](double a) {
    const double torque = dial.torque_N_m();
    worst = std::max(worst, std::abs(torque + kTorque * std::sin(2 * pi * q(dial.run) / (kPitch * kDegree))));
    work_J -= .5 * (torque + before) * (a - angle);  // by the hand
    most_J = std::max(most_J, work_J);
    before = torque;
    angle = a;
    highest = std::max(highest, torque);
    lowest = std::min(lowest, torque);
  });
  figure("detents: torque off their potential's slope, of the highest", worst / kTorque, "2 %");
  EXPECT_LT(worst, .02 * kTorque);
  EXPECT_NEAR(highest, kTorque, .03 * kTorque);
  EXPECT_NEAR(lowest, -kTorque, .03 * kTorque);
  // Top of the potential: torque x pitch / pi. After three detents nothing is left of it: the rest is damping
  // x speed x way.
  const double top_J = kTorque * kPitch * kDegree / pi;
  const double damped_J = .0005 * kSpeed_deg_s * kDegree * 90 * kDegree;
  figure("work over three detents but for damping, of the height of one", (work_J - damped_J) / top_J,
         "0 to 2 %");
  EXPECT_GT(work_J, damped_J);
  EXPECT_LT(work_J - damped_J, .02 * top_J);
  EXPECT_GT(most_J, top_J);
}

TEST(Knob, LeftAnywhereItGoesToTheNearestDetentAndStays) {
  for (const double left_deg : {11.0, 19.0, 40.0, 50.0, 78.0}) {
    Dial dial(R"("damping_N_m_s_rad": 0.0005, "detents": {"pitch_deg": 30, "torque_N_m": 0.008})");
    dial.turn(0, left_deg, 60, [](double) {});
    dial.run.run(.2);
    const double at_deg = q(dial.run) / kDegree;
    dial.run.tick({{0, 0, .05}});
    dial.run.run(1);
    const double rests_deg = q(dial.run) / kDegree;
    figure("knob left at " + std::to_string(at_deg) + " rests at, degrees", rests_deg, "nearest 30 n");
    EXPECT_NEAR(rests_deg, 30 * std::round(at_deg / 30), .05);
  }
}

TEST(Knob, FrictionIsFeltEitherWayAndHoldsIt) {
  constexpr double kFriction = .004, kSpeed_deg_s = 6;
  Dial dial(R"("friction_N_m": 0.004, "damping_N_m_s_rad": 0.001)");
  const double expected = kFriction + .001 * kSpeed_deg_s * kDegree;
  double forth = 0, back = 0, work_J = 0, before = 0, angle = 0;
  const auto sum = [&](double a) {
    work_J -= .5 * (dial.torque_N_m() + before) * (a - angle);
    before = dial.torque_N_m();
    angle = a;
  };
  dial.turn(0, 60, kSpeed_deg_s, [&](double a) {
    sum(a);
    forth = dial.torque_N_m();
  });
  dial.turn(60, 0, kSpeed_deg_s, [&](double a) {
    sum(a);
    back = dial.torque_N_m();
  });
  figure("knob's friction felt forth, of friction and damping", forth / expected, "-1 +- 1 %");
  figure("knob's friction felt back, of friction and damping", back / expected, "1 +- 1 %");
  EXPECT_NEAR(forth, -expected, .01 * expected);
  EXPECT_NEAR(back, expected, .01 * expected);
  // To and fro costs the friction's work: the fingertip's spring is stretched the one way and the other, 2 x
  // 2 degrees of play.
  const double expected_J = expected * 120 * kDegree;
  figure("work of a turn to and fro, of friction x way", work_J / expected_J, "0.9 to 1");
  EXPECT_LE(work_J, expected_J);
  EXPECT_GE(work_J, .9 * expected_J);
  // Let go, it stays to the bit.
  dial.run.tick({{0, 0, .05}});
  dial.run.run(.1);
  const double rests = q(dial.run);
  dial.run.run(1);
  EXPECT_EQ(q(dial.run), rests);
}

TEST(Fader, ItsNotchesAreAtTheirPitch) {
  BodyRun run(one_control(kBox, R"("stiffness_N_m": 3000)", kAlongX,
                          R"("damping_N_s_m": 5, "friction_N": 0.2, "high_m": 0.03, "low_m": 0,
                             "detents": {"pitch_m": 0.005, "force_N": 0.8})"),
              {{-.0105, 0, 0}});
  // In the rising half of each notch, where the force is greatest.
  std::array<double, 5> peak_N{}, peak_m{};
  double highest_N = 0;
  go(run, {.016, 0, 0}, .002, [&] {
    const double force_N = -run.force_N(0).x();
    highest_N = std::max(highest_N, force_N);
    const auto notch = static_cast<std::size_t>(std::max(q(run), 0.0) / .005);
    if (notch < peak_N.size() && force_N > peak_N[notch]) {
      peak_N[notch] = force_N;
      peak_m[notch] = q(run);
    }
  });
  for (std::size_t i = 0; i < peak_N.size(); ++i) {
    const double expected_m = .00125 + .005 * static_cast<double>(i);
    figure("notch passed at, mm", 1e3 * peak_m[i], std::to_string(1e3 * expected_m) + " +- 0.25");
    EXPECT_NEAR(peak_m[i], expected_m, 2.5e-4);
    EXPECT_NEAR(peak_N[i], 1.0, .03);
  }
  figure("fader: most force, N", highest_N, "1.0: notch and friction");
  EXPECT_NEAR(highest_N, 1.0, .03);
}

}  // namespace
}  // namespace thimble::test
