#include "firmware/core/setup.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "firmware/arm/arm_image.h"
#include "firmware/core/encoder_probe.h"
#include "firmware/core/marks.h"
#include "firmware/core/stop_timeout.h"
#include "kinematics/built_in_arms.h"

namespace thimble::firmware {
namespace {

constexpr float kMinPeriod_s = 40e-6F;
constexpr float kMaxPeriod_s = 20e-3F;

// Null: Config::arms_known has no arm of that name.
const kinematics::ArmData* brought(const Config& config, const ArmConfig& wanted) noexcept {
  if (!wanted.image.empty()) return nullptr;
  const std::string_view name = wanted.model;
  for (const kinematics::ArmData& arm : config.arms_known)
    if (kinematics::name_of(arm) == name) return &arm;
  return nullptr;
}

bool is_known(const Config& config, const ArmConfig& wanted) noexcept {
  if (!wanted.image.empty()) return true;
  const std::string_view name = wanted.model;
  const auto names = kinematics::built_in_arms();
  return brought(config, wanted) != nullptr || std::find(names.begin(), names.end(), name) != names.end();
}

// Of an arm that is stored, or built in.
kinematics::ArmData data_of(const ArmConfig& wanted) noexcept {
  kinematics::ArmData data = kinematics::built_in_arm(wanted.model);
  if (!wanted.image.empty())
    static_cast<void>(read_arm_image(wanted.image, data));  // the store has checked it
  return data;
}

// Of a Config that cannot work some arm: it is never used.
kinematics::Arm<float> arm_of(const Config& config, std::size_t index,
                              const kinematics::ArmData& built_in) noexcept {
  const kinematics::ArmData* data = brought(config, config.arm[index]);
  return kinematics::Arm<float>(data != nullptr ? *data : built_in, config.arm[index].base);
}

kinematics::ForceFade fade_of(const kinematics::Arm<float>& arm) noexcept {
  return kinematics::ForceFade(arm.driven_jacobian(arm.home_posture()));
}

bool works(const Config& config) noexcept {
  if (config.arm_count < 1 || config.arm_count > kMaxArms) return false;
  if (!(config.period_s >= kMinPeriod_s && config.period_s <= kMaxPeriod_s)) return false;
  if (config.work_units < kLeastWork * config.arm_count) return false;
  if (config.node_id < 1 || config.node_id > 127) return false;
  return std::all_of(config.arm.begin(), config.arm.begin() + config.arm_count,
                     [&](const ArmConfig& arm) { return is_known(config, arm); });
}

std::array<JointConstants, kJoints> constants_of(const kinematics::ArmData& arm) noexcept {
  std::array<JointConstants, kJoints> joints;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const kinematics::AxisData& axis = arm.axis[j];
    const float count_rad = std::abs(axis.rad_per_count());
    joints[j] = {std::abs(axis.torque_per_ampere()) * axis.motor.peak_current_A, count_rad,
                 SureChange(EncoderProbe::kCounts, axis.coulomb_N_m, count_rad, EncoderProbe::kFirmHand_N_m),
                 SureChange(kMoveCounts, axis.coulomb_N_m, count_rad, arm.tip_stiffness_N_m)};
  }
  return joints;
}

// Arms of Config::arms_known are what the board knows of itself.
float uncommissioned(const Config& config, std::span<const kinematics::ArmData> arms) noexcept {
  float most_N = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(config.arm_count, kMaxArms); ++i)
    if (!config.arm[i].image.empty() && !arms[i].commissioned) most_N = std::max(most_N, arms[i].max_force_N);
  return most_N;
}

constexpr float kRounding = 1.0001F;

std::uint32_t most_stale(float period_s) noexcept {
  constexpr float kLongest_s = static_cast<float>(kLongestStop_us) * 1e-6F;
  return std::max<std::uint32_t>(static_cast<std::uint32_t>(kRounding * kLongest_s / period_s), 2) - 1;
}

// So many that the pulse is not shorter than it has to be.
std::uint32_t event_pulse(float period_s) noexcept {
  return static_cast<std::uint32_t>(kEventPulse_s / kRounding / period_s) + 1;
}

}  // namespace

Setup::Setup(const Config& config) noexcept
    : period_s(works(config) ? config.period_s : kMaxPeriod_s),
      work_units(config.work_units),
      arm_count(works(config) ? config.arm_count : std::uint8_t{0}),
      most_stale_ticks(most_stale(period_s)),
      pulse_ticks(event_pulse(period_s)),
      board_lacks(config.lacks != nullptr && *config.lacks != '\0'),
      built_in{data_of(config.arm[0]), data_of(config.arm[1])},
      arm{arm_of(config, 0, built_in[0]), arm_of(config, 1, built_in[1])},
      axes{static_cast<std::size_t>(arm[0].axes()), static_cast<std::size_t>(arm[1].axes())},
      fade{fade_of(arm[0]), fade_of(arm[1])},
      joint{constants_of(arm[0].data()), constants_of(arm[1].data())},
      has_index{config.arm[0].has_index, config.arm[1].has_index},
      has_line_loss{config.arm[0].has_line_loss, config.arm[1].has_line_loss},
      uncommissioned_N(uncommissioned(config, built_in)) {}

}  // namespace thimble::firmware
