// The fade of forces near singularities, on random Jacobians against Eigen's singular value decomposition in double, and on arms that go there.
#include "kinematics/force_fade.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <algorithm>
#include <limits>

#include "kinematics/built_in_arms.h"
#include "kinematics/two_link_arm.h"
#include "kinematics/workspace.h"
#include "tests/property/mechanism/some_arms.h"
#include "tests/support/figure.h"

namespace thimble::kinematics {
namespace {

using Eigen::Matrix3d;

Jacobian3<float> in_float(const Eigen::MatrixXd& jacobian) { return jacobian.cast<float>(); }

// A Jacobian with these singular values, in random directions.
Eigen::MatrixXd some_jacobian(Random& random, const Vector3d& values, int axes) {
  const Matrix3d U = Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()).toRotationMatrix();
  const Eigen::MatrixXd V =
      Eigen::HouseholderQR<Eigen::MatrixXd>(Eigen::MatrixXd::Random(axes, axes)).householderQ();
  const int rank = std::min(axes, 3);
  return U.leftCols(rank) * values.head(rank).asDiagonal() * V.leftCols(rank).transpose();
}

TEST(ForceFade, IsThatOfTheSingularValues) {
  Random random(10);
  double worst = 0;
  int faded = 0;
  for (int i = 0; i < 20000; ++i) {
    const int axes = 1 + static_cast<int>(random.below(7)), rank = std::min(axes, 3);
    const Vector3d at_home(random.uniform(0.1, 0.3), random.uniform(0.1, 0.3), random.uniform(0.1, 0.3));
    const ForceFade fade(in_float(some_jacobian(random, at_home, axes)));
    ASSERT_EQ(fade.force_dof(), rank);
    Vector3d values = at_home;
    values[static_cast<int>(random.below(static_cast<std::uint64_t>(rank)))] *=
        std::exp(random.uniform(-6, 5));
    const Jacobian3<float> jacobian = in_float(some_jacobian(random, values, axes));
    const Vector3d force_N = 5 * random.direction();
    const ForceFade::Faded result = fade.of(jacobian, force_N.cast<float>());

    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(jacobian.cast<double>(), Eigen::ComputeThinU);
    const double least = 0.05 * at_home.head(rank).minCoeff(), most = 20 * at_home.head(rank).maxCoeff();
    Vector3d wanted_N = force_N;
    for (int k = 0; k < rank; ++k) {
      const double value = svd.singularValues()[k];
      const double part = std::min({1.0, value / least, most / value});
      const Vector3d along = svd.matrixU().col(k);
      wanted_N -= (1 - part) * along.dot(force_N) * along;
    }
    const double error = (result.force_N.cast<double>() - wanted_N).norm();
    worst = std::max(worst, error);
    if (result.faded) ++faded;
    EXPECT_LE(result.force_N.norm(), 5.0001F);
    // No torque is more than the loosest direction that is allowed gives.
    EXPECT_LE((jacobian.transpose() * result.force_N).norm(), 1.001 * 5 * most);
  }
  test::figure("faded forces against singular values, of 5 N", worst, "1e-3");
  test::figure("cases that fade", faded, "> 5000");
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(faded, 5000);
}

// A force that no Jacobian vouches for is not rendered, and of an arm with fewer forces that comes to a singularity none is lost to the others.
TEST(ForceFade, NanGivesNanAndFewerForcesFade) {
  Random random(13);
  for (int axes = 1; axes <= 3; ++axes) {
    const Jacobian3<float> home = in_float(some_jacobian(random, {0.2, 0.15, 0.1}, axes));
    const ForceFade fade(home);
    Jacobian3<float> jacobian = home;
    jacobian(2, axes - 1) = std::numeric_limits<float>::quiet_NaN();
    const ForceFade::Faded nothing = fade.of(jacobian, {1, 2, 3});
    EXPECT_TRUE(nothing.faded && nothing.force_N.hasNaN()) << axes;
    EXPECT_TRUE(fade.of(home, {1, std::numeric_limits<float>::quiet_NaN(), 3}).force_N.hasNaN());
    // All directions at a hundredth of what they were at home: a fifth of the least one's limit, or more.
    const ForceFade::Faded less = fade.of(0.01F * home, {1, 2, 3});
    const float part = (0.01F * home.transpose() * less.force_N).norm() /
                       (0.01F * home.transpose() * Eigen::Vector3f(1, 2, 3)).norm();
    EXPECT_TRUE(less.faded && part >= 0.19F && part < 0.45F) << part;
  }
}

// Along a way through a singularity the force does not jump.
TEST(ForceFade, IsContinuous) {
  Random random(11);
  double jump_N = 0;
  for (int i = 0; i < 200; ++i) {
    const Eigen::MatrixXd home = some_jacobian(random, {0.2, 0.2, 0.15}, 3);
    const Eigen::MatrixXd turn = some_jacobian(random, {1, 1, 1}, 3),
                          other = some_jacobian(random, {1, 1, 1}, 3);
    const ForceFade fade(in_float(home));
    const Eigen::Vector3f force_N = (5 * random.direction()).cast<float>();
    Eigen::Vector3f before = Eigen::Vector3f::Zero();
    for (int k = 0; k <= 20000; ++k) {
      const double third = 0.03 * std::abs(1 - k * 1e-4);
      const Eigen::Vector3f now =
          fade.of(in_float(turn * Vector3d(0.2, 0.17, third).asDiagonal() * other.transpose()), force_N)
              .force_N;
      if (k > 0) jump_N = std::max(jump_N, static_cast<double>((now - before).norm()));
      before = now;
    }
  }
  test::figure("jump of the force for a step of 3 um/rad, N", jump_N, "0.005");
  EXPECT_LT(jump_N, 0.005);
}

// The two-link arm inside its limits is nowhere near: nothing is taken from it.
TEST(ForceFade, LeavesThePremiumAlone) {
  const ArmData premium = built_in_arm("premium-1.5");
  const TwoLinkArm<float> arm(premium);
  const ForceFade fade(arm.at(arm.home()).jacobian);
  Random random(12);
  int inside = 0, taken = 0;
  for (int i = 0; i < 100000; ++i) {
    const Eigen::Vector3f q(static_cast<float>(random.uniform(-1.5, 1.5)),
                            static_cast<float>(random.uniform(-2, 2)),
                            static_cast<float>(random.uniform(-0.5, 3.7)));
    if (workspace_limit(premium, q) != 0) continue;
    ++inside;
    if (fade.of(arm.at(q).jacobian, {1, 2, 3}).faded) ++taken;
  }
  test::figure("poses of the Premium in which a force fades, %", 100.0 * taken / inside, "2");
  EXPECT_LT(100 * taken, 2 * inside);  // where the tip is near the axis of yaw
}

}  // namespace
}  // namespace thimble::kinematics
