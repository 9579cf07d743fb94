#include "firmware/arm/arm_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <new>
#include <span>

#include "kinematics/mechanism.h"
#include "thimble_arm_schema/arm_generated.h"

namespace thimble::firmware {
namespace {

using namespace kinematics;  // NOLINT(google-build-using-namespace): this file turns the one's types into the other's
using Eigen::Matrix3f;
using Eigen::Vector3f;

constexpr float kMostLength_m = 10.0F, kMostAngle = 13.0F, kMostNumber = 1e9F, kMostWeight = 10.0F;
constexpr float kMostMass_kg = 100.0F;

bool within(float value, float least, float most) noexcept { return value >= least && value <= most; }
bool is_positive(float value) noexcept { return value > 0 && value <= kMostNumber; }
bool is_not_negative(float value) noexcept { return within(value, 0, kMostNumber); }
bool is_length(float value) noexcept { return value > 0 && value <= kMostLength_m; }
bool is_place(float value) noexcept { return within(value, -kMostLength_m, kMostLength_m); }

// The numbers of an image into those of an arm. Each returns whether it is good.
bool read(const arm::Vec3& from, Vector3f& to) noexcept {
  to = {from.x(), from.y(), from.z()};
  return is_place(to.x()) && is_place(to.y()) && is_place(to.z());
}

bool read(const arm::Mat3& from, Matrix3f& to) noexcept {
  for (int i = 0; i < 9; ++i) to(i / 3, i % 3) = from.row()->Get(static_cast<flatbuffers::uoffset_t>(i));
  constexpr float kRounding = 1e-5F;
  return (to * to.transpose() - Matrix3f::Identity()).cwiseAbs().maxCoeff() < kRounding &&
         to.determinant() > 0;
}

template <std::size_t kBytes>
bool read(const flatbuffers::String& from, std::array<char, kBytes>& to) noexcept {
  if (from.size() == 0 || from.size() >= kBytes) return false;
  to.fill('\0');
  std::copy_n(from.c_str(), from.size(), to.begin());
  const std::span name(to.data(), from.size());
  return std::ranges::find(name, '\0') == name.end();
}

bool read(const arm::TwoLink& from, ArmData& to) noexcept {
  const TwoLinkGeometry links{from.base_height_m(), from.upper_link_m(), from.forearm_m()};
  to.geometry.platform = links;
  if (!is_place(links.base_height_m) || !is_length(links.upper_link_m) || !is_length(links.forearm_m))
    return false;
  const auto* inertia = from.inertia();
  if (inertia == nullptr) return true;
  if (inertia->size() != 8) return false;
  for (const float number : *inertia)
    if (!within(number, -kMostNumber, kMostNumber)) return false;
  to.has_inertia = true;
  to.inertia = {inertia->Get(0), inertia->Get(1), inertia->Get(2), inertia->Get(3),
                inertia->Get(4), inertia->Get(5), inertia->Get(6), inertia->Get(7)};
  return true;
}

bool read(const arm::FiveBar& from, ArmData& to) noexcept {
  const FiveBarGeometry bars{from.base_distance_m(),
                             {from.inner_m()->Get(0), from.inner_m()->Get(1)},
                             {from.outer_m()->Get(0), from.outer_m()->Get(1)},
                             from.up()};
  to.geometry.platform = bars;
  return is_place(bars.base_distance_m) && is_length(bars.inner_m[0]) && is_length(bars.inner_m[1]) &&
         is_length(bars.outer_m[0]) && is_length(bars.outer_m[1]);
}

bool read(const arm::Delta& from, ArmData& to) noexcept {
  const DeltaGeometry delta{
      from.thigh_m(),
      from.shin_m(),
      from.plate_u_m(),
      from.plate_v_m(),
      from.shin_end_m(),
      from.knee_end_m(),
      from.base_u_m(),
      from.base_v_m(),
      {from.leg_angle_rad()->Get(0), from.leg_angle_rad()->Get(1), from.leg_angle_rad()->Get(2)},
      from.minus(),
      from.home_axis_m()};
  to.geometry.platform = delta;
  return is_length(delta.thigh_m) && is_length(delta.shin_m) && is_place(delta.plate_u_m) &&
         is_place(delta.plate_v_m) && is_place(delta.shin_end_m) && is_place(delta.knee_end_m) &&
         is_place(delta.base_u_m) && is_place(delta.base_v_m) && is_place(delta.home_axis_m) &&
         std::all_of(delta.leg_angle_rad.begin(), delta.leg_angle_rad.end(),
                     [](float angle) { return within(angle, -kMostAngle, kMostAngle); });
}

ArmStatus read_chain(const arm::Arm& from, ArmData& to) noexcept {
  ChainGeometry& chain = to.geometry.chain;
  const auto* joints = from.chain();
  const int most = kMaxJoints - platform_joints(to.geometry);
  chain.count = joints == nullptr ? 0 : static_cast<int>(joints->size());
  if (chain.count > most || from.force_joint() > chain.count) return ArmStatus::kWrongCount;
  chain.force_joint = from.force_joint();
  for (int k = 0; k < chain.count; ++k) {
    const arm::Joint& joint = *joints->Get(static_cast<flatbuffers::uoffset_t>(k));
    ChainJoint& known = chain.joint[static_cast<std::size_t>(k)];
    known.kind = joint.prismatic() ? JointKind::kPrismatic : JointKind::kRevolute;
    if (!read(joint.origin_m(), known.origin_m) || !read(joint.rotation(), known.rotation) ||
        !read(joint.axis(), known.axis) || !within(known.axis.norm(), 0.9999F, 1.0001F))
      return ArmStatus::kBadNumber;
  }
  if (from.tip_m() != nullptr && !read(*from.tip_m(), chain.tip_m)) return ArmStatus::kBadNumber;
  return axes_of(to.geometry) > 0 ? ArmStatus::kOk : ArmStatus::kWrongCount;
}

ArmStatus read_coupling(const arm::Arm& from, ArmData& to) noexcept {
  const auto axes = static_cast<flatbuffers::uoffset_t>(axes_of(to.geometry));
  if (from.joints_per_axis()->size() != axes * axes || from.joint_offset()->size() != axes)
    return ArmStatus::kWrongCount;
  for (flatbuffers::uoffset_t i = 0; i < axes; ++i) {
    to.geometry.joint_offset[static_cast<int>(i)] = from.joint_offset()->Get(i);
    if (!within(from.joint_offset()->Get(i), -kMostAngle, kMostAngle)) return ArmStatus::kBadNumber;
    for (flatbuffers::uoffset_t j = 0; j < axes; ++j) {
      const float number = from.joints_per_axis()->Get(i * axes + j);
      if (!within(number, -kMostWeight, kMostWeight)) return ArmStatus::kBadNumber;
      to.geometry.joints_per_axis(static_cast<int>(i), static_cast<int>(j)) = number;
    }
  }
  return ArmStatus::kOk;
}

bool read(const arm::Motor& from, MotorModel& to) noexcept {
  to = {.torque_constant_N_m_A = from.torque_constant_n_m_per_a(),
        .resistance_ohm = from.resistance_ohm(),
        .inductance_H = from.inductance_h(),
        .rotor_inertia_kg_m2 = from.rotor_inertia_kg_m2(),
        .peak_current_A = from.peak_current_a(),
        .continuous_torque_N_m = from.continuous_torque_n_m(),
        .winding_to_housing_K_W = from.winding_to_housing_k_per_w(),
        .housing_to_ambient_K_W = from.housing_to_ambient_k_per_w(),
        .winding_time_constant_s = from.winding_time_constant_s(),
        .housing_time_constant_s = from.housing_time_constant_s(),
        .max_winding_C = from.max_winding_c()};
  return is_positive(to.torque_constant_N_m_A) && is_positive(to.resistance_ohm) &&
         is_positive(to.inductance_H) && is_positive(to.rotor_inertia_kg_m2) &&
         is_positive(to.peak_current_A) && is_positive(to.continuous_torque_N_m) &&
         is_positive(to.winding_to_housing_K_W) && is_positive(to.housing_to_ambient_K_W) &&
         is_positive(to.winding_time_constant_s) && is_positive(to.housing_time_constant_s) &&
         is_positive(to.max_winding_C);
}

bool is_sign(std::int8_t sign) noexcept { return sign == 1 || sign == -1; }

bool read_encoder(const arm::Encoder& from, AxisData& to) noexcept {
  to.encoder_kind = static_cast<EncoderKind>(from.kind());
  to.encoder_port = from.port();
  to.counter_bits = from.counter_bits();
  to.encoder_sign = static_cast<float>(from.sign());
  to.counts_per_turn = from.counts_per_turn();
  to.encoder_turns = from.turns_per_turn();
  to.max_rate_Hz = from.max_rate_hz();
  return from.kind() <= arm::EncoderKind::MAX && to.counter_bits >= 8 && to.counter_bits <= 32 &&
         is_sign(from.sign()) && is_positive(to.counts_per_turn) && is_positive(to.encoder_turns) &&
         is_not_negative(to.max_rate_Hz);
}

bool read_drive(const arm::Drive& from, AxisData& to) noexcept {
  to.drive_kind = static_cast<DriveKind>(from.kind());
  to.drive_port = from.port();
  to.drive_sign = static_cast<float>(from.sign());
  to.drive_turns = from.turns_per_turn();
  to.delay_s = from.delay_s();
  return from.kind() <= arm::DriveKind::MAX && is_sign(from.sign()) && is_positive(to.drive_turns) &&
         within(to.delay_s, 0, 1);
}

bool read_axis(const arm::Axis& from, AxisData& to, float& home, bool& driven) noexcept {
  to.lower = from.lower();
  to.upper = from.upper();
  home = from.home();
  to.coulomb_N_m = from.coulomb_n_m();
  to.viscous_N_m_s_rad = from.viscous_n_m_s_per_rad();
  to.stiction_ratio = from.stiction_ratio();
  to.stiffness_N_m_rad = from.stiffness_n_m_per_rad();
  to.first_resonance_Hz = from.first_resonance_hz();
  driven = from.drive() != nullptr;
  return read(*from.name(), to.name) && within(to.lower, -kMostAngle, home) &&
         within(to.upper, home, kMostAngle) && to.lower < to.upper && is_not_negative(to.coulomb_N_m) &&
         is_not_negative(to.viscous_N_m_s_rad) && within(to.stiction_ratio, 1, kMostNumber) &&
         is_not_negative(to.stiffness_N_m_rad) && is_not_negative(to.first_resonance_Hz) &&
         read_encoder(*from.encoder(), to) && driven == (from.motor() != nullptr) &&
         (!driven || (read_drive(*from.drive(), to) && read(*from.motor(), to.motor)));
}

ArmStatus read_axes(const arm::Arm& from, ArmData& to) noexcept {
  const auto axes = static_cast<flatbuffers::uoffset_t>(axes_of(to.geometry));
  if (from.axes()->size() != axes) return ArmStatus::kWrongCount;
  bool any = false;
  for (flatbuffers::uoffset_t i = 0; i < axes; ++i) {
    if (!read_axis(*from.axes()->Get(i), to.axis[i], to.geometry.home[static_cast<int>(i)],
                   to.geometry.driven[i]))
      return ArmStatus::kBadNumber;
    const int joint = static_cast<int>(i) - platform_joints(to.geometry);
    to.axis[i].prismatic =
        joint >= 0 && to.geometry.chain.joint[static_cast<std::size_t>(joint)].kind == JointKind::kPrismatic;
    any = any || to.geometry.driven[i];
  }
  return any ? ArmStatus::kOk : ArmStatus::kNoDrive;
}

ArmStatus read_sums(const arm::Arm& from, ArmData& to) noexcept {
  if (from.limit_sums() == nullptr) return ArmStatus::kOk;
  if (from.limit_sums()->size() > kMaxLimitSums) return ArmStatus::kWrongCount;
  for (const arm::LimitSum* given : *from.limit_sums()) {
    LimitSum& sum = to.sum[static_cast<std::size_t>(to.sum_count++)];
    if (given->weights()->size() != static_cast<flatbuffers::uoffset_t>(axes_of(to.geometry)))
      return ArmStatus::kWrongCount;
    float home = 0;
    for (flatbuffers::uoffset_t i = 0; i < given->weights()->size(); ++i) {
      sum.weight[i] = given->weights()->Get(i);
      if (!within(sum.weight[i], -kMostWeight, kMostWeight)) return ArmStatus::kBadNumber;
      home += sum.weight[i] * to.geometry.home[static_cast<int>(i)];
    }
    sum.lower = given->lower();
    sum.upper = given->upper();
    if (!(sum.lower <= home && sum.upper >= home)) return ArmStatus::kBadNumber;
  }
  return ArmStatus::kOk;
}

// The joints that bodies of each link may name, of this family.
int joints_with(BodyLink link, const Geometry& geometry) noexcept {
  const bool bars = std::holds_alternative<FiveBarGeometry>(geometry.platform);
  const bool delta = std::holds_alternative<DeltaGeometry>(geometry.platform);
  switch (link) {
    case BodyLink::kChain:
      return geometry.chain.count;
    case BodyLink::kPlate:
    case BodyLink::kThighs:
      return delta ? 1 : 0;
    case BodyLink::kInner:
    case BodyLink::kOuter:
      return bars ? 2 : 0;
  }
  return 0;
}

ArmStatus read_bodies(const arm::Arm& from, ArmData& to) noexcept {
  if (from.bodies() == nullptr) return ArmStatus::kOk;
  if (from.bodies()->size() > kMaxBodies) return ArmStatus::kWrongCount;
  for (const arm::Body* given : *from.bodies()) {
    Body& body = to.geometry.body[static_cast<std::size_t>(to.geometry.body_count++)];
    if (given->link() > arm::BodyLink::MAX) return ArmStatus::kBadNumber;
    body.link = static_cast<BodyLink>(given->link());
    body.joint = given->joint();
    body.mass_kg = given->mass_kg();
    if (body.joint >= joints_with(body.link, to.geometry)) return ArmStatus::kWrongCount;
    if (!read(given->centre_m(), body.centre_m) || !within(body.mass_kg, 0, kMostMass_kg))
      return ArmStatus::kBadNumber;
  }
  return ArmStatus::kOk;
}

bool read_platform(const arm::Arm& from, ArmData& to) noexcept {
  switch (from.platform_type()) {
    case arm::Platform::NONE:
      return true;
    case arm::Platform::TwoLink:
      return read(*from.platform_as_TwoLink(), to);
    case arm::Platform::FiveBar:
      return read(*from.platform_as_FiveBar(), to);
    case arm::Platform::Delta:
      return read(*from.platform_as_Delta(), to);
  }
  return false;
}

ArmStatus read(const arm::Arm& from, ArmData& to) noexcept {
  to.max_force_N = from.max_force_n();
  to.max_joint_speed_rad_s = from.max_joint_speed_rad_per_s();
  to.tip_stiffness_N_m = from.tip_stiffness_n_per_m();
  to.supply_V = from.supply_v();
  to.commissioned = from.commissioned();
  if (!read(*from.name(), to.name) || !read(*from.rotation(), to.geometry.rotation) ||
      !read_platform(from, to) || !is_positive(to.max_force_N) || !is_positive(to.max_joint_speed_rad_s) ||
      !is_positive(to.tip_stiffness_N_m) || !is_positive(to.supply_V))
    return ArmStatus::kBadNumber;
  ArmStatus status = read_chain(from, to);
  if (status == ArmStatus::kOk) status = read_coupling(from, to);
  if (status == ArmStatus::kOk) status = read_axes(from, to);
  if (status == ArmStatus::kOk) status = read_sums(from, to);
  if (status == ArmStatus::kOk) status = read_bodies(from, to);
  if (status != ArmStatus::kOk) return status;
  const Mechanism<float> mechanism(to.geometry);
  const MechanismPose<float> pose = mechanism.home_pose();
  return mechanism.closes_at_home() && pose.jacobian.allFinite() ? ArmStatus::kOk : ArmStatus::kDoesNotClose;
}

}  // namespace

const char* name(ArmStatus status) noexcept {
  switch (status) {
    case ArmStatus::kOk:
      return "ok";
    case ArmStatus::kTooLarge:
      return "too_large";
    case ArmStatus::kMisaligned:
      return "misaligned";
    case ArmStatus::kNotAnArm:
      return "not_an_arm";
    case ArmStatus::kWrongCount:
      return "wrong_count";
    case ArmStatus::kBadNumber:
      return "bad_number";
    case ArmStatus::kNoDrive:
      return "no_drive";
    case ArmStatus::kDoesNotClose:
      return "does_not_close";
  }
  return "unknown";
}

ArmStatus read_arm_image(std::span<const std::byte> bytes, kinematics::ArmData& arm) noexcept {
  if (bytes.size() > kMaxArmImageBytes) return ArmStatus::kTooLarge;
  if (std::bit_cast<std::uintptr_t>(bytes.data()) % 8 != 0) return ArmStatus::kMisaligned;
  const auto* data = reinterpret_cast<const std::uint8_t*>(bytes.data());
  constexpr std::size_t kDepth = 3, kTables = 2 + kinematics::kMaxJoints + kinematics::kMaxLimitSums;
  flatbuffers::Verifier verifier(data, bytes.size(), kDepth, kTables);
  if (bytes.size() < 2 * sizeof(std::uint32_t) || !thimble::arm::VerifyArmBuffer(verifier))
    return ArmStatus::kNotAnArm;
  new (&arm) kinematics::ArmData();  // in place: a second one on the stack would be 2.4 kB
  return read(*thimble::arm::GetArm(data), arm);
}

}  // namespace thimble::firmware
