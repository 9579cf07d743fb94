// What is measured of a simulation: forces, contacts, work, and whether the tip is still at the end. Sums over the rows of the run; all arms
// together where nothing else is said.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "board/sim/simulation.h"

namespace thimble::host {

// Two counts of the encoders of the Premium, at the tip.
inline constexpr double kTwoCounts_m = 59e-6;

struct MeasuredRun {
  std::vector<std::byte> image;
  std::vector<board::PathPoint> path;
  board::SimulationOptions options;
  // The steady part: from this time to the end of the path, where the hand rests. Infinity: there is none.
  double steady_from_s = std::numeric_limits<double>::infinity();
  // Direction that swings are measured along. None: of the three coordinates the one with the largest swing, and forces by their amount.
  std::optional<Eigen::Vector3d> along{};
};

struct Measured {
  board::SimulationStatus status = board::SimulationStatus::kOk;
  std::string detail;  // one sentence where the status is another
  double peak_force_N = 0;
  double mean_force_N = 0;    // over the rows in contact
  double contact_s = 0;       // the sum of the arms' times
  double contacts_lost = 0;   // how often a tip touched something, and nothing in the next tick
  double work_J = 0;          // of the rendered force: above 0 where the scene gave more than it took
  double steady_force_N = 0;  // mean over the steady part, like all below; of several arms the largest
  double force_swing_N = 0;   // peak to peak
  double tip_swing_m = 0;     // peak to peak
  double tip_speed_rms_m_s = 0;

  [[nodiscard]] bool is_ok() const { return status == board::SimulationStatus::kOk; }
  // No fault, and the tip swings by no more than `most_m` in the steady part.
  [[nodiscard]] bool is_still(double most_m = kTwoCounts_m) const { return is_ok() && tip_swing_m <= most_m; }
};

// The columns of results.
struct MeasureColumn {
  std::string_view name;
  double Measured::*value;
  bool is_steady;  // there is none without a steady part
};
[[nodiscard]] std::span<const MeasureColumn> measure_columns();
inline constexpr std::string_view kStable = "stable";  // behind them

// go_on: asked in each tick; an exception that it throws ends the run, and is thrown on.
[[nodiscard]] Measured measure(
    const MeasuredRun& run, const std::function<void()>& go_on = [] {});

}  // namespace thimble::host
