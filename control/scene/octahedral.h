// Unit vectors in 32 bits: how a scene image holds its corner normals. The compiler encodes, the controller
// decodes in the tick.
//
// The unit sphere is projected onto the octahedron |x| + |y| + |z| = 1; the lower half (z < 0) is folded
// outwards over the upper one's square (Meyer et al. 2010, "On floating-point normal vectors"). Low 16 bits:
// x, high 16 bits: y, each an int16 / 32767. Angular error < 0.005 degree. No heap, no failure: any 32 bits
// decode to a unit vector.
#pragma once

#include <cmath>
#include <cstdint>

#include "kinematics/vector.h"

namespace thimble::control {

inline constexpr float kOctahedralSteps = 32767.0F;

// `unit` is a unit vector (its length cancels; it must not be zero).
[[nodiscard]] inline std::uint32_t encode_octahedral(const Vec3& unit) noexcept {
  const float sum = std::abs(unit.x()) + std::abs(unit.y()) + std::abs(unit.z());
  float x = unit.x() / sum;
  float y = unit.y() / sum;
  if (unit.z() < 0.0F) {
    const float folded_x = std::copysign(1.0F - std::abs(y), x);
    y = std::copysign(1.0F - std::abs(x), y);
    x = folded_x;
  }
  const auto snorm = [](float value) {
    const auto steps = static_cast<std::int16_t>(std::lround(value * kOctahedralSteps));
    return static_cast<std::uint32_t>(static_cast<std::uint16_t>(steps));
  };
  return snorm(x) | (snorm(y) << 16U);
}

[[nodiscard]] inline Vec3 decode_octahedral(std::uint32_t bits) noexcept {
  const auto snorm = [](std::uint32_t half) {
    return static_cast<float>(static_cast<std::int16_t>(static_cast<std::uint16_t>(half))) *
           (1.0F / kOctahedralSteps);
  };
  float x = snorm(bits & 0xFFFFU);
  float y = snorm(bits >> 16U);
  const float z = 1.0F - std::abs(x) - std::abs(y);
  const float fold = z < 0.0F ? -z : 0.0F;
  x += x < 0.0F ? fold : -fold;
  y += y < 0.0F ? fold : -fold;
  // The octahedron's points are at least 1/sqrt(3) from the centre: no division by zero.
  return Vec3(x, y, z) * (1.0F / std::sqrt(x * x + y * y + z * z));
}

}  // namespace thimble::control
