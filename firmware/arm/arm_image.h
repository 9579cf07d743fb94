// Reads an arm image (arm.fbs): bytes that nobody vouches for become the numbers of an arm, or are refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "kinematics/arm_data.h"

namespace thimble::firmware {

inline constexpr std::size_t kMaxArmImageBytes = 8192;

// Why an image was refused. The numbers travel over the link: append only.
enum class ArmStatus : std::uint8_t {
  kOk = 0,
  kTooLarge = 1,     // larger than kMaxArmImageBytes
  kMisaligned = 2,   // the bytes do not start at a multiple of 8
  kNotAnArm = 3,     // the FlatBuffers verifier or the file identifier refused it
  kWrongCount = 4,   // of joints, axes, weights, bodies, sums, or of the numbers of a matrix
  kBadNumber = 5,    // not finite, or out of its range
  kNoDrive = 6,      // no axis is driven
  kDoesNotClose = 7  // the links do not meet at home
};

[[nodiscard]] const char* name(ArmStatus status) noexcept;  // "does_not_close"

// Sets `arm` where the image is good; otherwise its contents are of no use. O(bytes). Never reads outside `bytes`, whatever they contain. Judges what a tick
// needs to be safe; whether the arm is a good one is check_arm()'s matter (host-tools/arms/arm_checks.h).
[[nodiscard]] ArmStatus read_arm_image(std::span<const std::byte> bytes, kinematics::ArmData& arm) noexcept;

}  // namespace thimble::firmware
