#include "kinematics/built_in_arms.h"

#include <algorithm>
#include <cstddef>

namespace thimble::kinematics {
namespace {

constexpr std::array<std::string_view, 2> kBuiltInNames{"premium-1.5", "wooden"};
constexpr float kDegree = kPi / 180.0F;

struct Joint {
  float motor_turns_per_turn;     // transmission
  float encoder_counts_per_turn;  // of the motor
  float lower_rad, upper_rad;
  float viscous_N_m_s_rad, coulomb_N_m;
};

// A two-link arm with encoders and three equal motors at the motors' shafts.
struct BuiltIn {
  std::string_view name;
  std::uint8_t counter_bits;
  TwoLinkGeometry links;
  std::array<Joint, 3> joint;
  std::array<float, 3> home_rad;
  float min_elbow_rad, max_elbow_rad;  // bounds of q2 - q3
  float max_joint_speed_rad_s, max_force_N, supply_V, structural_stiffness_N_m;
  MotorModel motor;
  InertiaModel inertia;
};

// PHANToM Premium 1.5: Cavusoglu, Feygin, Tendick 2002, Presence 11(6); limits, friction and transmission as
// identified by mahilab. Bodies of the five-bar linkage: a is the forearm link, c the parallel link, be and
// df are the driven links with their counterweights.
namespace premium {
constexpr float kL1 = .215F, kL2 = .170F, kL3 = .0325F, kL5 = -.0368F, kL6 = .0527F;
constexpr float kMa = .0202F, kMc = .0249F, kMbe = .2359F, kMdf = .1906F;
struct Inertia {
  float xx, yy, zz;
};
constexpr Inertia kA{.4864e-4F, .001843e-4F, .4864e-4F}, kC{.959e-4F, .959e-4F, .0051e-4F},
    kBe{11.09e-4F, 10.06e-4F, .591e-4F}, kDf{7.11e-4F, .629e-4F, 6.246e-4F};
constexpr float kBaseYy = 11.87e-4F;

constexpr InertiaModel inertia() {
  return {
      .m11 = .125F * (4 * kA.yy + 4 * kA.zz + 8 * kBaseYy + 4 * kBe.yy + 4 * kBe.zz + 4 * kC.yy + 4 * kC.zz +
                      4 * kDf.yy + 4 * kDf.zz + 4 * kL1 * kL1 * kMa + kL2 * kL2 * kMa + kL1 * kL1 * kMc +
                      4 * kL3 * kL3 * kMc),
      .m11_cos_2q2 = .125F * (4 * kBe.yy - 4 * kBe.zz + 4 * kC.yy - 4 * kC.zz + kL1 * kL1 * (4 * kMa + kMc)),
      .m11_cos_2q3 =
          .125F * (4 * kA.yy - 4 * kA.zz + 4 * kDf.yy - 4 * kDf.zz - kL2 * kL2 * kMa - 4 * kL3 * kL3 * kMc),
      .m22 = .25F * (4 * (kBe.xx + kC.xx + kL1 * kL1 * kMa) + kL1 * kL1 * kMc),
      .m33 = .25F * (4 * kA.xx + 4 * kDf.xx + kL2 * kL2 * kMa + 4 * kL3 * kL3 * kMc),
      .m23 = .5F * kL1 * (kL2 * kMa + kL3 * kMc),
      .g2 = .5F * kGravity_m_s2 * (2 * kL1 * kMa + 2 * kL5 * kMbe + kL1 * kMc),
      .g3 = .5F * kGravity_m_s2 * (kL2 * kMa + 2 * kL3 * kMc - 2 * kL6 * kMdf),
  };
}

constexpr Joint joint(float turns, float lower_deg, float upper_deg) {
  return {.motor_turns_per_turn = turns,
          .encoder_counts_per_turn = 4096.0F,
          .lower_rad = lower_deg * kDegree,
          .upper_rad = upper_deg * kDegree,
          .viscous_N_m_s_rad = 5.0e-4F,
          .coulomb_N_m = .01F};
}
}  // namespace premium

// WoodenHaptics: geometry, masses, centres of mass, motor constant and limits from haptikfabrikenapi. The
// source has no inertias, joint limits, friction or motor data. Assumptions: each link has the inertia of a
// uniform rod about its published centre of mass; our joint and elbow limits keep the links 30 degrees from
// folded and 25 from straight; friction and the inertia of the turntable (which carries two motors) are
// estimates; the motor is a Maxon RE 30 310007 with the values of its data sheet, whose torque constant is
// the published one.
namespace wooden {
constexpr float kL0 = .080F, kL1 = .205F, kL2 = .245F;
constexpr float kMb = .170F, kMc = .110F, kCmB = .051F, kCmC = .091F;
constexpr float kTurntable_kg_m2 = 2.0e-3F;

constexpr InertiaModel inertia() {
  // Moments of inertia about the joint axes; the elbow carries the mass of the forearm.
  const float upper = kMb * (kCmB * kCmB + kL1 * kL1 / 12) + kMc * kL1 * kL1;
  const float fore = kMc * (kCmC * kCmC + kL2 * kL2 / 12);
  return {
      .m11 = kTurntable_kg_m2 + .5F * (upper + fore),  // upper cos^2 q2 + fore sin^2 q3 + 2 m23 cos q2 sin q3
      .m11_cos_2q2 = .5F * upper,
      .m11_cos_2q3 = -.5F * fore,
      .m22 = upper,
      .m33 = fore,
      .m23 = kMc * kL1 * kCmC,
      .g2 = kGravity_m_s2 * (kMb * kCmB + kMc * kL1),
      .g3 = kGravity_m_s2 * kMc * kCmC,
  };
}

constexpr Joint joint(float body_mm, float lower_deg, float upper_deg) {
  return {.motor_turns_per_turn = body_mm / 10.0F,  // divided by the diameter of the capstan, 10 mm
          .encoder_counts_per_turn = 2000.0F,
          .lower_rad = lower_deg * kDegree,
          .upper_rad = upper_deg * kDegree,
          .viscous_N_m_s_rad = 1.0e-3F,
          .coulomb_N_m = .02F};
}
}  // namespace wooden

constexpr std::array<BuiltIn, 2> kArms{
    BuiltIn{
        .name = "premium-1.5",
        .counter_bits = 16,
        .links = {.base_height_m = 0.0F, .upper_link_m = premium::kL1, .forearm_m = premium::kL2},
        .joint = {premium::joint(13.3F, -90, 90), premium::joint(11.2F, -124, 119),
                  premium::joint(11.2F, -29, 214)},
        .home_rad = {0, 0, 0},
        .min_elbow_rad = -55 * kDegree,
        .max_elbow_rad = 65 * kDegree,
        .max_joint_speed_rad_s = 40.0F,  // 8 m/s at the tip
        .max_force_N = 8.5F,
        .supply_V = 24.0F,
        .structural_stiffness_N_m = 3500.0F,
        // Maxon RE 25 118743. 129 mNm stall torque; 28.6 mNm corresponds to the published continuous tip
        // forces (1.24 A x Kt minus the friction of the motor).
        .motor = {.torque_constant_N_m_A = .0234F,
                  .resistance_ohm = 2.18F,
                  .inductance_H = .238e-3F,
                  .rotor_inertia_kg_m2 = 1.03e-6F,
                  .peak_current_A = 5.51F,
                  .continuous_torque_N_m = .0286F,
                  .winding_to_housing_K_W = 3.1F,
                  .housing_to_ambient_K_W = 14.0F,
                  .winding_time_constant_s = 12.0F,
                  .housing_time_constant_s = 612.0F,
                  .max_winding_C = 100.0F},
        .inertia = premium::inertia(),
    },
    BuiltIn{
        .name = "wooden",
        .counter_bits = 32,
        .links = {.base_height_m = wooden::kL0, .upper_link_m = wooden::kL1, .forearm_m = wooden::kL2},
        .joint = {wooden::joint(160, -60, 60), wooden::joint(120, -30, 130), wooden::joint(120, -30, 110)},
        // The tip is then at the published origin (.22, 0, .08) m; c2 = (l2/l1) c3 puts it at the height of
        // the shoulder.
        .home_rad = {0, 70.304043F * kDegree, 38.021380F * kDegree},
        .min_elbow_rad = -60 * kDegree,
        .max_elbow_rad = 65 * kDegree,
        .max_joint_speed_rad_s = 40.0F,
        .max_force_N = 5.0F,
        .supply_V = 24.0F,
        .structural_stiffness_N_m = 3000.0F,
        .motor = {.torque_constant_N_m_A = .0259F,
                  .resistance_ohm = .611F,
                  .inductance_H = .119e-3F,
                  .rotor_inertia_kg_m2 = 3.33e-6F,
                  .peak_current_A = 3.0F,
                  .continuous_torque_N_m = .0777F,
                  .winding_to_housing_K_W = 1.7F,
                  .housing_to_ambient_K_W = 6.0F,
                  .winding_time_constant_s = 16.3F,
                  .housing_time_constant_s = 714.0F,
                  .max_winding_C = 125.0F},
        .inertia = wooden::inertia(),
    }};

ArmData made(const BuiltIn& arm) noexcept {
  ArmData data;
  std::copy(arm.name.begin(), arm.name.end(), data.name.begin());
  data.geometry.platform = arm.links;
  data.geometry.rotation << 0, 1, 0,  // it points to the user, -y of the world, and its y is the user's right
      -1, 0, 0,                       //
      0, 0, 1;
  constexpr std::array<std::string_view, 3> kNames{"yaw", "upper", "fore"};
  for (std::size_t j = 0; j < arm.joint.size(); ++j) {
    const Joint& joint = arm.joint[j];
    AxisData& axis = data.axis[j];
    std::copy(kNames[j].begin(), kNames[j].end(), axis.name.begin());
    axis.lower = joint.lower_rad;
    axis.upper = joint.upper_rad;
    axis.encoder_port = axis.drive_port = static_cast<std::uint8_t>(j);
    axis.counter_bits = arm.counter_bits;
    axis.counts_per_turn = joint.encoder_counts_per_turn;
    axis.encoder_turns = axis.drive_turns = joint.motor_turns_per_turn;
    axis.motor = arm.motor;
    axis.coulomb_N_m = joint.coulomb_N_m;
    axis.viscous_N_m_s_rad = joint.viscous_N_m_s_rad;
    data.geometry.driven[j] = true;
    data.geometry.home[static_cast<int>(j)] = arm.home_rad[j];
  }
  data.sum_count = 1;
  data.sum[0] = {.weight = {0, 1, -1}, .lower = arm.min_elbow_rad, .upper = arm.max_elbow_rad};
  data.has_inertia = true;
  data.inertia = arm.inertia;
  data.max_force_N = arm.max_force_N;
  data.max_joint_speed_rad_s = arm.max_joint_speed_rad_s;
  data.tip_stiffness_N_m = arm.structural_stiffness_N_m;
  data.supply_V = arm.supply_V;
  return data;
}

}  // namespace

std::span<const std::string_view> built_in_arms() noexcept { return kBuiltInNames; }

bool built_in_arm(std::string_view name, ArmData& arm) noexcept {
  for (const BuiltIn& known : kArms) {
    if (known.name != name) continue;
    arm = made(known);
    return true;
  }
  return false;
}

ArmData built_in_arm(std::string_view name) noexcept {
  ArmData arm = made(kArms[0]);
  static_cast<void>(built_in_arm(name, arm));
  return arm;
}

}  // namespace thimble::kinematics
