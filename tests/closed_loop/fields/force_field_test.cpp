// Force fields: their law against the closed form, when they begin, what they give to a hand, and their mass against a finer integration.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include "board/sim/simulation.h"
#include "host-tools/compiler/compile.h"
#include "tests/closed_loop/fields/support.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

constexpr double kPeriod_s = 1.0 / kRate_Hz;
constexpr double kMostAtStart_J = 2.0e-3;  // docs/scene-format.md

std::string text(const Vector3d& v) {
  static const Eigen::IOFormat kExact(Eigen::FullPrecision, 0, ", ", ", ", "", "", "[", "]");
  std::ostringstream text;
  text << v.transpose().format(kExact);
  return text.str();
}

std::string named(const std::string& name, const std::string& shape, const std::string& rest = "") {
  return R"({"name": ")" + name + R"(", "shape": {)" + shape + "}" + rest + "}";
}

std::string force_field(const std::string& name, const std::string& keys, const std::string& rest = "") {
  return named(name, R"("force_field": {)" + keys + "}", rest);
}

SceneImage scene_of(const std::string& objects) {
  return SceneImage(
      host::compile_scene_text(R"({"thimble_scene": 1, "name": "fields", "objects": [)" + objects + "]}",
                               "fields", {})
          .image);
}

// A smooth way of a hand: three sines along each axis, from 0.2 to 2 Hz.
class Wander {
 public:
  Wander(Random& random, double size_m) {
    for (int i = 0; i < 9; ++i) {
      size_m_[i] = random.uniform(0.2, 1.0) * size_m / 3;
      rate_[i] = 2 * M_PI * random.uniform(0.2, 2.0);
      phase_[i] = random.uniform(0.0, 2 * M_PI);
    }
  }
  [[nodiscard]] Vector3d at(double time_s) const {
    Vector3d p = Vector3d::Zero();
    for (int i = 0; i < 9; ++i) p[i % 3] += size_m_[i] * std::sin(rate_[i] * time_s + phase_[i]);
    return p;
  }

 private:
  Eigen::Matrix<double, 9, 1> size_m_, rate_, phase_;
};

TEST(ForceField, IsWhatTheFileSaysInTheFrameOfTheObject) {
  Random random(1);
  double worst_N = 0, most_N = 0;
  for (int round = 0; round < 50; ++round) {
    const Vector3d constant_N = random.in_box(Vector3d::Constant(3));
    const Vector3d stiffness_N_m = random.in_box(Vector3d::Constant(400)).cwiseMax(0);
    const Vector3d damping_N_s_m = random.in_box(Vector3d::Constant(10)).cwiseAbs();
    const Vector3d curl_N_s_m = random.in_box(Vector3d::Constant(15));
    const Vector3d place_m = random.in_box(Vector3d::Constant(0.02));
    const Vector3d turn_deg = random.in_box(Vector3d::Constant(180));
    const auto about = [&](int axis) {
      return Eigen::AngleAxisd(turn_deg[axis] * M_PI / 180, Vector3d::Unit(axis));
    };
    const Eigen::Quaterniond rotation(about(2) * about(1) * about(0));
    const std::string keys = R"("constant_N": )" + text(constant_N) + R"(, "stiffness_N_m": )" +
                             text(stiffness_N_m) + R"(, "damping_N_s_m": )" + text(damping_N_s_m) +
                             R"(, "curl_N_s_m": )" + text(curl_N_s_m);
    const SceneImage image = scene_of(force_field(
        "all at once", keys,
        R"(, "pose": {"position_m": )" + text(place_m) + R"(, "rotation_deg": )" + text(turn_deg) + "}"));
    IdealRun run(image);
    run.step(place_m);
    const Wander hand(random, 0.05);
    Vector3d before = run.felt().tip_m;
    Vector3d slow_m_s = Vector3d::Zero();  // the velocity below 10 Hz
    for (int tick = 0; tick < 400; ++tick) {
      const Felt& felt = run.step(place_m + hand.at(tick * kPeriod_s) - hand.at(0));
      const Vector3d p = rotation.conjugate() * (felt.tip_m - place_m);
      const Vector3d v = rotation.conjugate() * ((felt.tip_m - before) / kPeriod_s);
      slow_m_s += kPeriod_s / (0.016 + kPeriod_s) * (v - slow_m_s);
      Vector3d curl_N = curl_N_s_m.cross(slow_m_s);
      if (curl_N.dot(v) > 0)
        curl_N -= curl_N.dot(v) / v.squaredNorm() * v;  // it never pushes along the motion
      const Vector3d force_N =
          rotation * (constant_N - stiffness_N_m.cwiseProduct(p) - damping_N_s_m.cwiseProduct(v) + curl_N);
      worst_N = std::max(worst_N, (felt.force_N - force_N).norm());
      most_N = std::max(most_N, force_N.norm());
      EXPECT_EQ(felt.contacts, 1);
      before = felt.tip_m;
    }
  }
  EXPECT_GT(most_N, 5.0);
  EXPECT_LT(
      figure("force fields: off the closed form, N, of up to " + std::to_string(most_N), worst_N, "1e-4"),
      1e-4);
}

