// A scan: the plan's points one after another, each probed with a guarded move, each in the log before the next; then
// the fits, and the scene. Used by `thimble scan`, against a device or against the simulated arm.
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
  // From where the arm holds; returns when it holds again. Throws Error.
  virtual Result move(const firmware::link::MoveOrder& order) = 0;
};

// Probes what the log does not have. Before each point `go_on` is asked: false breaks off. True: the log is whole.
// Throws Error kRefused when the arm meets something on its way to a point, and what the probe throws; the log keeps
// what it has.
[[nodiscard]] bool probe_points(const ScanPlan& plan, ScanLog& log, const std::function<Probe&()>& probe,
                                const std::function<bool(std::size_t done)>& go_on);

// One fit a point, in the plan's order. Error kRefused names points without contact.
[[nodiscard]] std::vector<StiffnessFit> fit_points(const ScanPlan& plan, const ScanLog& log);

}  // namespace thimble::host
