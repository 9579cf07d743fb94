// Arm files: those that come with Thimble are read and can work, their figures are the published ones, the two that are compiled in are the
// same arms, and what a file has wrong is named.
#include "host-tools/arms/arm_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "firmware/arm/arm_image.h"
#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_writer.h"
#include "kinematics/built_in_arms.h"
#include "kinematics/mechanism.h"
#include "kinematics/two_link_arm.h"

namespace thimble::test {
namespace {

using Json = nlohmann::json;
using host::ArmFile;
using testing::HasSubstr;
namespace fs = std::filesystem;

fs::path arms_folder() { return fs::path(THIMBLE_SOURCE_DIR) / "arms"; }

std::string text_of(const std::string& name) {
  std::ifstream in(arms_folder() / (name + ".arm.json"));
  return {std::istreambuf_iterator<char>(in), {}};
}
ArmFile arm_of(const std::string& name) { return host::read_arm_file(text_of(name), name); }
host::ArmFigures figures_of(const std::string& name) { return host::check_arm(arm_of(name), name); }

TEST(ArmFiles, EveryOneCanWork) {
  int files = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(arms_folder())) {
    const std::string file = entry.path().filename().string();
    if (!file.ends_with(".arm.json")) continue;
    const std::string name = file.substr(0, file.size() - std::string(".arm.json").size());
    ++files;
    EXPECT_EQ(arm_of(name).name, name);
    const host::ArmFigures figures = figures_of(name);
    EXPECT_THAT(figures.warnings, testing::IsEmpty()) << name;
  }
  EXPECT_GE(files, 7);
}

struct Dof {
  const char* name;
  int force, pose;
};
class ArmFileDof : public testing::TestWithParam<Dof> {};
TEST_P(ArmFileDof, ForcesAndPositionsAreThoseOfTheMachine) {
  const host::ArmFigures figures = figures_of(GetParam().name);
  EXPECT_EQ(figures.force_dof, GetParam().force);
  EXPECT_EQ(figures.pose_dof, GetParam().pose);
}
INSTANTIATE_TEST_SUITE_P(All, ArmFileDof,
                         testing::Values(Dof{"premium-1.5", 3, 3}, Dof{"wooden", 3, 3}, Dof{"touch", 3, 6},
                                         Dof{"falcon", 3, 3}, Dof{"pantograph", 2, 2}, Dof{"paddle", 1, 1},
                                         Dof{"chain-7", 3, 6}),
                         [](const auto& one) {
                           std::string name(one.param.name);
                           std::erase_if(name, [](char c) { return c == '-' || c == '.'; });
                           return name;
                         });

// Published: a nominal resolution of 30 um. The weakest direction is where the upper link's motor alone has to hold the force.
TEST(ArmFiles, ThePremiumHasItsPublishedFigures) {
  const host::ArmFigures figures = figures_of("premium-1.5");
  EXPECT_NEAR(figures.axes[0].count_m, 25e-6, 2e-6);
  EXPECT_NEAR(figures.axes[1].count_m, 30e-6, 2e-6);
  const double motor_N_m = 0.0234 * 5.51, turns = 11.2, link_m = 0.215;
  EXPECT_NEAR(figures.least_peak_force_N, motor_N_m * turns / link_m, 1e-3);
}

// Published poses of the gimbal, in the frame of the URDF: q = 0, and q = (0.3, 0.5, 0.4, 0, 0, 0).
TEST(ArmFiles, TheTouchIsWhereItsUrdfHasIt) {
  const ArmFile touch = arm_of("touch");
  kinematics::Geometry geometry = touch.geometry;
  geometry.rotation.setIdentity();
  geometry.home.setZero();
  const kinematics::Mechanism<double> arm(geometry);
  kinematics::MechanismPose<double> pose = arm.home_pose();
  const Eigen::Vector3d home_m(0, 0.08514, 0.03105), moved_m(-0.05000, 0.16164, 0.10146);
  // The world's origin is where the tip is at home, and the gimbal is not there.
  const Eigen::Vector3d origin_m = home_m - pose.force_point_m;
  kinematics::AxisVector<double> axes = kinematics::AxisVector<double>::Zero(6);
  axes.head<3>() << 0.3, 0.5, 0.4;
  ASSERT_TRUE(arm.at(axes, pose));
  EXPECT_LT((pose.force_point_m + origin_m - moved_m).norm(), 2e-5);
}

// To the bit in all that a force depends on, so a recording has the same forces with either.
TEST(ArmFiles, TheArmsThatAreBuiltInAreTheSame) {
  for (const std::string_view name : kinematics::built_in_arms()) {
    const ArmFile file = arm_of(std::string(name));
    const kinematics::ArmData arm = kinematics::built_in_arm(name);
    std::vector<std::byte> image = host::arm_image(file);
    kinematics::ArmData read;
    ASSERT_EQ(firmware::read_arm_image(image, read), firmware::ArmStatus::kOk);
    const auto& links = std::get<kinematics::TwoLinkGeometry>(arm.geometry.platform);
    const auto& links_read = std::get<kinematics::TwoLinkGeometry>(read.geometry.platform);
    EXPECT_EQ(links_read.base_height_m, links.base_height_m);
    EXPECT_EQ(links_read.upper_link_m, links.upper_link_m);
    EXPECT_EQ(links_read.forearm_m, links.forearm_m);
    EXPECT_EQ(read.geometry.rotation, arm.geometry.rotation);
    EXPECT_EQ(read.geometry.home, arm.geometry.home);
    EXPECT_EQ(read.geometry.driven, arm.geometry.driven);
    EXPECT_TRUE(kinematics::is_two_link(read.geometry));
    for (std::size_t j = 0; j < 3; ++j) {
      const kinematics::AxisData &given = arm.axis[j], &axis = read.axis[j];
      EXPECT_EQ(axis.name, given.name);
      EXPECT_EQ(axis.rad_per_count(), given.rad_per_count()) << name << j;
      EXPECT_EQ(axis.torque_per_ampere(), given.torque_per_ampere());
      EXPECT_EQ(axis.reflected_rotor_inertia(), given.reflected_rotor_inertia());
      EXPECT_FLOAT_EQ(axis.lower, given.lower);
      EXPECT_FLOAT_EQ(axis.upper, given.upper);
      EXPECT_EQ(axis.coulomb_N_m, given.coulomb_N_m);
      EXPECT_EQ(axis.viscous_N_m_s_rad, given.viscous_N_m_s_rad);
      EXPECT_EQ(axis.counter_bits, given.counter_bits);
      EXPECT_EQ(axis.motor.peak_current_A, given.motor.peak_current_A);
      EXPECT_EQ(axis.motor.housing_time_constant_s, given.motor.housing_time_constant_s);
    }
    ASSERT_EQ(read.sum_count, 1);
    EXPECT_EQ(read.sum[0].weight, arm.sum[0].weight);
    EXPECT_FLOAT_EQ(read.sum[0].lower, arm.sum[0].lower);
    EXPECT_FLOAT_EQ(read.sum[0].upper, arm.sum[0].upper);
    ASSERT_TRUE(read.has_inertia);
    EXPECT_EQ(read.inertia.m11, arm.inertia.m11);
    EXPECT_EQ(read.inertia.m23, arm.inertia.m23);
    EXPECT_EQ(read.inertia.g2, arm.inertia.g2);
    EXPECT_EQ(read.inertia.g3, arm.inertia.g3);
    EXPECT_EQ(read.max_force_N, arm.max_force_N);
    EXPECT_EQ(read.tip_stiffness_N_m, arm.tip_stiffness_N_m);
    EXPECT_EQ(read.supply_V, arm.supply_V);

    // And the general kinematics has their tip where the tick has it, over the workspace.
    const kinematics::TwoLinkArm<double> closed(arm);
    const kinematics::Mechanism<double> mechanism(file.geometry);
    kinematics::MechanismPose<double> pose = mechanism.home_pose();
    for (int i = 0; i < 1000; ++i) {
      const Eigen::Vector3d q = Eigen::Vector3d::Random();
      ASSERT_TRUE(mechanism.at(kinematics::AxisVector<double>(q), pose));
      const auto posture = closed.at(q);
      EXPECT_LT((pose.tip_m - posture.tip_m).norm(), 1e-7);  // the rotation of the file is in float
      EXPECT_LT((pose.force_jacobian - posture.jacobian).norm(), 1e-7);
    }
  }
}

// A parallelogram is a serial chain with a coupling: the relative elbow is the difference of the two absolute angles.
TEST(ArmFiles, AParallelogramIsAChainWithACoupling) {
  const ArmFile premium = arm_of("premium-1.5");
  const ArmFile chain =
      host::read_arm_file(R"({"thimble_arm": 1, "name": "chain", "source": "the premium's",
"rotation_deg": [0, 0, -90],
"kinematics": {"serial": {"joints": [{"name": "yaw", "axis": [0, 0, 1]}, {"name": "upper", "axis": [0, -1, 0]},
  {"name": "fore", "origin_m": [0.215, 0, 0], "axis": [0, -1, 0]}], "tip_m": [0, 0, -0.17]}},
"coupling": {"joints_per_axis": [[1, 0, 0], [0, 1, 0], [0, -1, 1]]},)" +
                              text_of("premium-1.5").substr(text_of("premium-1.5").find("\"motors\"")),
                          "chain");
  const kinematics::Mechanism<double> one(premium.geometry), other(chain.geometry);
  kinematics::MechanismPose<double> pose = one.home_pose(), same = other.home_pose();
  double worst = 0;
  for (int i = 0; i < 100000; ++i) {
    const kinematics::AxisVector<double> axes = 2 * Eigen::Vector3d::Random();
    ASSERT_TRUE(one.at(axes, pose) && other.at(axes, same));
    const Eigen::Vector3d force_N = Eigen::Vector3d::Random();
    worst = std::max({worst, (pose.tip_m - same.tip_m).norm(),
                      (one.torques(pose, force_N) - other.torques(same, force_N)).norm()});
  }
  EXPECT_LT(worst, 1e-6);
}

