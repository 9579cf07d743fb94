// The controller of a wall beside the tip: counts to force to currents, as the firmware renders a plane. The prediction of wall_limit.h and the simulated
// bench share it.
#pragma once

#include <vector>

#include "firmware/core/encoder_probe.h"
#include "firmware/core/encoder_watch.h"
#include "firmware/core/force_limits.h"
#include "host-tools/commission/bench.h"
#include "host-tools/commission/expectation.h"
#include "kinematics/mechanism.h"
#include "kinematics/velocity.h"

namespace thimble::host {

// Where a wall can be felt, away from it: up where the tip goes up and down, otherwise along the way of the axis that moves it most.
[[nodiscard]] Eigen::Vector3d wall_normal(const Expectation& arm);
// Two counts at the tip along the wall's normal: more is a swing.
[[nodiscard]] double wall_tolerance_m(const Expectation& arm);
// By the counts, where a tip at rest between two counts of an axis shows one.
[[nodiscard]] inline double counted_tolerance_m(const Expectation& arm) {
  return 1.5 * wall_tolerance_m(arm);
}

class WallLoop {
 public:
  // The file and `arm` outlive the loop. wall: of the kind kWall; its wall_depth_m counts from the first place that currents() is given.
  WallLoop(const Expectation& arm, const TipProgram& wall, double tick_s);

  // Once a tick. at: of the axes by their counts, counts: since any time. Zero currents where the links do not meet.
  [[nodiscard]] JointVector currents(const JointVector& at, const PerAxis<std::int64_t>& counts);
  [[nodiscard]] double tip_speed_m_s() const { return tip_speed_m_s_; }

 private:
  void limit(double wanted_N, double depth_m);
  [[nodiscard]] JointVector torques() const;
  [[nodiscard]] Eigen::Vector3f probed(const Eigen::Vector3f& wanted_N);

  const Expectation& arm_;
  kinematics::Mechanism<double> mechanism_;
  kinematics::MechanismPose<double> pose_;
  TipProgram wall_;
  double tick_s_;
  bool redundant_;  // more axes have a motor than a force has directions
  std::vector<kinematics::VelocityEstimator> estimators_;
  PerAxis<std::int64_t> first_{};
  PerAxis<std::int32_t> moved_{};
  JointVector torque_;  // that the axes got last
  std::vector<firmware::EncoderWatch> watches_;
  firmware::EncoderProbe probe_;
  Eigen::Vector3f force_N_ = Eigen::Vector3f::Zero(), unprobed_N_ = Eigen::Vector3f::Zero();
  firmware::ForceAccount account_;
  double home_m_ = 0, tip_speed_m_s_ = 0;
  bool begun_ = false, limits_begun_ = false;
};

}  // namespace thimble::host