TEST(ForceField, BeginsWhereItsSpringHoldsLittleAndEndsWhereItsBoxEnds) {
  constexpr double kStiffness = 400;
  const double begins_m = std::sqrt(2 * kMostAtStart_J / kStiffness);
  const SceneImage image =
      scene_of(force_field("channel", R"("stiffness_N_m": [0, 400, 0], "size_m": [0.1, 0.06, 0.1])"));
  for (const double from_m : {0.05, 0.029, -0.05, 1.1 * begins_m}) {  // outside, and within the box
    IdealRun run(image);
    run.step({0.01, from_m, 0});
    EXPECT_EQ(run.felt().contacts, 0);
    const double side = from_m > 0 ? 1 : -1;
    run.move({0.01, side * begins_m * 1.001, 0}, 1e-5);
    EXPECT_EQ(run.felt().force_N.norm(), 0) << from_m;
    run.move({0.01, side * begins_m * 0.99, 0}, 1e-5);
    EXPECT_NEAR(run.felt().force_N.y(), -side * kStiffness * begins_m, 0.02) << from_m;
    EXPECT_NEAR(run.felt().god_object_m.y(), 0, 1e-9);
    EXPECT_NEAR(run.felt().god_object_m.x(), run.felt().tip_m.x(), 1e-9);
    run.move({0.01, side * 0.0299, 0}, 1e-5);  // it goes on as far as its box does
    EXPECT_NEAR(run.felt().force_N.y(), -side * kStiffness * 0.0299, 1e-3);
    run.move({0.01, side * 0.031, 0}, 1e-5);
    EXPECT_EQ(run.felt().contacts, 0);
    run.move({0.01, side * 0.02, 0}, 1e-5);  // and begins anew
    EXPECT_EQ(run.felt().force_N.norm(), 0);
  }
}

TEST(ForceField, ActsOnTopOfWhatTheTipTouches) {
  const std::string wall =
      named("wall", R"("plane": {"normal": [0, 0, 1]})",
            R"(, "material": {"stiffness_N_m": 900, "static_friction": 0.5, "damping_N_s_m": 1})");
  const std::string other =
      named("ball", R"("sphere": {"radius_m": 0.01})",
            R"(, "material": {"stiffness_N_m": 300}, "pose": {"position_m": [0.01, 0, 0.004]})");
  const std::string fields =
      force_field("wind", R"("constant_N": [1, -2, 0.5], "curl_N_s_m": [0, 0, 8])") + "," +
      force_field("mass", R"("mass": {"mass_kg": 0.2, "stiffness_N_m": 100, "damping_N_s_m": 0.5})");
  const SceneImage solids = scene_of(wall + "," + other), both = scene_of(fields + "," + wall + "," + other),
                   alone = scene_of(fields);
  Random random(3);
  const Wander hand(random, 0.03);
  IdealRun a(solids), b(both), c(alone);
  double worst_N = 0;
  int touched = 0;
  for (int tick = 0; tick < 20000; ++tick) {
    const Vector3d p = hand.at(tick * kPeriod_s);
    const Felt &solid = a.step(p), &all = b.step(p), &field = c.step(p);
    touched += solid.contacts != 0 ? 1 : 0;
    worst_N = std::max(worst_N, (all.force_N - solid.force_N - field.force_N).norm());
    EXPECT_TRUE(solid.contacts == 0 || all.god_object_m == solid.god_object_m);
  }
  EXPECT_GT(touched, 2000);
  EXPECT_LT(figure("force fields over two solids: off the sum, N", worst_N, "1e-5"), 1e-5);
}

