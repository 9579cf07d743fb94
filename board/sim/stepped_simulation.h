// A run of a scene tick by tick. simulate() (simulation.h) drives it along paths that are known; a caller that decides on the way gives each hand
// its next point. The same points give the same rows, to the bit.
//
//   SteppedSimulation run(image, options, paths);         // paths: the first point of each hand, or all of them
//   if (run.begin().status != SimulationStatus::kOk) ...  // homes, moves the hands to their first points, arms
//   run.extend(arm, point); ... run.tick(row);            // row: called for each arm; result() tells of a fault
//
// One thread. The bytes of the image are copied.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "board/sim/simulation.h"
#include "firmware/link/messages.h"

namespace thimble::board {

class SteppedSimulation {
 public:
  using RowFunction = std::function<void(const LogRow&)>;

  // paths: one for each arm, all with the same start. std::invalid_argument: as SimBoard, unless options.ideal.
  SteppedSimulation(std::span<const std::byte> image, const SimulationOptions& options,
                    std::vector<HandPath> paths);
  SteppedSimulation(const SteppedSimulation&) = delete;
  SteppedSimulation& operator=(const SteppedSimulation&) = delete;
  ~SteppedSimulation();

  // Before the first tick. Another status than kOk: nothing can be run.
  [[nodiscard]] SimulationResult begin();
  // After a tick that ends with kFaulted there is none.
  void tick(const RowFunction& row);
  // From where it is now a hand goes to this point, on a straight line; its time is later than that of the next tick's begin, time_of(result().ticks).
  void extend(std::size_t arm, const PathPoint& point);
  // Another scene, as after an upload: one that differs in materials only keeps the contacts, and one of the same name the places. The force is
  // ramped in the next ticks, but in an ideal run. Of scenes that come before the last one is taken, the newest follows it. kImageRefused: the
  // scene stays.
  [[nodiscard]] SimulationResult load(std::span<const std::byte> image);

  // A write of `event` or `trial` (firmware/core/marks.h). A tick takes one; those that wait are taken in their order. Returns the number
  // of the tick that will take it, as in time_of(); before begin() a trial acts from the first tick on.
  std::uint64_t mark(firmware::link::MarkKind kind, std::uint16_t value);

  [[nodiscard]] bool reaches(std::size_t arm, const Eigen::Vector3d& position_m) const;
  [[nodiscard]] double time_of(std::uint64_t tick) const noexcept;  // since the paths' times began
  [[nodiscard]] const SimulationResult& result() const noexcept;    // so far

  class Run;  // through the arm, or ideal

 private:
  std::unique_ptr<Run> run_;
};

}  // namespace thimble::board
