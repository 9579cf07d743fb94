// The engine of `thimble simulate`: a scene image and the path of a hand in, one row per tick and arm out.
// Faster than real time, bit-identical in every run. The caller handles file formats.
//
// ideal: the fingertip follows the path exactly (position and velocity by linear interpolation), and only the
// renderer runs: no
//   ramp, no motor limits. A step of the path faster than kJump_m_s puts the tip there, as after a pause.
// otherwise: the firmware's controller runs against the simulated arm. The arm is homed, the hand moves it to
// the first point of
//   the path, the controller is armed; when the force ramp has ended, path and log begin.
// Two arms are side by side, with their homes .1 m left and right of the origin.
// Row k is at t0 + k / rate_Hz, from the first time of the path up to and including its last.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "board/sim/broken_arm.h"
#include "board/sim/hand_path.h"
#include "board/sim/plant.h"
#include "board/sim/scene_row.h"

namespace thimble::board {

inline constexpr double kJump_m_s = 100.0;  // ten times as fast as a hand

struct SimulationOptions {
  bool ideal = false;
  double rate_Hz = 4000.0;
  std::string arm = "premium-1.5";                // a plant variant
  std::optional<kinematics::ArmData> arm_data{};  // another arm in its place
  std::uint64_t seed = 1;
  std::uint8_t trial = 0;  // the parameter of that name: which force fields act
  Hand hand{};
  Sensors sensors{};  // what the arm has besides encoders
};

struct LogRow {
  double time_s = 0;
  int arm = 0;
  Eigen::Vector3d tip_m;    // true position of the fingertip
  Eigen::Vector3d proxy_m;  // god object
  Eigen::Vector3d force_N;  // rendered force after all limits (ideal: without ramp and motor limits)
  int contacts = 0;
  SceneRow scene;  // during the call that gets the row
};

// A solid that the tip was in when its contacts began. It is not felt until the tip has left it.
struct BeganInside {
  int arm = 0;
  std::string object;
  double from_s = 0;
  std::optional<double> until_s;  // none: it did not leave
};

enum class SimulationStatus {
  kOk,
  kImageRefused,  // the scene image is not valid
  kUnknownArm,    // options.arm
  kBadRate,       // outside 100 Hz to 20 kHz
  kBadPath,       // empty, times not increasing, not finite, an arm other than 0 or 1, or arm 1 without arm 0
  kOutOfReach,    // a point of the path is outside the arm's workspace; not of ideal runs
  kNotArmed,      // the controller refused to home or arm
  kFaulted,       // the controller had a fault; the rows up to there were delivered
};

struct SimulationResult {
  SimulationStatus status = SimulationStatus::kOk;
  std::string detail;       // one sentence for the user; empty when ok
  std::uint64_t ticks = 0;  // rows per arm
  control::RenderCounters bounds;
  std::vector<BeganInside> inside;  // in the order of time
};

// kUnknownArm, kBadRate, or kOk.
[[nodiscard]] SimulationResult checked(const SimulationOptions& options);

// image: a scene image (any alignment; it is copied). path: rows of one or both arms in file order. Does not
// throw for invalid input.
[[nodiscard]] SimulationResult simulate(std::span<const std::byte> image, const std::vector<PathPoint>& path,
                                        const SimulationOptions& options,
                                        const std::function<void(const LogRow&)>& row);

}  // namespace thimble::board
