// The log of a HAPI DeviceLog (SenseGraphics' haptics library), text or binary: times, positions and forces.
//
// Text: a line with the names of what is logged, then a row of numbers for each time. Binary: the names, each with a NUL behind it, one
// more NUL, then the values of each time: doubles, BUTTONS a 32-bit integer, little-endian. A vector has three numbers, an orientation
// four (axis and angle). Units: s, m, N.
// HAPI's axes are X3D's: x to the right, y up, z to the user. They become x to the right, y away from the user, z up.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace thimble::host {

struct DeviceLogSample {
  double time_s = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
};

struct DeviceLog {
  bool binary = false;
  bool raw = false;  // positions are RAW_POSITION, because there is no POSITION
  bool has_force = false;
  std::vector<std::string> columns;
  std::vector<DeviceLogSample> samples;  // times rise
  std::size_t repeated = 0;  // rows left out: their time was not later than that of the row before
};

// thimble_frame: the log has Thimble's axes already.
// Error kBadInput `bad-device-log` (file, and line or byte), `cannot-read`; kPermission.
[[nodiscard]] DeviceLog parse_device_log(std::span<const char> bytes, const std::string& name,
                                         bool thimble_frame);
[[nodiscard]] DeviceLog read_device_log(const std::filesystem::path& file, bool thimble_frame);

}  // namespace thimble::host
