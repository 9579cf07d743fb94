// The links of a device's arm for the page.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "host-tools/arms/arm_data.h"
#include "host-tools/arms/arm_pose.h"
#include "host-tools/viewer/protocol.h"

namespace thimble::host {

class ArmDrawing {
 public:
  explicit ArmDrawing(const kinematics::ArmData& arm) : pose_(arm) {}

  [[nodiscard]] std::size_t axes() const { return pose_.axes(); }

  // Lines of points from joint to joint, m in the world's frame to 0.1 mm. The tip of the same record tells where the base stands; how a base is turned by
  // its mounting is not known here. Null: the links do not meet at these axes (rad, m).
  [[nodiscard]] Json lines(const std::vector<double>& axes, const std::array<double, 3>& tip_m);

 private:
  ArmPose pose_;
};

}  // namespace thimble::host