// The pull of a mass on a hand that moves like this, by the classical rule of Runge and Kutta in steps of a tenth of a tick.
class FineMass {
 public:
  FineMass(double mass_kg, double stiffness_N_m, double damping_N_s_m, const Wander& hand)
      : mass_kg_(mass_kg), stiffness_N_m_(stiffness_N_m), damping_N_s_m_(damping_N_s_m), hand_(hand) {
    x_ << hand.at(0), Vector3d::Zero();
  }
  Vector3d go_on() {
    for (int i = 0; i < 10; ++i) {
      constexpr double h = kPeriod_s / 10;
      const State a = rate(time_s_, x_), b = rate(time_s_ + h / 2, x_ + h / 2 * a),
                  c = rate(time_s_ + h / 2, x_ + h / 2 * b), d = rate(time_s_ + h, x_ + h * c);
      x_ += h / 6 * (a + 2 * b + 2 * c + d);
      time_s_ += h;
    }
    return -mass_kg_ * rate(time_s_, x_).tail<3>();
  }

 private:
  using State = Eigen::Matrix<double, 6, 1>;
  [[nodiscard]] State rate(double time_s, const State& x) const {
    constexpr double kSmall_s = 1e-6;
    const Vector3d p = hand_.at(time_s);
    const Vector3d v = (hand_.at(time_s + kSmall_s) - hand_.at(time_s - kSmall_s)) / (2 * kSmall_s);
    State rate;
    rate << x.tail<3>(), (stiffness_N_m_ * (p - x.head<3>()) + damping_N_s_m_ * (v - x.tail<3>())) / mass_kg_;
    return rate;
  }
  double mass_kg_, stiffness_N_m_, damping_N_s_m_, time_s_ = 0;
  const Wander& hand_;
  State x_;
};

TEST(ForceField, TheMassPullsAsAFinerIntegrationSays) {
  Random random(4);
  double worst = 0;
  for (const auto& [mass_kg, stiffness_N_m, damping_N_s_m] :
       {std::tuple(0.5, 100.0, 0.0), std::tuple(0.2, 400.0, 1.0), std::tuple(2.0, 50.0, 5.0)}) {
    const std::string keys = R"("mass": {"mass_kg": )" + std::to_string(mass_kg) + R"(, "stiffness_N_m": )" +
                             std::to_string(stiffness_N_m) + R"(, "damping_N_s_m": )" +
                             std::to_string(damping_N_s_m) + "}";
    IdealRun run(scene_of(force_field("cup", keys)));
    const Wander hand(random, 0.05);
    FineMass mass(mass_kg, stiffness_N_m, damping_N_s_m, hand);
    run.step(hand.at(0));
    double most_N = 0, off_N = 0;
    for (int tick = 1; tick < 20000; ++tick) {
      const Vector3d fine_N = mass.go_on();
      const Felt& felt = run.step(hand.at(tick * kPeriod_s));
      most_N = std::max(most_N, fine_N.norm());
      off_N = std::max(off_N, (felt.force_N - fine_N).norm());
    }
    worst = std::max(worst, off_N / most_N);
  }
  EXPECT_LT(figure("force field with a mass, 5 s of a hand: off the fine integration, of the largest force",
                   worst, "0.01"),
            0.01);
}

TEST(ForceField, AMassWithoutDampingSwingsOnAndOn) {
  // A hand that has moved and stands still: the swing keeps its size for a minute, at sqrt(k / m).
  IdealRun run(scene_of(force_field("cup", R"("mass": {"mass_kg": 0.5, "stiffness_N_m": 200})")));
  run.step(Vector3d::Zero());
  run.move({0.01, 0, 0}, 1e-3);
  const auto swing = [&](double seconds) {
    double most_N = 0, crossings = 0;
    for (int tick = 0; tick < seconds * kRate_Hz; ++tick) {
      const double before_N = run.felt().force_N.x();
      const double now_N = run.step({0.01, 0, 0}).force_N.x();
      crossings += before_N < 0 && now_N >= 0 ? 1 : 0;
      most_N = std::max(most_N, now_N);
    }
    return std::pair(most_N, crossings / seconds);
  };
  const auto [first_N, rate_Hz] = swing(10);
  swing(50);
  const double last_N = swing(10).first;
  EXPECT_NEAR(figure("swing of a mass: Hz", rate_Hz, "sqrt(k / m) / 2 pi = 3.18"),
              std::sqrt(400.0) / (2 * M_PI), 0.1);
  EXPECT_NEAR(figure("swing of a mass: size after a minute, of that at the start", last_N / first_N, "1"),
              1.0, 0.01);
}

