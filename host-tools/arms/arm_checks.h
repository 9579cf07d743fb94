// Whether an arm can work, and what it can do: the figures of `thimble model show`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "host-tools/arms/arm_file.h"

namespace thimble::host {

struct AxisFigures {
  double count_m = 0;       // way of the tip for one count, at home
  double peak_force_N = 0;  // that its peak torque gives along the way of the force point, at home
};

// All at home, in the frame that the arm has without a mounting.
struct ArmFigures {
  int force_dof = 0;  // directions in which a force can be felt
  int pose_dof = 0;   // of the tip, that the encoders tell; at home or near it
  Eigen::Vector3d home_tip_m = Eigen::Vector3d::Zero();  // from the base
  std::vector<double>
      singular_values;  // of the Jacobian of the force point by the driven axes, m; descending, force_dof of them
  double least_peak_force_N = 0, most_peak_force_N = 0;  // over the directions of force
  std::vector<AxisFigures> axes;
  std::vector<std::string> warnings;
};

// Throws Error (kBadInput) for an arm that cannot work: limits the wrong way round or home beyond them, two on one port, no drive, links that do
// not meet at home or meet on another branch, a singular home, an encoder that counts slower than the arm moves, a counter that wraps within the limits.
[[nodiscard]] ArmFigures check_arm(const ArmFile& arm, const std::string& file);

}  // namespace thimble::host
