#include "kinematics/motor_current.h"

#include <gtest/gtest.h>

namespace thimble::kinematics {
namespace {

const ArmModel& premium() { return *find_arm_model("premium-1.5"); }

TEST(MotorCurrents, WithinThePeakNothingActs) {
  const auto out = motor_currents(premium(), {.1F, -.2F, .3F});
  EXPECT_EQ(out.which, CurrentLimit::kNone);
  EXPECT_FLOAT_EQ(out.value[0], .1F / (13.3F * .0234F));
  EXPECT_FLOAT_EQ(out.value[1], -.2F / (11.2F * .0234F));
  EXPECT_FLOAT_EQ(out.value[2], .3F / (11.2F * .0234F));
}

TEST(MotorCurrents, SignFollowsTheWiring) {
  ArmModel m = premium();
  m.joint[1].sign = -1.0F;
  EXPECT_FLOAT_EQ(motor_currents(m, {0, .2F, 0}).value[1], -motor_currents(premium(), {0, .2F, 0}).value[1]);
}

TEST(MotorCurrents, TheWorstMotorIsNamedAndTheDirectionKept) {
  const float peak = premium().motor.peak_current_A;
  for (int worst = 0; worst < 3; ++worst) {
    Eigen::Vector3f torque(.5F, -.4F, .3F);
    torque[worst] = -4.0F;
    const auto out = motor_currents(premium(), torque);
    EXPECT_EQ(out.which, static_cast<CurrentLimit>(worst + 1));
    EXPECT_LE(out.value.cwiseAbs().maxCoeff(), peak);
    EXPECT_FLOAT_EQ(out.value[worst], -peak);
    for (int j = 0; j < 3; ++j) {
      const float back = out.value[j] * premium().torque_per_ampere(j);
      EXPECT_NEAR(back / torque[j], out.value[worst] * premium().torque_per_ampere(worst) / torque[worst],
                  1e-6F);
    }
  }
}

TEST(MotorCurrents, ADeratedMotorLimitsFirst) {
  const auto out = motor_currents(premium(), {.5F, .5F, .5F}, {5.0F, .5F, 5.0F});
  EXPECT_EQ(out.which, CurrentLimit::kMotor2);
  EXPECT_FLOAT_EQ(out.value[1], .5F);
  const auto off = motor_currents(premium(), {.5F, .5F, .5F}, {0, 0, 0});
  EXPECT_NE(off.which, CurrentLimit::kNone);
  EXPECT_EQ(off.value.cwiseAbs().maxCoeff(), 0.0F);
}

}  // namespace
}  // namespace thimble::kinematics
