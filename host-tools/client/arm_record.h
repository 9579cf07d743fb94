// One CAN FD telemetry frame as the classic frames that it stands for.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/link/can_frame.h"

namespace thimble::host {

// Of an ArmRecord of this node: Pose, Force, GodObject where it is not the tip, and JointAngles, MotorCurrents and Temperatures
// where the frame has them. Of any other frame: that frame.
[[nodiscard]] std::vector<firmware::link::CanFrame> classic_frames(const firmware::link::CanFrame& frame,
                                                                   std::uint8_t node);

}  // namespace thimble::host
