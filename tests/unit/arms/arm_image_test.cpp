// The image of an arm: what a board reads from it is what the file says, for every arm that comes with Thimble; and bytes that are cut, flipped or
// exchanged are refused, or give an arm that a tick can live with.
#include "firmware/arm/arm_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_file.h"
#include "host-tools/arms/arm_writer.h"
#include "kinematics/gravity.h"
#include "kinematics/mechanism.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using firmware::ArmStatus;
using firmware::read_arm_image;
using kinematics::ArmData;

const std::array kArms{"premium-1.5", "wooden", "touch", "falcon", "pantograph", "paddle", "chain-7"};

host::ArmFile file_of(const std::string& name) {
  std::ifstream in(std::filesystem::path(THIMBLE_SOURCE_DIR) / "arms" / (name + ".arm.json"));
  return host::read_arm_file({std::istreambuf_iterator<char>(in), {}}, name);
}

// At an address that a board's store has.
struct Bytes {
  alignas(8) std::array<std::byte, firmware::kMaxArmImageBytes> at{};
  std::size_t size = 0;

  explicit Bytes(const std::vector<std::byte>& from) : size(from.size()) {
    std::ranges::copy(from, at.begin());
  }
  [[nodiscard]] std::span<const std::byte> all() const { return std::span(at).first(size); }
};

class ArmImage : public testing::TestWithParam<const char*> {};

TEST_P(ArmImage, ABoardReadsWhatTheFileSays) {
  const host::ArmFile file = file_of(GetParam());
  const Bytes bytes(host::arm_image(file));
  EXPECT_EQ(host::arm_image(file), host::arm_image(file_of(GetParam())));
  EXPECT_LE(bytes.size, 4096U);
  ArmData arm;
  ASSERT_EQ(read_arm_image(bytes.all(), arm), ArmStatus::kOk);
  EXPECT_STREQ(arm.name.data(), GetParam());
  EXPECT_EQ(arm.geometry.platform.index(), file.geometry.platform.index());
  EXPECT_EQ(arm.geometry.home, file.geometry.home);
  EXPECT_EQ(arm.geometry.driven, file.geometry.driven);
  EXPECT_EQ(arm.geometry.body_count, file.geometry.body_count);
  EXPECT_EQ(arm.sum_count, static_cast<int>(file.limit_sums.size()));
  EXPECT_EQ(arm.has_inertia, file.two_link_inertia.has_value());
  EXPECT_EQ(arm.max_force_N, static_cast<float>(file.max_force_N));
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    const host::ArmAxis& axis = file.axes[i];
    const kinematics::AxisData& read = arm.axis.at(i);
    EXPECT_STREQ(read.name.data(), axis.name.c_str());
    EXPECT_EQ(read.lower, static_cast<float>(axis.lower.value));
    EXPECT_EQ(read.upper, static_cast<float>(axis.upper.value));
    EXPECT_EQ(read.counts_per_turn, static_cast<float>(axis.encoder.counts_per_turn.value));
    EXPECT_EQ(read.counter_bits, axis.encoder.counter_bits);
    EXPECT_EQ(read.coulomb_N_m, static_cast<float>(axis.friction.coulomb_N_m.value));
    if (axis.drive) {
      EXPECT_EQ(read.drive_turns, static_cast<float>(axis.drive->turns_per_turn.value));
      EXPECT_EQ(read.motor.peak_current_A, static_cast<float>(axis.motor->peak_current_A.value));
    }
  }
  const ArmData direct = host::arm_data(file);
  EXPECT_EQ(direct.name, arm.name);
  EXPECT_EQ(direct.sum_count, arm.sum_count);
  EXPECT_EQ(direct.sum[0].weight, arm.sum[0].weight);
  EXPECT_EQ(direct.sum[0].upper, arm.sum[0].upper);
  EXPECT_EQ(direct.has_inertia, arm.has_inertia);
  EXPECT_EQ(direct.inertia.m23, arm.inertia.m23);
  EXPECT_EQ(direct.inertia.g3, arm.inertia.g3);
  EXPECT_EQ(direct.tip_stiffness_N_m, arm.tip_stiffness_N_m);
  EXPECT_EQ(direct.supply_V, arm.supply_V);
  for (std::size_t i = 0; i < file.axes.size(); ++i) {
    const kinematics::AxisData &one = direct.axis.at(i), &other = arm.axis.at(i);
    EXPECT_EQ(one.name, other.name);
    EXPECT_EQ(one.lower, other.lower);
    EXPECT_EQ(one.encoder_kind, other.encoder_kind);
    EXPECT_EQ(one.encoder_port, other.encoder_port);
    EXPECT_EQ(one.counter_bits, other.counter_bits);
    EXPECT_EQ(one.encoder_turns, other.encoder_turns);
    EXPECT_EQ(one.encoder_sign, other.encoder_sign);
    EXPECT_EQ(one.drive_kind, other.drive_kind);
    EXPECT_EQ(one.drive_port, other.drive_port);
    EXPECT_EQ(one.drive_sign, other.drive_sign);
    EXPECT_EQ(one.drive_turns, other.drive_turns);
    EXPECT_EQ(one.delay_s, other.delay_s);
    EXPECT_EQ(one.motor.max_winding_C, other.motor.max_winding_C);
    EXPECT_EQ(one.motor.rotor_inertia_kg_m2, other.motor.rotor_inertia_kg_m2);
    EXPECT_EQ(one.viscous_N_m_s_rad, other.viscous_N_m_s_rad);
    EXPECT_EQ(one.stiction_ratio, other.stiction_ratio);
    EXPECT_EQ(one.stiffness_N_m_rad, other.stiffness_N_m_rad);
  }
  // The same tip, Jacobian and weight, to the last bit, over the workspace.
  const kinematics::Mechanism<float> one(file.geometry), other(arm.geometry);
  kinematics::MechanismPose<float> pose = one.home_pose(), same = other.home_pose();
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    kinematics::AxisVector<float> axes = one.home();
    for (int j = 0; j < one.axes(); ++j) axes[j] += static_cast<float>(random.uniform(-0.2, 0.2));
    const bool closes = one.at(axes, pose);
    ASSERT_EQ(other.at(axes, same), closes);
    if (!closes) continue;
    EXPECT_EQ(pose.tip_m, same.tip_m);
    EXPECT_EQ(pose.jacobian, same.jacobian);
    EXPECT_EQ(pose.force_jacobian, same.force_jacobian);
    EXPECT_EQ(kinematics::gravity_torques(one, axes, pose), kinematics::gravity_torques(other, axes, same));
  }
}

