// A scan: guarded moves probe each point of the plan, and their samples are logged before the next point. Used by `thimble scan`, with
// a device or with the simulated arm.
//
//   1  each point along the plan's approach: the shape
//   2  again along the normal of that shape, where it leans more than kAligned from the approach: then friction does not act, and the
//      stiffness is that along the normal
//   3  at the sites of the plan two presses of unlike speed, and strokes along the surface without load and with two loads: damping and
//      friction
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/link/messages.h"
#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_plan.h"
#include "host-tools/lab/scan_result.h"

namespace thimble::host {

// What makes the moves: a device on the link, or the simulated arm.
class Probe {
 public:
  struct Result {
    firmware::link::MoveState state;
    std::vector<firmware::link::MoveSample> samples;
  };
  virtual ~Probe() = default;
  // Moves from the position where the arm holds; returns when it holds again. Throws Error.
  virtual Result move(const firmware::link::MoveOrder& order) = 0;
};

// Probes the steps that the log does not have. go_on() is called before each; false ends the scan. Returns true if the log
// is complete. Error kRefused if the arm is blocked on its way to a point, or a point is not felt, and the errors of the probe; the log
// keeps the steps that are complete.
[[nodiscard]] bool probe_steps(const ScanPlan& plan, ScanLog& log, const std::function<Probe&()>& probe,
                               const std::function<bool(std::size_t done)>& go_on);

}  // namespace thimble::host
