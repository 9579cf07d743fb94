#include "board/sim/simulation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "board/sim/stepped_simulation.h"

namespace thimble::board {
namespace {

using control::kMaxArms;

SimulationResult failure(SimulationStatus status, std::string detail) {
  SimulationResult result;
  result.status = status;
  result.detail = std::move(detail);
  return result;
}

// One path per arm, all with the same start time. Throws std::invalid_argument.
std::vector<HandPath> split(const std::vector<PathPoint>& path) {
  std::array<std::vector<PathPoint>, kMaxArms> points;
  double start_s = std::numeric_limits<double>::infinity();
  for (const PathPoint& point : path) {
    if (point.arm < 0 || point.arm >= static_cast<int>(kMaxArms)) {
      throw std::invalid_argument("the path names an arm other than 0 and 1");
    }
    points[static_cast<std::size_t>(point.arm)].push_back(point);
    start_s = std::min(start_s, point.time_s);
  }
  if (points[0].empty()) throw std::invalid_argument("the path has no point for arm 0");
  std::vector<HandPath> paths;
  for (std::vector<PathPoint>& p : points) {
    if (p.empty()) continue;
    if (p.front().time_s > start_s) {
      PathPoint wait = p.front();
      wait.time_s = start_s;
      p.insert(p.begin(), wait);
    }
    paths.emplace_back(std::move(p));
  }
  return paths;
}

std::string out_of_reach(const PathPoint& point) {
  std::ostringstream text;
  text << "the path's point at " << point.time_s << " s, (" << point.position_m.x() << ", "
       << point.position_m.y() << ", " << point.position_m.z() << ") m, is outside the workspace of arm "
       << point.arm;
  return text.str();
}

// From the first time of the paths to the last one, if that is on a tick; a thousandth of a period allows for rounding.
std::uint64_t ticks_of(const std::vector<HandPath>& paths, double rate_Hz) {
  double end_s = paths[0].start_s();
  for (const HandPath& path : paths) end_s = std::max(end_s, path.end_s());
  return static_cast<std::uint64_t>(std::floor((end_s - paths[0].start_s()) * rate_Hz + 1e-3)) + 1;
}

}  // namespace

SimulationResult checked(const SimulationOptions& options) {
  if (!(options.rate_Hz >= 100 && options.rate_Hz <= 20000)) {
    return failure(SimulationStatus::kBadRate, "the rate is not within 100 Hz to 20 kHz");
  }
  if (!options.arm_data && find_plant_variant(options.arm) == nullptr) {
    return failure(SimulationStatus::kUnknownArm, "there is no simulated arm named " + options.arm);
  }
  return {};
}

SimulationResult simulate(std::span<const std::byte> image, const std::vector<PathPoint>& path,
                          const SimulationOptions& options, const std::function<void(const LogRow&)>& row) {
  if (SimulationResult wrong = checked(options); wrong.status != SimulationStatus::kOk) return wrong;
  std::vector<HandPath> paths;
  try {
    paths = split(path);
  } catch (const std::invalid_argument& error) {
    return failure(SimulationStatus::kBadPath, error.what());
  }
  const std::uint64_t ticks = ticks_of(paths, options.rate_Hz);
  SteppedSimulation run(image, options, std::move(paths));
  for (const PathPoint& point : path) {
    if (!run.reaches(static_cast<std::size_t>(point.arm), point.position_m))
      return failure(SimulationStatus::kOutOfReach, out_of_reach(point));
  }
  if (SimulationResult begun = run.begin(); begun.status != SimulationStatus::kOk) return begun;
  while (run.result().ticks < ticks && run.result().status == SimulationStatus::kOk) run.tick(row);
  return run.result();
}

}  // namespace thimble::board