TEST(ForceField, ATrialBeginsAndEndsWithinATick) {
  const SceneImage image =
      scene_of(force_field("always", R"("constant_N": [0, 0, 1])") + "," +
               force_field("wind", R"("constant_N": [4, 0, 0], "trial": 1)") + "," +
               force_field("thick", R"("damping_N_s_m": [10, 10, 10], "trial": 2)") + "," +
               force_field("curl", R"("curl_N_s_m": [0, 0, 15], "trial": 2)") + "," +
               force_field("channel", R"("stiffness_N_m": [0, 500, 500], "trial": 3)"));
  IdealRun run(image);
  const double speed_m_s = 0.2;
  const auto go = [&](std::uint8_t trial) {
    run.renderer().set_trial(trial);
    const Vector3d at = run.felt().tip_m;
    return run.step(at + Vector3d(speed_m_s * kPeriod_s, 0, 0)).force_N;
  };
  const auto near = [](const Vector3d& a, const Vector3d& b) { return (a - b).norm() < 0.01; };
  run.step({0, 0.001, 0});
  for (int round = 0; round < 100; ++round) {
    EXPECT_TRUE(near(go(0), {0, 0, 1}));
    EXPECT_TRUE(near(go(1), {4, 0, 1}));
    EXPECT_TRUE(near(go(2), {-2, 3, 1}));
    EXPECT_TRUE(near(go(3), {0, -0.5, 1}));
    EXPECT_TRUE(near(go(1), {4, 0, 1}));
    EXPECT_TRUE(near(go(7), {0, 0, 1}));
    EXPECT_TRUE(near(go(3), {0, -0.5, 1}));
  }
}

TEST(ForceField, NoSequenceOfTrialsGivesMoreThanItsBoundTimesTheStarts) {
  // Springs, dampers and masses in eight trials, switched at random while a hand wanders: what the hand has got is at most what springs hold
  // when they begin. Each is judged by the work of the force on the hand alone.
  Random random(6);
  double most = 0;
  int all_starts = 0;
  for (int round = 0; round < 20; ++round) {
    std::string objects;
    const double damping_N_s_m = round % 2 == 0 ? 0 : 4;  // without it, nothing takes from what a start gives
    for (int trial = 1; trial <= 8; ++trial) {
      const Vector3d stiffness = random.in_box(Vector3d::Constant(800)).cwiseMax(0);
      objects +=
          (trial == 1 ? "" : ",") +
          force_field("field " + std::to_string(trial),
                      R"("stiffness_N_m": )" + text(stiffness) + R"(, "damping_N_s_m": )" +
                          text(random.in_box(Vector3d::Constant(damping_N_s_m)).cwiseAbs()) +
                          R"(, "mass": {"mass_kg": 0.3, "stiffness_N_m": 150}, "trial": )" +
                          std::to_string(trial),
                      R"(, "pose": {"position_m": )" + text(random.in_box(Vector3d::Constant(0.005))) +
                          R"(, "rotation_deg": )" + text(random.in_box(Vector3d::Constant(180))) + "}");
    }
    IdealRun run(scene_of(objects));
    const Wander hand(random, 0.015);
    int starts = 0;
    std::uint8_t trial = 0;
    bool acts = false;
    for (int tick = 0; tick < 20000; ++tick) {
      if (random.uniform(0, 1) < 0.02) {
        const auto next = static_cast<std::uint8_t>(random.uniform(0, 8.999));
        if (next != trial) acts = false;
        trial = next;
        run.renderer().set_trial(trial);
      }
      const Felt& felt = run.step(hand.at(tick * kPeriod_s));
      if (!acts && felt.contacts != 0) {
        acts = true;
        ++starts;
      }
      if (starts > 0) most = std::max(most, run.work_mean_force_J() / (starts * kMostAtStart_J));
    }
    all_starts += starts;
  }
  EXPECT_GT(figure("random trials: starts of fields", all_starts, "400"), 400);
  EXPECT_LT(figure("random trials: most energy that a hand got, of 2 mJ a start", most, "1"), 1.0);
}