// An axis has the unit of the joint with its number, so a coupling may not change one unit for the other.
TEST(ArmFiles, ACouplingAndASumOfLimitsHaveOneUnit) {
  Json arm = Json::parse(text_of("paddle"));
  Json turn = arm["axes"][0], slide = turn;
  turn["name"] = "turn";
  slide["encoder"]["port"] = slide["drive"]["port"] = 1;
  slide.erase("lower_deg");
  slide.erase("upper_deg");
  slide["lower_m"] = -0.1;
  slide["upper_m"] = 0.1;
  arm["axes"] = {turn, slide};
  arm["kinematics"]["serial"]["joints"].push_back({{"name", "slide"}, {"type", "prismatic"}});
  const auto name_of_error = [](const Json& file) -> std::string {
    try {
      static_cast<void>(host::check_arm(host::read_arm_file(file.dump(), "my"), "my"));
    } catch (const host::Error& error) {
      return error.name;
    }
    return "none";
  };
  EXPECT_EQ(name_of_error(arm), "none");
  Json coupled = arm;
  coupled["coupling"]["joints_per_axis"] = {{-1, 0}, {0, 0.5}};
  EXPECT_EQ(name_of_error(coupled), "none");
  coupled["coupling"]["joints_per_axis"] = {{0, 1}, {1, 0}};
  EXPECT_EQ(name_of_error(coupled), "mixed-units");
  Json summed = arm;
  summed["limit_sums"] = Json::array({{{"weights", {1, 0}}, {"lower_deg", -5}, {"upper_deg", 5}}});
  EXPECT_EQ(name_of_error(summed), "none");
  summed["limit_sums"][0]["weights"] = {1, 1};
  EXPECT_EQ(name_of_error(summed), "mixed-units");
}

