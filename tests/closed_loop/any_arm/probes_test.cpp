// The probes of the encoders on every arm that comes with Thimble, and on a 6R arm of little friction: on an arm of more driven joints than a
// force has directions a joint may stand still while others carry the hand, so a probe must take away what its own motor gives.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/sim_board.h"
#include "firmware/core/encoder_probe.h"
#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"
#include "kinematics/directions.h"
#include "tests/closed_loop/any_arm/arms.h"
#include "tests/support/figure.h"
#include "tests/support/scene.h"

namespace thimble::test {
namespace {

using board::Injection;
using board::SimBoard;
using board::Vector3d;
using firmware::Fault;
using firmware::Mode;

constexpr double kFree_m = 0.002;        // from home to the wall
constexpr double kPlantStep_s = 125e-6;  // more presses are worth more than the plant's last percent

double setting(const char* name, double otherwise) {
  const char* text = std::getenv(name);
  return text != nullptr ? std::strtod(text, nullptr) : otherwise;
}

std::string axis_text(int number, double lower_deg, double home_deg, double upper_deg, int turns) {
  const std::string port = std::to_string(number);
  const std::string turns_text = ", \"turns_per_turn\": " + std::to_string(turns) + "}";
  return R"({"name": "j)" + port + R"(", "lower_deg": )" + std::to_string(lower_deg) + R"(, "upper_deg": )" +
         std::to_string(upper_deg) + R"(, "home_deg": )" + std::to_string(home_deg) +
         R"(, "motor": "m", "friction": {"coulomb_N_m": 0.004, "viscous_N_m_s_rad": 0.0002},
         "encoder": {"port": )" +
         port + R"(, "kind": "quadrature", "counts_per_turn": 2048, "counter_bits": 32)" + turns_text +
         R"(, "drive": {"port": )" + port + R"(, "kind": "analog_current")" + turns_text + "}";
}

// A desktop arm of six joints; its three last ones have short levers.
kinematics::ArmData six_joints() {
  const std::string text = R"({"thimble_arm": 1, "name": "six-r", "source": "a test",
  "kinematics": {"serial": {"joints": [
    {"name": "j0", "origin_m": [0, 0, 0.1], "axis": [0, 0, 1]},
    {"name": "j1", "origin_m": [0, 0, 0.05], "axis": [1, 0, 0]},
    {"name": "j2", "origin_m": [0, 0.2, 0], "axis": [1, 0, 0]},
    {"name": "j3", "origin_m": [0, 0, -0.1], "axis": [0, 0, 1]},
    {"name": "j4", "origin_m": [0, 0, -0.05], "axis": [1, 0, 0]},
    {"name": "j5", "origin_m": [0, 0, -0.03], "axis": [0, 1, 0]}], "tip_m": [0, 0.04, 0]}},
  "motors": {"m": {"torque_constant_N_m_A": 0.04, "resistance_ohm": 4, "inductance_H": 0.0004,
    "rotor_inertia_kg_m2": 1e-06, "peak_current_A": 4, "continuous_torque_N_m": 0.06,
    "winding_to_housing_K_W": 5, "housing_to_ambient_K_W": 14, "winding_time_constant_s": 10,
    "housing_time_constant_s": 600, "max_winding_C": 100}},
  "axes": [)" + axis_text(0, -80, 0, 80, 10) +
                           ", " + axis_text(1, -30, 10, 60, 10) + ", " + axis_text(2, -60, 0, 60, 10) + ", " +
                           axis_text(3, -120, 0, 120, 3) + ", " + axis_text(4, -80, 20, 80, 3) + ", " +
                           axis_text(5, -150, 0, 150, 3) + R"(],
  "limits": {"max_force_N": 3, "max_joint_speed_rad_s": 40, "tip_stiffness_N_m": 2000, "supply_V": 24}})";
  return host::arm_data(host::read_arm_file(text, "six-r"));
}

kinematics::ArmData probed_arm(const std::string& name) {
  return name == "six-r" ? six_joints() : arm_named(name);
}

// A hand that goes straight into a wall, which faces it, and stays there.
struct Press {
  Vector3d into{1, 0, 0};
  double speed_m_s = 6e-3, depth_m = 4e-3;  // of the hand's target
  float stiffness_N_m = 500;
  board::Hand hand{0.05, 500, 5};
  float winding_limit_C = 100;
};

// A joint's of the force at the tip.
struct Share {
  float now_N = 0, probed_N = 0;  // it is probed if it has more than that
};

struct Death {
  std::optional<double> found_s;  // after the joint's last count
  Share stays;                    // at the end
  double travel_m = 0;            // of the tip, from where it was
};

