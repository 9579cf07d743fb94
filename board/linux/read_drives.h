// The key arms/N/drives of the board's configuration. Throws JsonError. docs/board-linux.md has the keys.
#pragma once

#include <cstddef>
#include <span>

#include "board/files/json_value.h"
#include "board/linux/drive_wiring.h"
#include "kinematics/arm_data.h"

namespace thimble::board {

// The number of the arm's axes; the value is an array of one for each. arm: null where it is not known yet.
[[nodiscard]] std::size_t one_for_each_axis(const JsonValue& value, const kinematics::ArmData* arm);
// One value for each of the arm's axes, null where it has no drive.
[[nodiscard]] DriveWirings read_drives(const JsonValue& value, const kinematics::ArmData* arm);
// What needs the whole configuration: the drives of one bus fit together at this rate. `arms`: the value of the key, for the place of an error.
void check_drive_buses(const JsonValue& arms, std::span<const DriveWirings> wirings, double rate_Hz);

}  // namespace thimble::board
