// The geometry of an arm as numbers: what kinematics/mechanism.h computes with. An arm file (docs/arm-format.md) is where they come from.
//
// An arm is a platform (a mechanism whose actuators are at the base: nothing, a two-link parallelogram, a planar five-bar or a rotary delta)
// and a serial chain that continues from it. Either may be empty. The joints are numbered from the base: first those of the platform.
//
// An axis is what an encoder counts, and what a motor may drive. The joints follow the axes by one constant matrix, q = C a + q0: a
// parallelogram, a differential, a cable that runs over another joint. Angles in rad, lengths in m; a prismatic joint has metres where others
// have rad. Source of the formulas: each family's own file.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <variant>

namespace thimble::kinematics {

inline constexpr int kMaxJoints = 7;
inline constexpr float kGravity_m_s2 = 9.81F;

// One number an axis; what is beyond the axes of an arm is 0. Of fixed size, so that the tick copies no counts.
template <typename S>
using PerAxis = Eigen::Matrix<S, kMaxJoints, 1>;
// As many rows or columns as the arm has axes, no heap.
template <typename S>
using AxisVector = Eigen::Matrix<S, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;
template <typename S>
using AxisMatrix = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;
template <typename S>
using Jacobian3 = Eigen::Matrix<S, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxJoints>;
template <typename S>
using Jacobian6 = Eigen::Matrix<S, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxJoints>;

// Yaw, upper link and forearm, both links driven from the base: joints 2 and 3 are absolute angles in the vertical plane
// (kinematics/two_link.h).
struct TwoLinkGeometry {
  float base_height_m, upper_link_m, forearm_m;
};

// Base joints at (0, 0) and (base_distance_m, 0), inner links from there, outer links that meet at the tip, all in the plane z = 0. `up`: the
// tip is on the left of the way from the end of the first inner link to that of the second one (kinematics/five_bar.h).
struct FiveBarGeometry {
  float base_distance_m;
  std::array<float, 2> inner_m, outer_m;
  bool up;
};

// Three legs at angles about z (kinematics/delta.h has the constraint that these lengths are in).
struct DeltaGeometry {
  float thigh_m, shin_m;         // a, b
  float plate_u_m, plate_v_m;    // c, f
  float shin_end_m, knee_end_m;  // d, e
  float base_u_m, base_v_m;      // r, s
  std::array<float, 3> leg_angle_rad;
  bool minus;         // the branch of the inverse; the forward map stays on that on which it begins
  float home_axis_m;  // height of the plate with all axes at home, at which the forward map begins to look
};

enum class JointKind : std::uint8_t { kRevolute, kPrismatic };

// A joint of a chain, as URDF has it: its frame in that of the link before, at 0, and its axis there.
struct ChainJoint {
  JointKind kind = JointKind::kRevolute;
  Eigen::Vector3f origin_m = Eigen::Vector3f::Zero();
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();
  Eigen::Vector3f axis = Eigen::Vector3f::UnitZ();  // of length 1, in the joint's frame
};

struct ChainGeometry {
  int count = 0;
  std::array<ChainJoint, kMaxJoints> joint{};
  Eigen::Vector3f tip_m = Eigen::Vector3f::Zero();  // in the frame of the last link
  // The force acts at the tip if this is `count`, otherwise at the origin of that joint: the gimbal of an arm whose wrist is only sensed.
  int force_joint = 0;
};

// A body whose weight the arm carries, by the link that it is fixed to; its centre of mass is in the frame of that link. The plate of a
// delta does not turn; its thighs are alike, with x along them. A link of a five-bar has x along it, the outer ones from their elbow.
enum class BodyLink : std::uint8_t { kChain, kPlate, kThighs, kInner, kOuter };
struct Body {
  BodyLink link = BodyLink::kChain;
  int joint = 0;  // of the chain, or of the five-bar; the others need none
  float mass_kg = 0;
  Eigen::Vector3f centre_m = Eigen::Vector3f::Zero();
};
inline constexpr int kMaxBodies = 2 * kMaxJoints;

struct Geometry {
  std::variant<std::monostate, TwoLinkGeometry, FiveBarGeometry, DeltaGeometry> platform;
  ChainGeometry chain;
  // Of the base frame in the world, with BasePose as it is without a mounting.
  Eigen::Matrix3f rotation = Eigen::Matrix3f::Identity();
  Eigen::Matrix<float, kMaxJoints, kMaxJoints> joints_per_axis =
      Eigen::Matrix<float, kMaxJoints, kMaxJoints>::Identity();
  Eigen::Matrix<float, kMaxJoints, 1> joint_offset = Eigen::Matrix<float, kMaxJoints, 1>::Zero();
  Eigen::Matrix<float, kMaxJoints, 1> home = Eigen::Matrix<float, kMaxJoints, 1>::Zero();  // of the axes
  std::array<bool, kMaxJoints> driven{};  // axes with a motor
  int body_count = 0;
  std::array<Body, kMaxBodies> body{};
};

[[nodiscard]] constexpr int platform_joints(const Geometry& geometry) noexcept {
  constexpr std::array<int, 4> kJointsOf{0, 3, 2, 3};
  return kJointsOf[geometry.platform.index()];
}
[[nodiscard]] constexpr int axes_of(const Geometry& geometry) noexcept {
  return platform_joints(geometry) + geometry.chain.count;
}

}  // namespace thimble::kinematics