class Pressed {
 public:
  Pressed(const kinematics::ArmData& data, const Press& press) : data_(data), geometry_(data_) {
    board::SimBoardOptions options;
    options.arm = data;
    options.hand = press.hand;
    options.plant_step_s = kPlantStep_s;
    board_.emplace(options);
    home_m_ = board_->arm(0).tip_m();
    SceneBuilder scene;
    scene.plane(-press.into, -press.into.dot(home_m_) - kFree_m,
                {.stiffness_N_m = press.stiffness_N_m, .damping_N_s_m = 1});
    EXPECT_EQ(board_->controller().load_scene(scene.bytes()), firmware::StoreStatus::kOk);
    EXPECT_EQ(board_->controller().write_param(firmware::row_of(firmware::Param::winding_limit).id,
                                               std::bit_cast<std::uint32_t>(press.winding_limit_C)),
              firmware::ParamStatus::kOk);
    run(0.01);
    EXPECT_EQ(board_->controller().request(firmware::Command::kHome), 0U);
    run(0.1);
    EXPECT_EQ(board_->controller().request(firmware::Command::kArm), 0U);
    run(0.3);
    EXPECT_EQ(board_->controller().mode(), Mode::kArmed);
    const double way_m = kFree_m + press.depth_m;
    for (double at_m = 0; at_m < way_m; at_m += press.speed_m_s / board_->options().rate_Hz) {
      board_->hold(0, home_m_ + at_m * press.into, press.speed_m_s * press.into);
      tick();
    }
    board_->hold(0, home_m_ + way_m * press.into);
  }

  void run(double seconds) {
    for (double left_s = seconds; left_s > 0; left_s -= 1 / board_->options().rate_Hz) tick();
  }
  [[nodiscard]] Fault fault() { return board_->controller().fault(); }
  [[nodiscard]] unsigned probes() { return board_->controller().telemetry().probes; }
  [[nodiscard]] const firmware::ArmTelemetry& shown() { return board_->controller().telemetry().arm[0]; }

  // The joints that have so great a share of the force that they are probed.
  [[nodiscard]] std::vector<std::size_t> probed_joints() {
    std::vector<std::size_t> joints;
    for (std::size_t j = 0; j < shown().axes; ++j)
      if (const Share share = share_of(j); share.now_N > share.probed_N) joints.push_back(j);
    return joints;
  }

  // The joint's encoder dies; then for a second, or until the fault.
  [[nodiscard]] Death kill(std::size_t joint) {
    const Vector3d tip_m = board_->arm(0).tip_m();
    board_->inject({.kind = Injection::kEncoderDead, .joint = joint});
    Death death;
    std::uint32_t counts = shown().counts[joint];
    double last_count_s = board_->time_s();
    for (const double end_s = last_count_s + 1; board_->time_s() < end_s && fault() == Fault::kNone;) {
      tick();
      death.travel_m = std::max(death.travel_m, (board_->arm(0).tip_m() - tip_m).norm());
      if (std::exchange(counts, shown().counts[joint]) != counts) last_count_s = board_->time_s();
    }
    if (fault() != Fault::kNone) death.found_s = board_->time_s() - last_count_s;
    death.stays = share_of(joint);
    return death;
  }

 private:
  void tick() {
    board_->controller().keep_alive();
    board_->tick();
  }
  [[nodiscard]] Share share_of(std::size_t joint) {
    constexpr float kNoLever_m = 1e-6F;
    kinematics::Posture<float> posture = geometry_.home_posture();
    geometry_.move_to(shown().joint_rad, posture);
    const Eigen::Vector3f arc_m = geometry_.driven_jacobian(posture).col(static_cast<int>(joint));
    const float lever_m = std::max(arc_m.norm(), kNoLever_m);
    const kinematics::AxisData& axis = data_.axis[joint];
    const firmware::SureChange sure(firmware::EncoderProbe::kCounts, axis.coulomb_N_m,
                                    std::abs(axis.rad_per_count()), firmware::EncoderProbe::kFirmHand_N_m);
    return {std::abs(arc_m.dot(shown().force_N)) / lever_m, sure.torque_N_m(lever_m * lever_m) / lever_m};
  }

  kinematics::ArmData data_;
  kinematics::Arm<float> geometry_;
  std::optional<SimBoard> board_;
  Vector3d home_m_;
};

// Directions in which the arm can push at home, and how many.
std::pair<Eigen::Matrix3d, int> ways(const kinematics::ArmData& data) {
  const kinematics::Arm<float> arm(data);
  const auto jacobian = arm.driven_jacobian(arm.home_posture());
  return {kinematics::directions_of(jacobian).along.cast<double>(),
          kinematics::ForceFade(jacobian).force_dof()};
}

