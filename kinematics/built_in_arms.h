// The arms that every board knows: it works with the one that its configuration names until an arm is uploaded. The files arms/premium-1.5.arm.json and
// arms/wooden.arm.json say the same (tests/unit/arms).
//
// Both have a yaw axis, an upper link and a forearm, both driven from the base (kinematics/two_link.h). At q = 0 the upper link is horizontal and
// the forearm points down. This pose reproduces the published resolutions, forces and apparent masses (tests/unit/kinematics prints them).
#pragma once

#include <span>
#include <string_view>

#include "kinematics/arm_data.h"

namespace thimble::kinematics {

[[nodiscard]] std::span<const std::string_view> built_in_arms() noexcept;  // their names

// False, and `arm` unchanged, for a name that is none.
[[nodiscard]] bool built_in_arm(std::string_view name, ArmData& arm) noexcept;
// For a name that is known to be one; the first of them for another.
[[nodiscard]] ArmData built_in_arm(std::string_view name) noexcept;

}  // namespace thimble::kinematics