// In line at home, where one force is lost altogether: that is a singular home, and not an arm with fewer forces.
TEST(ArmFiles, ALostDirectionAtHomeIsSingular) {
  Json arm = Json::parse(text_of("premium-1.5"));
  arm.erase("limit_sums");
  arm["axes"][1]["home_deg"] = 60;
  for (const double bend_deg : {0.0, 0.01, 0.5, 20.0}) {
    arm["axes"][2]["home_deg"] = 150 - bend_deg;
    const ArmFile file = host::read_arm_file(arm.dump(), "my");
    if (bend_deg > 10) {
      EXPECT_EQ(host::check_arm(file, "my").force_dof, 3);
      continue;
    }
    try {
      static_cast<void>(host::check_arm(file, "my"));
      ADD_FAILURE() << bend_deg;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, "singular-home");
    }
  }
  // A wrist with its first and last axis in line tells three angles nevertheless.
  Json touch = Json::parse(text_of("touch"));
  touch["kinematics"]["serial"]["joints"][4].erase("rotation_deg");
  touch["axes"][4]["home_deg"] = 0;
  EXPECT_EQ(host::check_arm(host::read_arm_file(touch.dump(), "my"), "my").pose_dof, 6);
}

struct Wrong {
  const char* arm;
  const char* pointer;
  Json value;  // null: the key is taken away
  const char* slug;
  const char* cause;
};
class WrongArm : public testing::TestWithParam<Wrong> {};