Press random_press(std::mt19937_64& random, const kinematics::ArmData& data, bool quick) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(random);
  };
  Press press;
  const auto [along, count] = ways(data);
  press.into.setZero();
  for (int i = 0; i < count; ++i) press.into += std::normal_distribution(0.0, 1.0)(random) * along.col(i);
  press.into.normalize();
  press.speed_m_s = quick ? between(0.02, 0.1) : between(6e-3, 0.012);
  press.stiffness_N_m = static_cast<float>(std::exp(between(std::log(200), std::log(1000))));
  press.hand.stiffness_N_m = std::exp(between(std::log(200), std::log(2000)));
  const double most_N = 0.8 * std::min(8.0, static_cast<double>(data.max_force_N));
  const double force_N = std::exp(between(std::log(0.4 * most_N), std::log(most_N)));
  press.depth_m = std::min(
      0.015, force_N * (1 / static_cast<double>(press.stiffness_N_m) + 1 / press.hand.stiffness_N_m));
  return press;
}

std::string described(const Press& press) {
  char text[200];
  std::snprintf(text, sizeof text, "into %.3f %.3f %.3f, %.1f mm/s, %.1f mm, wall %.0f N/m, hand %.0f N/m",
                press.into.x(), press.into.y(), press.into.z(), press.speed_m_s * 1e3, press.depth_m * 1e3,
                static_cast<double>(press.stiffness_N_m), press.hand.stiffness_N_m);
  return text;
}

class ProbesOf : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { random_.seed(static_cast<std::uint64_t>(setting("THIMBLE_PROBES_SEED", 1))); }
  void show(const char* what, double value, const char* limit) const {
    figure(std::string(GetParam()) + ": " + what, value, limit);
  }
  kinematics::ArmData data_ = probed_arm(GetParam());
  std::mt19937_64 random_;
};

// Quickly: the torque of a joint that stays where it is changes by so much that it is probed. Slowly: it is probed when all stand still.
// A third of the arms have motors so hot that they give a part of the force.
TEST_P(ProbesOf, APressedWallIsNoFault) {
  const int trials = static_cast<int>(setting("THIMBLE_PROBES", 3));
  unsigned probes = 0;
  double worst_rad = 0;
  for (int i = 0; i < trials; ++i) {
    Press press = random_press(random_, data_, i % 2 == 0);
    if (i % 3 == 2) press.winding_limit_C = 31;
    Pressed pressed(data_, press);
    const auto before_rad = pressed.shown().joint_rad;
    pressed.run(1);
    EXPECT_EQ(pressed.fault(), Fault::kNone)
        << described(press) << ": fault " << static_cast<int>(pressed.fault());
    probes += pressed.probes();
    const float moved_rad = (pressed.shown().joint_rad - before_rad).cwiseAbs().maxCoeff();
    worst_rad = std::max(worst_rad, static_cast<double>(moved_rad));
  }
  show("probes in each press", 1.0 * probes / trials, "reported");
  show("the most that a joint goes in a second of rest in the wall, rad", worst_rad, "reported");
}

// The probe of a dead joint lets the arm give way, and the encoders of the other joints may show that as a way out of the wall: then the
// force is gone before the fault is proved.
TEST_P(ProbesOf, ADeadEncoderIsFoundOrLosesItsForce) {
  const int trials = static_cast<int>(setting("THIMBLE_PROBES", 3));
  int dead = 0, found = 0;
  double latest_s = 0, worst_mm = 0;
  float stays_N = 0;
  for (int i = 0; i < 4 * trials && dead < trials; ++i) {
    Pressed pressed(data_, random_press(random_, data_, true));
    pressed.run(0.3 + 0.2 * std::uniform_real_distribution()(random_));
    ASSERT_EQ(pressed.fault(), Fault::kNone);
    const std::vector<std::size_t> joints = pressed.probed_joints();
    if (joints.empty()) continue;
    ++dead;
    const Death death = pressed.kill(joints[random_() % joints.size()]);
    worst_mm = std::max(worst_mm, 1e3 * death.travel_m);
    if (death.found_s) {
      EXPECT_EQ(pressed.fault(), Fault::encoder_frozen);
      ++found;
      latest_s = std::max(latest_s, *death.found_s);
    } else {
      stays_N = std::max(stays_N, death.stays.now_N);
      EXPECT_LE(death.stays.now_N, death.stays.probed_N);
    }
  }
  show("dead encoders of joints that are probed", dead, "reported");
  if (dead == 0) return;
  show("of them found, %", 100.0 * found / dead, "reported");
  show("the latest after its last count, s", latest_s, "<= 0.5");
  show("the greatest share that stays with one that was not found, N", static_cast<double>(stays_N),
       "less than is probed");
  show("travel of the tip, mm", worst_mm, "<= 20");
  EXPECT_LE(latest_s, 0.5);
  EXPECT_LE(worst_mm, 20);
}

INSTANTIATE_TEST_SUITE_P(Files, ProbesOf,
                         testing::Values("premium-1.5", "wooden", "touch", "falcon", "pantograph", "paddle",
                                         "chain-7", "six-r"),
                         test_name);

}  // namespace
}  // namespace thimble::test
