#include "host-tools/sweep/wall_press.h"

#include <fmt/format.h>

#include <stdexcept>

#include "host-tools/compiler/compile.h"

namespace thimble::host {
namespace {

constexpr double kFloor_m = -.01;

double tip_stiffness_N_m(const WallPress& press) {
  if (press.arm_data) return static_cast<double>(press.arm_data->tip_stiffness_N_m);
  const board::PlantVariant* const variant = board::find_plant_variant(press.arm);
  if (variant == nullptr) throw std::runtime_error("there is no simulated arm named " + press.arm);
  return static_cast<double>(board::PlantParameters::from(*variant).model.tip_stiffness_N_m);
}

}  // namespace

MeasuredRun run_of(const WallPress& press) {
  // At rest the wall, the arm's structure and the hand are three springs in a row.
  const double target_m = kFloor_m - press.force_N / press.stiffness_N_m -
                          press.force_N / tip_stiffness_N_m(press) - press.force_N / press.hand.stiffness_N_m;
  const double travel_s = -target_m / press.approach_m_s;
  MeasuredRun run;
  run.image =
      compile_scene_text(
          fmt::format(
              R"({{"thimble_scene": 1, "name": "wall", "objects": [{{"name": "wall", "shape": {{"plane": {{"normal": [0, 0, 1],
        "offset_m": {}}}}}, "material": {{"stiffness_N_m": {}, "damping_N_s_m": {}}}}}]}})",
              kFloor_m, press.stiffness_N_m, press.damping_N_s_m),
          "the wall", {})
          .image;
  run.path = {{0, {0, 0, 0}}, {travel_s, {0, 0, target_m}}, {travel_s + press.hold_s, {0, 0, target_m}}};
  run.options.arm = press.arm;
  run.options.arm_data = press.arm_data;
  run.options.rate_Hz = press.rate_Hz;
  run.options.seed = press.seed;
  run.options.hand = press.hand;
  run.options.sensors.line_loss = true;
  run.steady_from_s = travel_s + press.hold_s / 2;
  run.along = Eigen::Vector3d::UnitZ();
  return run;
}

Measured measure(const WallPress& press) {
  Measured measured = measure(run_of(press));
  if (!measured.is_ok() && measured.status != board::SimulationStatus::kFaulted)
    throw std::runtime_error(measured.detail);
  return measured;
}

}  // namespace thimble::host
