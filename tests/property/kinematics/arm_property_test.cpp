// Oracles of the kinematics and dynamics over the whole workspace of every arm: seeded sweeps, no golden
// values.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cstdio>
#include <random>

#include "kinematics/built_in_arms.h"
#include "kinematics/dynamics.h"
#include "kinematics/two_link_arm.h"
#include "kinematics/workspace.h"

namespace thimble::kinematics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

class Sweep : public testing::TestWithParam<const char*> {
 protected:
  const ArmData model_ = built_in_arm(GetParam());
  const TwoLinkGeometry& links_ = std::get<TwoLinkGeometry>(model_.geometry.platform);
  const TwoLinkArm<double> arm_{model_};
  std::mt19937_64 random_{20261120};

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3d joints() {  // inside the workspace
    for (;;) {
      Vector3d q;
      for (int j = 0; j < 3; ++j) {
        const AxisData& axis = model_.axis[static_cast<std::size_t>(j)];
        q[j] = uniform(static_cast<double>(axis.lower), static_cast<double>(axis.upper));
      }
      if (workspace_limit(model_, q) == 0) return q;
    }
  }
  Vector3d speeds() { return {uniform(-5, 5), uniform(-5, 5), uniform(-5, 5)}; }
};

TEST_P(Sweep, JacobianIsTheDerivativeOfTheTip) {
  double worst = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector3d q = joints();
    const TwoLinkPosture<double> p = arm_.at(q);
    const double h = 1e-5;
    for (int j = 0; j < 3; ++j) {
      const Vector3d step = h * Vector3d::Unit(j);
      const Vector3d slope = (arm_.at(q + step).tip_m - arm_.at(q - step).tip_m) / (2 * h);
      worst = std::max(worst, (slope - p.jacobian.col(j)).cwiseAbs().maxCoeff());
    }
  }
  std::printf("worst Jacobian error %.3g m/rad\n", worst);
  EXPECT_LT(worst, 1e-10);
}

TEST_P(Sweep, AccelerationBiasIsTheJacobiansDerivative) {
  double worst = 0;
  for (int k = 0; k < 5000; ++k) {
    const Vector3d q = joints(), qd = speeds();
    const double h = 1e-5;
    const Matrix3d Jdot = (arm_.at(q + h * qd).jacobian - arm_.at(q - h * qd).jacobian) / (2 * h);
    worst = std::max(worst, (Jdot * qd - arm_.acceleration_bias(arm_.at(q), qd)).norm());
  }
  std::printf("worst error of Jdot qd: %.3g m/s2\n", worst);
  EXPECT_LT(worst, 1e-7);
}

TEST_P(Sweep, FloatAgreesWithDouble) {
  const TwoLinkArm<float> tick(model_);
  double position = 0, jacobian = 0;
  for (int k = 0; k < 20000; ++k) {
    const Eigen::Vector3f q = joints().cast<float>();
    const TwoLinkPosture<double> exact = arm_.at(q.cast<double>());
    const TwoLinkPosture<float> p = tick.at(q);
    position = std::max(position, (p.tip_m.cast<double>() - exact.tip_m).norm());
    jacobian = std::max(jacobian, (p.jacobian.cast<double>() - exact.jacobian).cwiseAbs().maxCoeff());
  }
  std::printf("float against double: tip %.3g m, Jacobian %.3g m/rad\n", position, jacobian);
  EXPECT_LT(position, 2e-7);
  EXPECT_LT(jacobian, 2e-7);
}

TEST_P(Sweep, InverseThenForward) {
  double worst = 0, joint_error = 0;
  for (int k = 0; k < 20000; ++k) {
    const Vector3d q = joints();
    const TwoLinkPosture<double> p = arm_.at(q);
    const double reach = static_cast<double>(links_.upper_link_m) * p.q2.cos +
                         static_cast<double>(links_.forearm_m) * p.q3.sin;
    if (reach < .01) continue;  // behind its own axis: another joint 1 reaches the same point
    Vector3d back;
    ASSERT_TRUE(arm_.inverse(p.tip_m, back)) << q.transpose();
    worst = std::max(worst, (arm_.at(back).tip_m - p.tip_m).norm());
    for (int j = 0; j < 3; ++j) {
      const double turn = std::remainder(back[j] - q[j], 2 * M_PI);
      joint_error = std::max(joint_error, std::abs(turn));
    }
  }
  std::printf("inverse then forward: tip %.3g m, joints %.3g rad\n", worst, joint_error);
  EXPECT_LT(worst, 1e-9);
  EXPECT_LT(joint_error, 1e-6);
}

TEST_P(Sweep, OutOfReachIsRefused) {
  Vector3d q(7, 7, 7);
  EXPECT_FALSE(arm_.inverse({0, -1, 0}, q));
  EXPECT_EQ(q, Vector3d(7, 7, 7));
}

TEST_P(Sweep, VirtualWorkOfForceAndTorque) {
  double worst = 0;
  for (int k = 0; k < 1000; ++k) {
    const TwoLinkPosture<double> p = arm_.at(joints());
    const Vector3d force = speeds(), qd = speeds();
    worst = std::max(worst, std::abs((p.jacobian.transpose() * force).dot(qd) - force.dot(p.jacobian * qd)));
  }
  EXPECT_LT(worst, 1e-13);
}

TEST_P(Sweep, InertiaIsPositiveDefinite) {
  double least = 1e9;
  for (int k = 0; k < 20000; ++k) {
    const Matrix3d M = mass_matrix(model_.inertia, arm_.at(joints()));
    ASSERT_EQ(M, M.transpose());
    least = std::min(least, Eigen::SelfAdjointEigenSolver<Matrix3d>(M).eigenvalues()[0]);
  }
  std::printf("least eigenvalue of M: %.4g kg m2\n", least);
  EXPECT_GT(least, 0);
}

