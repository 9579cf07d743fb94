// Whether the tip of an arm comes to a place, within the limits of its axes.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "kinematics/arm.h"

namespace thimble::host {

// World frame, m: the tip is at the origin with all axes at home, and the base stands as without a mounting. Takes some ms to make.
class ArmReach {
 public:
  // The point of a place that is nearest to the given one.
  using Nearest = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;

  explicit ArmReach(const kinematics::ArmData& arm);
  ArmReach(const ArmReach&) = delete;
  ArmReach& operator=(const ArmReach&) = delete;
  ~ArmReach() = default;

  // How near the tip was found to come to the place: from a few thousand postures the nearest ones are improved step by step. At most what it
  // comes to, up to kReachTolerance_m; for a place that is not convex it may be less.
  [[nodiscard]] double nearest_m(const Nearest& place) const;

  static constexpr double kReachTolerance_m = 1e-5;

 private:
  struct Sample {
    kinematics::PerAxis<double> axes;
    Eigen::Vector3d tip_m;
  };
  [[nodiscard]] bool tip_at(const kinematics::PerAxis<double>& axes,
                            kinematics::Posture<double>& posture) const;
  [[nodiscard]] double improved_m(const Sample& from, const Nearest& place) const;

  kinematics::ArmData data_;
  kinematics::Arm<double> arm_;
  std::vector<Sample> samples_;
};

}  // namespace thimble::host
