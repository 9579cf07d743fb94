// Arms from URDFs at random, against KDL with the same numbers; and what is not an arm is refused by name.
#include "host-tools/arms/urdf_import.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <kdl/chainfksolverpos_recursive.hpp>
#include <string>
#include <vector>

#include "host-tools/arms/arm_checks.h"
#include "host-tools/arms/arm_file.h"
#include "kinematics/mechanism.h"
#include "tests/support/figure.h"
#include "tests/support/random.h"

namespace thimble::test {
namespace {

using Eigen::Vector3d;

// A vector as a URDF has it, to a micrometre, and its numbers for KDL.
struct Written {
  std::string text;
  KDL::Vector numbers;
};
Written written(const Vector3d& v) {
  const Vector3d rounded = (1e6 * v).array().round() * 1e-6;
  return {fmt::format("{:.6f} {:.6f} {:.6f}", rounded.x(), rounded.y(), rounded.z()),
          {rounded.x(), rounded.y(), rounded.z()}};
}

struct SomeArm {
  std::string urdf;
  KDL::Chain chain;
};

// Joints one behind the other, some of them fixed, each with a link behind it; the last one is `end`.
SomeArm some_arm(Random& random, int movable) {
  SomeArm arm{"<robot name=\"some\"><link name=\"base\"/>", {}};
  std::string parent = "base";
  for (int joint = 0, moving = 0; moving < movable || random.below(2) == 0; ++joint) {
    const bool moves = moving < movable && random.below(3) != 0;
    const bool prismatic = moves && random.below(4) == 0;
    moving += moves ? 1 : 0;
    const std::string link = fmt::format("link{}", joint);
    const Written centre = written(0.05 * random.in_box(Vector3d::Ones()));
    const Written at = written(0.1 * random.in_box(Vector3d::Ones()));
    const Written rpy = written(3 * random.in_box(Vector3d::Ones())), axis = written(random.direction());
    const char* const type = !moves ? "fixed" : prismatic ? "prismatic" : "revolute";
    arm.urdf += fmt::format(
        R"(<link name="{0}"><inertial><origin xyz="{1}"/><mass value="0.1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j{2}" type="{3}"><parent link="{4}"/><child link="{0}"/><origin xyz="{5}" rpy="{6}"/><axis xyz="{7}"/>
<limit lower="-1" upper="2" effort="1" velocity="1"/></joint>)",
        link, centre.text, joint, type, parent, at.text, rpy.text, axis.text);
    const auto turn = KDL::Rotation::RPY(rpy.numbers.x(), rpy.numbers.y(), rpy.numbers.z());
    arm.chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(turn, at.numbers)));
    if (moves)
      arm.chain.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), axis.numbers,
                                                   prismatic ? KDL::Joint::TransAxis : KDL::Joint::RotAxis),
                                        KDL::Frame()));
    parent = link;
  }
  arm.urdf += fmt::format(
      R"(<link name="end"/><joint name="last" type="fixed"><parent link="{}"/><child link="end"/>
<origin xyz="0.01 0.02 0.03" rpy="0 0 0"/></joint></robot>)",
      parent);
  arm.chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(KDL::Vector(0.01, 0.02, 0.03))));
  return arm;
}

TEST(UrdfImport, TheTipIsWhereKdlHasIt) {
  Random random(7);
  double worst_m = 0;
  for (int i = 0; i < 200; ++i) {
    const int joints = 1 + static_cast<int>(random.below(7));
    const auto [urdf, chain] = some_arm(random, joints);
    const host::ArmFile arm = host::read_arm_file(host::import_urdf(urdf, "some", ""), "some");
    ASSERT_EQ(arm.axes.size(), static_cast<std::size_t>(joints));
    EXPECT_GT(arm.geometry.body_count, 0);

    ASSERT_EQ(chain.getNrOfJoints(), static_cast<unsigned>(joints));
    const auto peer_m = [&chain = chain, joints](const Eigen::VectorXd& q) -> Vector3d {
      KDL::JntArray array(static_cast<unsigned>(joints));
      array.data = q;
      KDL::Frame frame;
      EXPECT_GE(KDL::ChainFkSolverPos_recursive(chain).JntToCart(array, frame), 0);
      return {frame.p.x(), frame.p.y(), frame.p.z()};
    };
    const kinematics::Mechanism<double> mechanism(arm.geometry);
    kinematics::MechanismPose<double> pose = mechanism.home_pose();
    const kinematics::AxisVector<double> axes = 1.5 * kinematics::AxisVector<double>::Random(joints);
    ASSERT_TRUE(mechanism.at(axes, pose));
    worst_m = std::max(worst_m, (pose.tip_m - (peer_m(axes) - peer_m(Eigen::VectorXd::Zero(joints)))).norm());
  }
  figure("tips of imported arms against KDL, m", worst_m, "1e-6: geometry in float");
  EXPECT_LT(worst_m, 1e-6);
}

