// A scan: a guarded move probes each point of the plan, and its samples are logged before the next point; then come the
// fits and the scene. Used by `thimble scan`, with a device or with the simulated arm.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "firmware/link/messages.h"
#include "host-tools/lab/scan_log.h"
#include "host-tools/lab/scan_plan.h"
#include "host-tools/lab/scan_scene.h"
#include "host-tools/lab/stiffness_fit.h"

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

// Probes the points that the log does not have. go_on() is called before each point; false ends the scan. Returns true if the log
// is complete. Error kRefused if the arm is blocked on its way to a point, and the errors of the probe; the log keeps the
// points that are complete.
[[nodiscard]] bool probe_points(const ScanPlan& plan, ScanLog& log, const std::function<Probe&()>& probe,
                                const std::function<bool(std::size_t done)>& go_on);

// One fit a point, in the plan's order. Error kRefused names points without contact.
[[nodiscard]] std::vector<StiffnessFit> fit_points(const ScanPlan& plan, const ScanLog& log);

}  // namespace thimble::host
