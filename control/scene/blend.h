// Triplanar blending: a texture is laid on a curved surface along the three axes of the object, and each place of the
// surface takes a mean of the three. The weights depend on the normal alone and have continuous slopes, so the height
// and its gradient go on over the whole surface. Where the normal is within 26 degrees of an axis, that axis has all.
//
//   along x: (u, v) = (y, z)      along y: (x, z)      along z: (x, y)
//
// Used by the tick for spheres, capsules and cones, and by the compiler for the corners of meshes.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "kinematics/vector.h"

namespace thimble::control {

struct Blend {
  Vec3 weight = Vec3::UnitZ();                                          // of each axis; their sum is 1
  std::array<Vec3, 3> slope{Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};  // gradient of each weight, 1/m
};

// The code of a mesh's corner whose faces have axes of their own (Mesh.texture_weights in control/scene/scene.fbs).
inline constexpr std::uint32_t kOwnAxes = 0xFFFFFFFFU;

// The square of the cosine of the angle to the normal at which an axis begins to count: 63 degrees.
inline constexpr double kBlendFrom = 0.2;

// Not normalised. direction: along the normal, of any length but zero. Scalar is float in the tick.
template <typename Scalar>
Eigen::Matrix<Scalar, 3, 1> blend_shares(const Eigen::Matrix<Scalar, 3, 1>& direction) noexcept {
  const Scalar from = static_cast<Scalar>(kBlendFrom) * direction.squaredNorm();
  return (direction.cwiseAbs2().array() - from).max(Scalar{0}).matrix();
}

// direction: a function of the place whose component i changes by slope[i] per metre along axis i, and with no other.
inline Blend blend_along(const Vec3& direction, const Vec3& slope) noexcept {
  const Vec3 share = blend_shares<float>(direction);
  const float sum = share.squaredNorm();  // at least (1/3 - 0.2)^2 of the direction's length to the fourth
  Blend blend;
  if (!(sum > 0.0F)) return blend;
  blend.weight = share.cwiseAbs2() / sum;
  const Vec3 each = 2.0F * direction.cwiseProduct(slope);
  const Vec3 common = static_cast<float>(kBlendFrom) * each;
  // share_i' = each_i - common; the sum's gradient is 2 sum share_i share_i'.
  const Vec3 of_sum = 2.0F * (share.cwiseProduct(each) - share.sum() * common);
  for (int i = 0; i < 3; ++i) {
    Vec3 own = -common;
    own[i] += each[i];
    blend.slope[static_cast<std::size_t>(i)] = (2.0F * share[i] * own - blend.weight[i] * of_sum) / sum;
  }
  return blend;
}

}  // namespace thimble::control
