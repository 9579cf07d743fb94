// The constants of the tick: the Config, checked once, with the arm models that it names.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/core/config.h"
#include "firmware/core/encoder_place.h"
#include "firmware/core/force_limits.h"
#include "firmware/params.h"
#include "kinematics/arm.h"
#include "kinematics/force_fade.h"

namespace thimble::firmware {

inline constexpr float kMoveCounts = 6.0F;  // that a joint may be late in a move by itself

struct JointConstants {
  float peak_N_m = 0;       // at the motor's peak current
  float count_rad = 0;      // of the encoder, unsigned
  SureChange against_hand;  // of EncoderProbe
  SureChange in_move;       // of an arm that moves by itself
};

struct Setup {
  explicit Setup(const Config& config) noexcept;
  Setup(const Setup&) = delete;  // `arm` points into `built_in`
  Setup& operator=(const Setup&) = delete;
  ~Setup() = default;

  float period_s;
  std::uint32_t work_units;
  std::uint8_t arm_count;  // 0: the Config cannot work, and the controller stays faulted with bad_config
  std::uint32_t most_stale_ticks;  // one period more than that is at most 5 ms; at least 1
  std::uint32_t pulse_ticks;       // of the event line (marks.h)
  bool board_lacks;                // Config::lacks is not empty
  std::array<kinematics::ArmData, kMaxArms> built_in;  // of arms that Config::arms_known does not bring
  std::array<kinematics::Arm<float>, kMaxArms> arm;
  std::array<std::size_t, kMaxArms> axes;  // of each arm
  std::array<kinematics::ForceFade, kMaxArms>
      fade;  // of arms that are not a two-link: that one is not near a singularity within its limits
  std::array<std::array<JointConstants, kJoints>, kMaxArms> joint;
  std::array<bool, kMaxArms> has_index;
  std::array<bool, kMaxArms> has_line_loss;
  float
      uncommissioned_N;  // the most force that the files of arms give which have not passed a commissioning; 0: all have, or are built in
};

// An arm that has not passed a commissioning would give more than it may.
[[nodiscard]] inline bool too_strong(const Setup& setup, const Params& params, float max_force_N) noexcept {
  return setup.uncommissioned_N > kUncommissioned_N && max_force_N > kUncommissioned_N &&
         !params.on(Param::allow_uncommissioned);
}

}  // namespace thimble::firmware