// dM/dt along the motion by central differences, extrapolated to fourth order.
TEST_P(Sweep, MdotMinusTwoCIsSkew) {
  double difference = 0, power = 0;
  for (int k = 0; k < 5000; ++k) {
    const Vector3d q = joints(), qd = speeds();
    const TwoLinkPosture<double> p = arm_.at(q);
    const Matrix3d C = coriolis_matrix(model_.inertia, p, qd);
    // Richardson: fourth order in h.
    const auto slope = [&](double h) -> Matrix3d {
      return (mass_matrix(model_.inertia, arm_.at(q + h * qd)) -
              mass_matrix(model_.inertia, arm_.at(q - h * qd))) /
             (2 * h);
    };
    const double h = 5e-4;
    const Matrix3d Mdot = (4 * slope(h / 2) - slope(h)) / 3;
    const Matrix3d skew = Mdot - 2 * C;
    difference = std::max(difference, (skew + skew.transpose()).cwiseAbs().maxCoeff());
    power = std::max(power, std::abs(qd.dot(skew * qd)));
  }
  std::printf("Mdot - 2C: symmetric part %.3g, power %.3g W\n", difference, power);
  EXPECT_LT(difference, 1e-11);
  EXPECT_LT(power, 1e-10);
}

TEST_P(Sweep, CoriolisMatchesTheChristoffelSymbols) {
  double worst = 0;
  const double h = 1e-5;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d q = joints(), qd = speeds();
    std::array<Matrix3d, 3> dM;
    for (int j = 0; j < 3; ++j) {
      const Vector3d step = h * Vector3d::Unit(j);
      dM[static_cast<std::size_t>(j)] =
          (mass_matrix(model_.inertia, arm_.at(q + step)) - mass_matrix(model_.inertia, arm_.at(q - step))) /
          (2 * h);
    }
    Matrix3d C;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        C(i, j) = 0;
        for (int n = 0; n < 3; ++n) {
          const auto d = [&](int a, int b, int by) { return dM[static_cast<std::size_t>(by)](a, b); };
          C(i, j) += .5 * (d(i, j, n) + d(i, n, j) - d(j, n, i)) * qd[n];
        }
      }
    }
    worst = std::max(worst, (C - coriolis_matrix(model_.inertia, arm_.at(q), qd)).cwiseAbs().maxCoeff());
  }
  std::printf("Coriolis against differentiated M: %.3g\n", worst);
  EXPECT_LT(worst, 1e-10);
}

TEST_P(Sweep, GravityIsTheGradientOfTheHeightEnergy) {
  double worst = 0;
  const double h = 1e-5;
  for (int k = 0; k < 2000; ++k) {
    const Vector3d q = joints();
    const Vector3d G = gravity_torques(model_.inertia, arm_.at(q));
    for (int j = 0; j < 3; ++j) {
      const Vector3d step = h * Vector3d::Unit(j);
      const double slope = (gravity_energy(model_.inertia, arm_.at(q + step)) -
                            gravity_energy(model_.inertia, arm_.at(q - step))) /
                           (2 * h);
      worst = std::max(worst, std::abs(slope - G[j]));
    }
  }
  EXPECT_LT(worst, 1e-10);
}

TEST_P(Sweep, AFreeArmKeepsItsEnergy) {
  // Runge-Kutta 4 on  M qdd + C qd + G = 0,  rotors included; 0.3 s at 20 us.
  const auto energy = [&](const Vector3d& q, const Vector3d& qd) {
    const TwoLinkPosture<double> p = arm_.at(q);
    Matrix3d M = mass_matrix(model_.inertia, p);
    for (int j = 0; j < 3; ++j)
      M(j, j) += static_cast<double>(model_.axis[static_cast<std::size_t>(j)].reflected_rotor_inertia());
    return .5 * qd.dot(M * qd) + gravity_energy(model_.inertia, p);
  };
  const auto acceleration = [&](const Vector3d& q, const Vector3d& qd) -> Vector3d {
    const TwoLinkPosture<double> p = arm_.at(q);
    Matrix3d M = mass_matrix(model_.inertia, p);
    for (int j = 0; j < 3; ++j)
      M(j, j) += static_cast<double>(model_.axis[static_cast<std::size_t>(j)].reflected_rotor_inertia());
    return M.inverse() * (-coriolis_matrix(model_.inertia, p, qd) * qd - gravity_torques(model_.inertia, p));
  };
  double worst = 0;
  for (int run = 0; run < 20; ++run) {
    Vector3d q = joints(), qd = .6 * speeds();
    const double start = energy(q, qd);
    const double kinetic = start - gravity_energy(model_.inertia, arm_.at(q));
    const double h = 2e-5;
    for (int k = 0; k < 15000; ++k) {
      const Vector3d a1 = acceleration(q, qd);
      const Vector3d v2 = qd + h / 2 * a1, a2 = acceleration(q + h / 2 * qd, v2);
      const Vector3d v3 = qd + h / 2 * a2, a3 = acceleration(q + h / 2 * v2, v3);
      const Vector3d v4 = qd + h * a3, a4 = acceleration(q + h * v3, v4);
      q += h / 6 * (qd + 2 * v2 + 2 * v3 + v4);
      qd += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
    }
    worst = std::max(worst, std::abs(energy(q, qd) - start) / kinetic);
  }
  std::printf("energy drift of a free arm in 0.3 s: %.3g of its kinetic energy\n", worst);
  EXPECT_LT(worst, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Arms, Sweep, testing::Values("premium-1.5", "wooden"));

}  // namespace
}  // namespace thimble::kinematics