std::string with_joint(const std::string& joint) {
  return R"(<robot name="r"><link name="a"/><link name="b"/><joint name="j" )" + joint +
         R"(<parent link="a"/><child link="b"/><axis xyz="0 0 1"/></joint></robot>)";
}

// The tests' judge of the mass: a camera beside the way to the tip, with a lens that is fixed to it and a shutter that moves.
TEST(UrdfImport, WhatIsFixedToALinkIsCarriedWithIt) {
  const auto link = [](const std::string& name, const std::string& mass_kg) {
    return "<link name=\"" + name + R"("><inertial><origin xyz="0 0 0.1"/><mass value=")" + mass_kg +
           R"("/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>)";
  };
  const auto joint_at = [](const std::string& type, const std::string& parent, const std::string& child) {
    return "<joint name=\"" + child + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + R"("/><origin xyz="1 0 0" rpy="0 1.5707963267949 0"/></joint>)";
  };
  const std::string urdf = "<robot name=\"r\">" + link("base", "7") + link("arm", "1") + link("camera", "2") +
                           link("lens", "4") + link("shutter", "8") + link("tip", "16") +
                           joint_at("continuous", "base", "arm") + joint_at("fixed", "arm", "camera") +
                           joint_at("fixed", "camera", "lens") + joint_at("continuous", "camera", "shutter") +
                           joint_at("fixed", "arm", "tip") + "</robot>";
  const host::ArmFile arm = host::read_arm_file(host::import_urdf(urdf, "arm", "tip"), "arm");
  ASSERT_EQ(arm.geometry.body_count, 1);
  const kinematics::Body& body = arm.geometry.body[0];
  EXPECT_FLOAT_EQ(body.mass_kg, 23);
  // The camera and the tip have z along the arm's x, the lens is 1 m below the camera and has z along the arm's -z.
  const Eigen::Vector3f moment_kg_m =
      1 * Eigen::Vector3f(0, 0, 0.1F) + 18 * Eigen::Vector3f(1.1F, 0, 0) + 4 * Eigen::Vector3f(1, 0, -1.1F);
  EXPECT_LT((body.centre_m - moment_kg_m / 23).norm(), 1e-6F);
}

std::string joint(const std::string& parent, const std::string& child) {
  return "<link name=\"" + parent + "\"/><joint name=\"" + parent + child +
         "\" type=\"continuous\"><parent link=\"" + parent + "\"/><child link=\"" + child + "\"/></joint>";
}

std::string repeated(const std::string& word) {
  std::string text;
  for (int i = 0; i < 200000; ++i) text += word;
  return text;
}

TEST(UrdfImport, WhatIsNoArmIsRefusedByName) {
  std::string eight = R"(<robot name="r"><link name="l0"/>)";
  for (int j = 1; j <= 8; ++j)
    eight += fmt::format(
        R"(<link name="l{1}"/><joint name="j{1}" type="continuous"><parent link="l{0}"/><child link="l{1}"/></joint>)",
        j - 1, j);
  eight += "</robot>";
  const std::string fork =
      R"(<robot name="r"><link name="a"/><link name="b"/><link name="c"/><joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
<joint name="k" type="continuous"><parent link="a"/><child link="c"/></joint></robot>)";
  struct Case {
    std::string urdf, tip, slug;
  };
  for (const Case& c :
       {Case{"", "", "not-a-urdf"}, Case{"<robot", "", "not-a-urdf"}, Case{"{}", "", "not-a-urdf"},
        Case{with_joint(R"(type="fixed">)"), "", "wrong-joints"}, Case{eight, "", "wrong-joints"},
        Case{with_joint(R"(type="planar">)"), "", "joint-type"}, Case{fork, "", "ambiguous-tip"},
        Case{fork, "d", "unknown-link"},
        Case{with_joint(R"(type="continuous"><mimic joint="k"/>)"), "", "mimic-joint"},
        Case{with_joint(R"(type="continuous">)").insert(16, joint("c", "d") + joint("d", "c")), "c",
             "not-a-tree"},
        Case{with_joint(R"(type="continuous">)")
                 .insert(
                     16,
                     R"(<joint name="second" type="continuous"><parent link="a"/><child link="b"/></joint>)"),
             "", "not-a-tree"},
        Case{with_joint(R"(type="continuous">)").replace(13, 1, "\xF6"), "", "not-utf-8"},
        Case{repeated("<a>") + repeated("</a>"), "", "not-a-urdf"}}) {
    try {
      static_cast<void>(host::import_urdf(c.urdf, "arm", c.tip));
      ADD_FAILURE() << c.slug << " was accepted";
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, c.slug);
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      EXPECT_FALSE(error.remedy.empty());
    }
  }
  EXPECT_NO_THROW(static_cast<void>(host::import_urdf(fork, "arm", "c")));
}

