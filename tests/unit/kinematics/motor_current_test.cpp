#include "kinematics/motor_current.h"

#include <gtest/gtest.h>

#include "kinematics/built_in_arms.h"

namespace thimble::kinematics {
namespace {

ArmData premium() { return built_in_arm("premium-1.5"); }

PerAxis<float> three(float a, float b, float c) {
  PerAxis<float> all = PerAxis<float>::Zero();
  all.head<3>() << a, b, c;
  return all;
}

struct Found {
  PerAxis<float> current_A = PerAxis<float>::Zero();
  int limited_by = kNoAxis;
};
Found found(const ArmData& arm, const PerAxis<float>& torque_N_m, const PerAxis<float>& limit_A) {
  Found out;
  out.limited_by = motor_currents(arm, axes_of(arm.geometry), torque_N_m, limit_A, out.current_A);
  return out;
}
// The motors are cold.
Found found(const ArmData& arm, const PerAxis<float>& torque_N_m) {
  PerAxis<float> peak_A;
  for (int j = 0; j < kMaxJoints; ++j) peak_A[j] = arm.axis[static_cast<std::size_t>(j)].motor.peak_current_A;
  return found(arm, torque_N_m, peak_A);
}

TEST(MotorCurrents, WithinThePeakNothingActs) {
  const auto out = found(premium(), three(.1F, -.2F, .3F));
  EXPECT_EQ(out.limited_by, kNoAxis);
  EXPECT_FLOAT_EQ(out.current_A[0], .1F / (13.3F * .0234F));
  EXPECT_FLOAT_EQ(out.current_A[1], -.2F / (11.2F * .0234F));
  EXPECT_FLOAT_EQ(out.current_A[2], .3F / (11.2F * .0234F));
}

TEST(MotorCurrents, SignFollowsTheWiring) {
  ArmData m = premium();
  m.axis[1].drive_sign = -1.0F;
  EXPECT_FLOAT_EQ(found(m, three(0, .2F, 0)).current_A[1], -found(premium(), three(0, .2F, 0)).current_A[1]);
}

TEST(MotorCurrents, TheWorstMotorIsNamedAndTheDirectionKept) {
  const float peak = premium().axis[0].motor.peak_current_A;
  for (int worst = 0; worst < 3; ++worst) {
    PerAxis<float> torque = three(.5F, -.4F, .3F);
    torque[worst] = -4.0F;
    const auto out = found(premium(), torque);
    EXPECT_EQ(out.limited_by, worst);
    EXPECT_LE(out.current_A.cwiseAbs().maxCoeff(), peak);
    EXPECT_FLOAT_EQ(out.current_A[worst], -peak);
    for (int j = 0; j < 3; ++j) {
      const float back = out.current_A[j] * premium().axis[static_cast<std::size_t>(j)].torque_per_ampere();
      EXPECT_NEAR(back / torque[j],
                  out.current_A[worst] * premium().axis[static_cast<std::size_t>(worst)].torque_per_ampere() /
                      torque[worst],
                  1e-6F);
    }
  }
}

TEST(MotorCurrents, ADeratedMotorLimitsFirst) {
  const auto out = found(premium(), three(.5F, .5F, .5F), three(5.0F, .5F, 5.0F));
  EXPECT_EQ(out.limited_by, 1);
  EXPECT_FLOAT_EQ(out.current_A[1], .5F);
  const auto off = found(premium(), three(.5F, .5F, .5F), three(0, 0, 0));
  EXPECT_NE(off.limited_by, kNoAxis);
  EXPECT_EQ(off.current_A.cwiseAbs().maxCoeff(), 0.0F);
}

// A sensed axis has no motor, whatever torque is asked of it; an axis of a stronger motor is scaled with the others.
TEST(MotorCurrents, OfUnlikeAxes) {
  ArmData m = premium();
  m.geometry.driven[0] = false;
  m.axis[1].motor.peak_current_A = 20.0F;
  const auto out = found(m, three(9, 2, 9));
  EXPECT_EQ(out.current_A[0], 0.0F);
  EXPECT_EQ(out.limited_by, 2);
  EXPECT_FLOAT_EQ(out.current_A[1] / out.current_A[2], 2.0F / 9.0F);
}

}  // namespace
}  // namespace thimble::kinematics