TEST(ForceField, ACurlGivesAHandThatCirclesNothing) {
  // In either sense, at 0.3 m/s. Held for a tick each, its force turns with the hand by half a tick too late: 0.1 degrees of 1.1 W.
  for (const double sense : {1.0, -1.0}) {
    IdealRun run(scene_of(force_field("curl", R"("curl_N_s_m": [0, 0, 12])")));
    constexpr double kSeconds = 5, kTurns_Hz = 2;
    double most_N = 0;
    for (int tick = 0; tick < kSeconds * kRate_Hz; ++tick) {
      const double angle = sense * 2 * M_PI * kTurns_Hz * tick * kPeriod_s;
      most_N =
          std::max(most_N, run.step({0.024 * std::cos(angle), 0.024 * std::sin(angle), 0}).force_N.norm());
    }
    EXPECT_GT(most_N, 3.0);
    EXPECT_LT(figure("curl, a hand that circles: power that it gets, W", run.work_mean_force_J() / kSeconds,
                     "0.005"),
              0.005);
  }
}

TEST(ForceField, AnEditedFieldBeginsAnewAndAnotherOneGoesOn) {
  // All are at one place, so nothing but their numbers tells them apart.
  const std::string curl = force_field("curl", R"("curl_N_s_m": [0, 0, 5])");
  const std::string channel = force_field("channel", R"("stiffness_N_m": [0, 1000, 0])");
  const std::string stiffer = force_field("channel", R"("stiffness_N_m": [0, 2000, 0])");
  const SceneImage both = scene_of(curl + "," + channel), alone = scene_of(channel),
                   other = scene_of(curl + "," + stiffer);
  IdealRun far(both);
  far.step({0, 0.04, 0});
  EXPECT_EQ(far.felt().force_N.norm(), 0);
  far.renderer().bind(alone.view(), control::Binding::kKeepPlaces);
  EXPECT_EQ(far.step({0, 0.04, 0}).force_N.norm(), 0);  // not begun, whatever began before it
  IdealRun near(both);
  near.step({0, 0, 0});
  near.move({0, 0.005, 0}, 1e-4);
  near.renderer().bind(alone.view(), control::Binding::kKeepPlaces);
  EXPECT_NEAR(near.step({0, 0.005, 0}).force_N.y(), -5, 1e-3);
  near.renderer().bind(other.view(), control::Binding::kKeepPlaces);
  EXPECT_EQ(near.step({0, 0.005, 0}).force_N.norm(), 0);  // 25 mJ that nobody has given
}

TEST(ForceField, TheSpringsPlaceIsShownInAnyOrder) {
  const std::string wind = force_field("wind", R"("constant_N": [1, 0, 0])");
  const std::string channel = force_field("channel", R"("stiffness_N_m": [0, 1000, 0])");
  for (const std::string& objects : {wind + "," + channel, channel + "," + wind}) {
    IdealRun run(scene_of(objects));
    run.step({0, 0, 0});
    run.move({0.01, 0.004, 0}, 1e-4);
    EXPECT_NEAR((run.felt().god_object_m - Vector3d(0.01, 0, 0)).norm(), 0, 1e-8);
  }
}

// The largest force in the second after a reach, when the hand rests again; infinite: the arm tripped.
double left_after_a_reach_N(double curl_N_s_m, const board::Hand& hand) {
  const SceneImage image =
      scene_of(force_field("curl", R"("curl_N_s_m": [0, 0, )" + std::to_string(curl_N_s_m) + "]"));
  board::SimulationOptions options;
  options.hand = hand;
  double left_N = 0;
  const board::SimulationResult result = board::simulate(
      image.bytes(), {{0, Vector3d::Zero(), 0}, {0.5, {0.03, 0.02, 0}, 0}, {2, {0.03, 0.02, 0}, 0}}, options,
      [&](const board::LogRow& row) {
        if (row.time_s > 1) left_N = std::max(left_N, row.force_N.norm());
      });
  return result.status == board::SimulationStatus::kOk ? left_N : std::numeric_limits<double>::infinity();
}

TEST(ForceField, ACurlComesToRestInTheWholeLoop) {
  // It takes the velocity that is measured, which lags. So it feeds a swing by a part of itself, and what the hand damps is the bound.
  constexpr double kStill_N = 0.3;
  struct Case {
    const char* hand;
    board::Hand numbers;
    double stable_N_s_m;
  };
  for (const Case& each : {Case{"a finger", {}, 12}, Case{"an arm that reaches", {1.0, 300.0, 30.0}, 12}}) {
    double most = 0;
    while (most < 40 && left_after_a_reach_N(most + 1, each.numbers) < kStill_N) ++most;
    EXPECT_GE(figure(std::string("largest curl that comes to rest, ") + each.hand + ", N s/m", most,
                     std::to_string(each.stable_N_s_m)),
              each.stable_N_s_m);
  }
}

}  // namespace
}  // namespace thimble::test
