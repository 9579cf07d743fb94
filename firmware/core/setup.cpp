#include "firmware/core/setup.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <string_view>

#include "firmware/core/encoder_probe.h"
#include "firmware/core/stop_timeout.h"

namespace thimble::firmware {
namespace {

constexpr float kMinPeriod_s = 40e-6F;
constexpr float kMaxPeriod_s = 20e-3F;

std::span<const kinematics::ArmModel> models(const Config& config) noexcept {
  return config.arm_models.empty() ? kinematics::arm_models() : config.arm_models;
}

const kinematics::ArmModel* find_model(const Config& config, std::string_view name) noexcept {
  for (const kinematics::ArmModel& model : models(config))
    if (model.name == name) return &model;
  return nullptr;
}

// Of a Config that cannot work some model: its arms are never used.
kinematics::Arm<float> arm_of(const Config& config, std::size_t index) noexcept {
  const kinematics::ArmModel* model = find_model(config, config.arm[index].model);
  return kinematics::Arm<float>(model != nullptr ? *model : models(config).front(), config.arm[index].base);
}

bool works(const Config& config) noexcept {
  if (config.arm_count < 1 || config.arm_count > kMaxArms) return false;
  if (!(config.period_s >= kMinPeriod_s && config.period_s <= kMaxPeriod_s)) return false;
  if (config.work_units < kLeastWork * config.arm_count) return false;
  if (config.node_id < 1 || config.node_id > 127) return false;
  return std::all_of(config.arm.begin(), config.arm.begin() + config.arm_count,
                     [&](const ArmConfig& arm) { return find_model(config, arm.model) != nullptr; });
}

std::array<JointConstants, kJoints> constants_of(const kinematics::ArmModel& model) noexcept {
  std::array<JointConstants, kJoints> joints;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const int axis = static_cast<int>(j);
    const float coulomb_N_m = model.joint[j].coulomb_N_m;
    const float count_rad = std::abs(model.rad_per_count(axis));
    joints[j] = {std::abs(model.torque_per_ampere(axis)) * model.motor.peak_current_A, count_rad,
                 SureChange(EncoderProbe::kCounts, coulomb_N_m, count_rad, EncoderProbe::kFirmHand_N_m),
                 SureChange(kMoveCounts, coulomb_N_m, count_rad, model.structural_stiffness_N_m)};
  }
  return joints;
}

std::uint32_t most_stale(float period_s) noexcept {
  constexpr float kLongest_s = static_cast<float>(kLongestStop_us) * 1e-6F, kRounding = 1.0001F;
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(kRounding * kLongest_s / period_s), 2) - 1;
}

}  // namespace

Setup::Setup(const Config& config) noexcept
    : period_s(works(config) ? config.period_s : kMaxPeriod_s),
      work_units(config.work_units),
      arm_count(works(config) ? config.arm_count : std::uint8_t{0}),
      most_stale_ticks(most_stale(period_s)),
      board_lacks(config.lacks != nullptr && *config.lacks != '\0'),
      arm{arm_of(config, 0), arm_of(config, 1)},
      joint{constants_of(arm[0].model()), constants_of(arm[1].model())},
      has_index{config.arm[0].has_index, config.arm[1].has_index},
      has_line_loss{config.arm[0].has_line_loss, config.arm[1].has_line_loss} {}

}  // namespace thimble::firmware