INSTANTIATE_TEST_SUITE_P(All, ArmImage, testing::ValuesIn(kArms), [](const auto& one) {
  std::string name(one.param);
  std::erase_if(name, [](char c) { return c == '-' || c == '.'; });
  return name;
});

// What a tick relies on, of any image that was accepted.
void expect_sound(const ArmData& arm) {
  const int axes = kinematics::axes_of(arm.geometry);
  ASSERT_TRUE(axes >= 1 && axes <= kinematics::kMaxJoints);
  const kinematics::Mechanism<float> mechanism(arm.geometry);
  kinematics::MechanismPose<float> pose = mechanism.home_pose();
  ASSERT_TRUE(mechanism.closes_at_home());
  ASSERT_TRUE(pose.tip_m.allFinite() && pose.force_jacobian.allFinite());
  ASSERT_TRUE(kinematics::gravity_torques(mechanism, mechanism.home(), pose).allFinite());
  for (std::size_t i = 0; i < static_cast<std::size_t>(axes); ++i) {
    const kinematics::AxisData& axis = arm.axis.at(i);
    ASSERT_TRUE(axis.lower < axis.upper && axis.counts_per_turn * axis.encoder_turns > 0);
    ASSERT_TRUE(!arm.geometry.driven.at(i) || axis.motor.torque_constant_N_m_A * axis.drive_turns > 0);
  }
}

TEST(ArmBytes, BytesThatNobodyVouchesFor) {
  constexpr int kMutants = 30000;
  Random random(2);
  int accepted = 0;
  std::vector<std::vector<std::byte>> images;
  for (const char* name : kArms) images.push_back(host::arm_image(file_of(name)));
  for (int i = 0; i < kMutants; ++i) {
    Bytes bytes(images.at(static_cast<std::size_t>(i) % images.size()));
    for (std::uint64_t n = 1 + random.below(3); n > 0; --n) {
      const std::size_t place = random.below(bytes.size);
      if (random.below(2) == 0) {
        bytes.at.at(place) ^= static_cast<std::byte>(1U << random.below(8));
      } else {  // a float or an offset as a whole
        const std::size_t at = std::min(place & ~std::size_t{3}, bytes.size - 4);
        const std::array<float, 6> odd{0.0F, -1.0F, 1e30F, HUGE_VALF, NAN, 1e-30F};
        std::memcpy(&bytes.at.at(at), &odd.at(random.below(odd.size())), sizeof(float));
      }
    }
    if (random.below(8) == 0) bytes.size = random.below(bytes.size);
    ArmData arm;
    if (read_arm_image(bytes.all(), arm) != ArmStatus::kOk) continue;
    ++accepted;
    expect_sound(arm);
    if (HasFatalFailure()) return;
  }
  figure("mutants of arm images that are accepted, of 30 000", accepted,
         "> 1000: names, and numbers within their range");
  EXPECT_GT(accepted, 1000);
  EXPECT_LT(accepted, kMutants / 2);
}

TEST(ArmBytes, WhatIsNoImage) {
  Bytes bytes(host::arm_image(file_of("touch")));
  ArmData arm;
  EXPECT_EQ(read_arm_image({}, arm), ArmStatus::kNotAnArm);
  EXPECT_EQ(read_arm_image(bytes.all().subspan(4), arm), ArmStatus::kMisaligned);
  const std::vector<std::byte> large(firmware::kMaxArmImageBytes + 8);
  EXPECT_EQ(read_arm_image(large, arm), ArmStatus::kTooLarge);
  bytes.at.at(4) = std::byte{'S'};  // the identifier of another file
  EXPECT_EQ(read_arm_image(bytes.all(), arm), ArmStatus::kNotAnArm);
  host::ArmFile sensed = file_of("paddle");
  sensed.axes[0].drive.reset();
  EXPECT_EQ(read_arm_image(Bytes(host::arm_image(sensed)).all(), arm), ArmStatus::kNoDrive);
  host::ArmFile open = file_of("pantograph");
  std::get<kinematics::FiveBarGeometry>(open.geometry.platform).outer_m = {0.02F, 0.02F};
  EXPECT_EQ(read_arm_image(Bytes(host::arm_image(open)).all(), arm), ArmStatus::kDoesNotClose);
  host::ArmFile bent = file_of("touch");
  bent.geometry.rotation(0, 0) = 2;
  EXPECT_EQ(read_arm_image(Bytes(host::arm_image(bent)).all(), arm), ArmStatus::kBadNumber);
  host::ArmFile beyond = file_of("touch");
  beyond.geometry.chain.force_joint = 7;
  EXPECT_EQ(read_arm_image(Bytes(host::arm_image(beyond)).all(), arm), ArmStatus::kWrongCount);
}

}  // namespace
}  // namespace thimble::test