// One joint, with what is given; a link behind it with a mass.
struct Robot {
  std::string joint = "j", axis = "0 0 1", origin = "0 0 0.1", lower = "-1", mass = "1", centre = "0 0 0.1",
              ixx = "1", name = "r";
  [[nodiscard]] std::string urdf() const {
    return fmt::format(
        R"(<robot name="{}"><link name="a"/><link name="fore"><inertial><origin xyz="{}"/><mass value="{}"/><inertia ixx="{}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="{}" type="revolute"><parent link="a"/><child link="fore"/><origin xyz="{}"/><axis xyz="{}"/><limit lower="{}" upper="1" effort="1" velocity="1"/></joint></robot>)",
        name, centre, mass, ixx, joint, origin, axis, lower);
  }
};

TEST(UrdfImport, TheErrorSaysWhatIsWrongAndWhere) {
  struct Case {
    std::string urdf, slug, cause;
  };
  const std::string sound = Robot{}.urdf();
  std::vector<Case> cases{
      {"", "not-a-urdf", "empty"},
      {"<sdf/>", "not-a-urdf", "'robot' element"},
      {sound.substr(0, 200), "not-a-urdf", "Error parsing"},
      {repeated("<a>") + repeated("</a>"), "not-a-urdf", "too deeply"},
      {std::string(sound).replace(sound.find("parent link=\"a\""), 15, "parent link=\"z\""), "not-a-urdf",
       "parent link [z] of joint [j] not found"},
      {Robot{.joint = "shoulder", .axis = "0 0"}.urdf(), "not-a-urdf", "[shoulder]"},
      {Robot{.joint = "shoulder", .axis = "0 0"}.urdf(), "not-a-urdf", "2 elements but 3 expected"},
      {Robot{.joint = "shoulder", .origin = "nan 0 0"}.urdf(), "not-a-urdf", "shoulder"},
      {Robot{.origin = "nan 0 0"}.urdf(), "not-a-urdf", "[nan]"},
      {Robot{.lower = "inf"}.urdf(), "not-a-urdf", "lower value (inf)"},
      {Robot{.centre = "0 nan 0"}.urdf(), "bad-mass", "[fore]"},
      {Robot{.ixx = "nan"}.urdf(), "bad-mass", "ixx"},
      {Robot{.mass = "-1"}.urdf(), "bad-mass", "link 'fore' has a mass of -1 kg"},
      {Robot{.joint = std::string(32, 'n')}.urdf(), "bad-name", "32 bytes"},
      {Robot{.joint = std::string(100000, 'n')}.urdf(), "bad-name", "nnn...' has a name of 100000 bytes"},
      {Robot{.joint = ""}.urdf(), "bad-name", "0 bytes"}};
  for (const char* mass : {"nan", "inf", "-inf", "1e400", "heavy", ""}) {
    cases.push_back({Robot{.mass = mass}.urdf(), "bad-mass", fmt::format("mass [{}]", mass)});
    cases.push_back({Robot{.mass = mass}.urdf(), "bad-mass", "[fore]"});
  }
  for (const Case& c : cases) {
    try {
      static_cast<void>(host::import_urdf(c.urdf, "arm", ""));
      ADD_FAILURE() << c.slug << " was accepted: " << c.cause;
    } catch (const host::Error& error) {
      EXPECT_EQ(error.name, c.slug) << error.cause;
      EXPECT_NE(error.cause.find(c.cause), std::string::npos) << error.cause << " lacks " << c.cause;
      EXPECT_LT(error.cause.size(), 500U);
      EXPECT_EQ(error.code, host::ExitCode::kBadInput);
      EXPECT_FALSE(error.remedy.empty());
    }
  }
  // After all these a sound one is imported, with the longest names that an arm has, and a robot's name that it has no place for.
  const Robot longest{.joint = std::string(31, 'n'), .name = std::string(100000, 'r')};
  EXPECT_EQ(host::read_arm_file(host::import_urdf(longest.urdf(), "arm", ""), "arm").axes[0].name,
            std::string(31, 'n'));
}

}  // namespace
}  // namespace thimble::test