TEST_P(WrongArm, IsNamed) {
  const Wrong& wrong = GetParam();
  Json arm = Json::parse(text_of(wrong.arm));
  const Json::json_pointer pointer(wrong.pointer);
  if (wrong.value.is_null()) {
    Json& parent = arm.at(pointer.parent_pointer());
    parent.is_array() ? parent.erase(std::stoul(pointer.back()))
                      : static_cast<void>(parent.erase(pointer.back()));
  } else {
    arm[pointer] = wrong.value;
  }
  try {
    static_cast<void>(host::check_arm(host::read_arm_file(arm.dump(1), "my.arm.json"), "my.arm.json"));
    FAIL() << "was accepted: " << wrong.cause;
  } catch (const host::Error& error) {
    EXPECT_EQ(error.name, wrong.slug) << error.cause;
    EXPECT_THAT(error.cause, HasSubstr(wrong.cause));
    EXPECT_THAT(error.cause, HasSubstr("my.arm.json"));
    EXPECT_EQ(error.code, host::ExitCode::kBadInput);
    EXPECT_FALSE(error.remedy.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, WrongArm,
    testing::Values(
        Wrong{"touch", "/thimble_arm", 2, "wrong-version", "is 2"},
        Wrong{"touch", "/axes/0/colour", "red", "unknown-key", "colour"},
        Wrong{"touch", "/axes/5", nullptr, "wrong-axes", "5 axes"},
        Wrong{"touch", "/axes/0/encoder/sign", 0.5, "bad-value", "1 or -1"},
        Wrong{"touch", "/axes/0/encoder/port", 1, "repeated-port", "port 1"},
        Wrong{"touch", "/axes/1/drive/port", 0, "repeated-port", "port 0"},
        Wrong{"touch", "/axes/0/encoder/port", 1.5, "bad-value", "whole"},
        Wrong{"touch", "/axes/0/lower_deg", 60, "empty-range", "waist"},
        Wrong{"touch", "/axes/1/home_deg", 95, "home-beyond-limits", "shoulder"},
        Wrong{"touch", "/axes/0/lower_m", 0.1, "senseless-key", "prismatic"},
        Wrong{"touch", "/axes/0/encoder/counter_bits", 12, "counter-wraps", "waist"},
        Wrong{"touch", "/axes/0/encoder/turns_per_turn", 1e-9, "too-few-counts", "axis waist"},
        Wrong{"touch", "/axes/0/name", "wa\nist", "bad-value", "/axes/0/name"},
        Wrong{"touch", "/kinematics/serial/joints/0/name", "waist ", "bad-value", "spaces at its ends"},
        Wrong{"touch", "/name", "to\tuch", "bad-value", "tabs"},
        Wrong{"touch", "/axes/0/encoder/max_rate_Hz", 10000, "encoder-rate", "waist"},
        Wrong{"touch", "/axes/0/motor", "large", "bad-value", "\"motor\""},
        Wrong{"touch", "/axes/0/motor", nullptr, "missing-key", "motor"},
        Wrong{"touch", "/axes/3/motor", "motor", "senseless-key", "drive"},
        Wrong{"touch", "/kinematics/serial/force_at", "knee", "bad-value", "\"pitch\""},
        Wrong{"touch", "/kinematics/serial/joints/1/name", "waist", "repeated-name", "waist"},
        Wrong{"touch", "/kinematics/serial/joints/0/axis", Json::array({0, 0, 0}), "bad-value", "axis"},
        Wrong{"premium-1.5", "/axes/2/home_deg", 80, "home-beyond-limits", "limit_sums/0"},
        Wrong{"premium-1.5", "/limit_sums/0/weights", Json::array({1, 2}), "bad-value", "each axis"},
        Wrong{"premium-1.5", "/coupling", Json{{"joints_per_axis", {{1, 0, 0}, {0, 1, 1}, {0, 1, 1}}}},
              "singular-coupling", "no inverse"},
        Wrong{"premium-1.5", "/wrist", Json{{"joints", {{{"name", "roll"}}}}}, "senseless-key", "five_bar"},
        Wrong{"premium-1.5", "/bodies", Json::array({{{"link", "fore"}, {"mass_kg", 1}}}), "senseless-key",
              "inertia"},
        Wrong{"falcon", "/bodies/0/link", "shins", "bad-value", "\"thighs\""},
        Wrong{"premium-1.5", "/kinematics/delta", Json::object(), "bad-value", "exactly one"},
        Wrong{"pantograph", "/kinematics/five_bar/outer_m", Json::array({0.02, 0.02}), "does-not-close",
              "do not meet"},
        Wrong{"pantograph", "/kinematics/five_bar/outer_m", Json::array({0.0719, 0.0719}), "singular-home",
              "times as far"},
        Wrong{"falcon", "/kinematics/delta/shin_m", 0.01, "does-not-close", "do not meet"},
        Wrong{"falcon", "/kinematics/delta/home_axis_m", 0, "wrong-branch", "branch"},
        Wrong{"falcon", "/kinematics/delta/branch", "plus", "wrong-branch", "branch"},
        Wrong{"falcon", "/wrist", Json{{"joints", {{{"name", "plate"}}}}}, "repeated-name",
              "/wrist/joints/0/name"},
        Wrong{"falcon", "/motors", Json::array({1}), "bad-value", "/motors is [1]"},
        Wrong{"falcon", "/motors", 5, "bad-value", "/motors is 5"},
        Wrong{"falcon", "/motors/spare", Json{{"colour", "red"}}, "unknown-key", "/motors/spare/colour"},
        Wrong{"falcon", "/$schema", 5, "bad-value", "$schema"},
        Wrong{"falcon", "/axes/1/name", "first", "repeated-name", "/axes/1/name"},
        Wrong{"falcon", "/axes/0/lower_deg", 100, "empty-range", "not below"},
        Wrong{"premium-1.5", "/limit_sums/0/lower_deg", 65, "empty-range", "limit_sums/0"},
        Wrong{"touch", "/axes/3/encoder/kind", "drive", "senseless-key", "/axes/3/encoder/kind"},
        Wrong{"paddle", "/axes/0/drive", nullptr, "senseless-key", "drive"},
        Wrong{"paddle", "/kinematics/serial/tip_m", Json::array({0, 0.07, 0}), "no-force", "no motor moves"}),
    [](const auto& one) { return "case_" + std::to_string(one.index); });

}  // namespace
}  // namespace thimble::test
