// Runs a scene file with the hand path of a file, for `thimble simulate` and the Python package. Failures are Errors.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <span>
#include <vector>

#include "board/sim/simulation.h"
#include "host-tools/files/image_file.h"

namespace thimble::host {

class SimulationRun {
 public:
  // scene: of load_image(), or an image from elsewhere; path: CSV time_s,x_m,y_m,z_m[,arm]. Error kBadInput, kPermission.
  SimulationRun(ImageFile scene, const std::filesystem::path& path);
  SimulationRun(ImageFile scene, std::vector<board::PathPoint> path);

  [[nodiscard]] std::span<const std::byte> image() const { return scene_.image; }
  [[nodiscard]] std::span<const std::filesystem::path> files() const {
    return scene_.files;
  }  // that the scene file names

  // Of the path: the rows are from its first time to its last.
  [[nodiscard]] double start_s() const { return start_s_; }
  [[nodiscard]] double end_s() const { return end_s_; }

  // board::simulate(); what cannot run is an Error. A run that tripped is none yet: its rows are good up to there.
  board::SimulationResult go(const board::SimulationOptions& options,
                             const std::function<void(const board::LogRow&)>& row) const;

 private:
  ImageFile scene_;
  std::vector<board::PathPoint> path_;
  double start_s_ = 0, end_s_ = 0;
};

// The Error of a run that is not kOk.
void throw_if_failed(const board::SimulationResult& result);
// Error kFaulted where the controller tripped on the way.
void throw_if_faulted(const board::SimulationResult& result);

}  // namespace thimble::host
