// The engine behind `thimble simulate`: a scene image and a hand's path in, one row a tick (and arm) out.
// Faster than real time, deterministic to the bit. The file formats are the caller's.
//
// ideal: the fingertip is on the path exactly (position on the line between two points, velocity that line's)
//   and the force is only computed: renderer alone, no ramp, no motor limits.
// otherwise: the firmware's controller runs against the simulated arm. The arm is homed, the hand leads it to
//   the path's first point, the controller is armed, and when the force ramp is done the path, and the log,
//   begin.
// Two arms stand side by side, their homes .1 m left and right of the origin.
// Row k is at t0 + k / rate_Hz, from the path's first time up to and including its last.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "board/sim/hand_path.h"
#include "board/sim/plant.h"

namespace thimble::board {

struct SimulationOptions {
  bool ideal = false;
  double rate_Hz = 4000.0;
  std::string arm = "premium-1.5";  // a plant variant
  std::uint64_t seed = 1;
  Hand hand{};
};

struct LogRow {
  double time_s = 0;
  int arm = 0;
  Eigen::Vector3d tip_m;    // the arm's true fingertip
  Eigen::Vector3d proxy_m;  // god object
  Eigen::Vector3d force_N;  // asked for, after all limits (ideal: ramp and motor limits off)
  int contacts = 0;
};

enum class SimulationStatus {
  kOk,
  kImageRefused,  // the scene image is not sound
  kUnknownArm,    // options.arm
  kBadRate,       // outside 100 Hz to 20 kHz
  kBadPath,     // empty, times that do not rise, not finite, an arm other than 0 or 1, or arm 1 without arm 0
  kOutOfReach,  // the path's first point is outside the arm's workspace
  kNotArmed,    // the controller refused to home or arm
  kFaulted,     // the controller tripped on the way; the rows up to there were given
};

struct SimulationResult {
  SimulationStatus status = SimulationStatus::kOk;
  std::string detail;                              // one sentence for a person; empty when ok
  std::uint64_t ticks = 0;                         // rows per arm
  std::uint32_t sweep_bound = 0, slide_bound = 0;  // the renderer's counters
};

// image: a scene image (any alignment; it is copied). path: rows of one or both arms, as read. Never throws
// for bad input.
[[nodiscard]] SimulationResult simulate(std::span<const std::byte> image, const std::vector<PathPoint>& path,
                                        const SimulationOptions& options,
                                        const std::function<void(const LogRow&)>& row);

}  // namespace thimble::board
