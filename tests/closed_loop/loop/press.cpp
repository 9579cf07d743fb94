#include "tests/closed_loop/loop/press.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "board/sim/simulation.h"
#include "kinematics/built_in_arms.h"
#include "tests/support/scene.h"

namespace thimble::test {

PressResult press(const Press& press) {
  constexpr double kFloor_m = -.01;
  SceneBuilder scene;
  scene.plane({0, 0, 1}, kFloor_m,
              {.stiffness_N_m = press.stiffness_N_m, .damping_N_s_m = press.damping_N_s_m});
  // At rest the wall, the arm's structure and the hand are three springs in a row.
  const kinematics::ArmData model =
      press.arm_data ? *press.arm_data : kinematics::built_in_arm(board::find_plant_variant(press.arm)->arm);
  const double target_m = kFloor_m - press.force_N / static_cast<double>(press.stiffness_N_m) -
                          press.force_N / static_cast<double>(model.tip_stiffness_N_m) -
                          press.force_N / press.hand.stiffness_N_m;
  const double travel_s = -target_m / press.approach_m_s;
  const std::vector<board::PathPoint> path{
      {0, {0, 0, 0}}, {travel_s, {0, 0, target_m}}, {travel_s + press.hold_s, {0, 0, target_m}}};

  board::SimulationOptions options;
  options.arm = press.arm;
  options.arm_data = press.arm_data;
  options.rate_Hz = press.rate_Hz;
  options.hand = press.hand;
  options.sensors.line_loss = true;  // no probes of encoders at rest: they would be taken for a limit cycle
  const double from_s = travel_s + press.hold_s / 2;
  double sum_N = 0, low_N = 1e9, high_N = -1e9, low_m = 1e9, high_m = -1e9, speed2 = 0,
         last_m = std::numeric_limits<double>::quiet_NaN();
  int ticks = 0;
  const board::SimulationResult result =
      board::simulate(scene.bytes(), path, options, [&](const board::LogRow& row) {
        if (row.time_s < from_s) return;
        const double force = row.force_N.z(), height = row.tip_m.z();
        sum_N += force;
        low_N = std::min(low_N, force);
        high_N = std::max(high_N, force);
        low_m = std::min(low_m, height);
        high_m = std::max(high_m, height);
        if (!std::isnan(last_m)) speed2 += std::pow((height - last_m) * press.rate_Hz, 2);
        last_m = height;
        ++ticks;
      });
  if (result.status == board::SimulationStatus::kFaulted) return {.faulted = true};
  if (result.status != board::SimulationStatus::kOk) throw std::runtime_error(result.detail);
  return {.faulted = false,
          .mean_force_N = sum_N / ticks,
          .force_swing_N = high_N - low_N,
          .tip_swing_m = high_m - low_m,
          .tip_speed_rms_m_s = std::sqrt(speed2 / (ticks - 1))};
}

}  // namespace thimble::test
