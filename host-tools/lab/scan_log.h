// What a scan measured, in a CSV file that grows a step at a time: a scan that breaks off keeps what it has and goes
// on from there.
//
//   # thimble scan of plan <CRC-32 of the plan's text>
//   point,phase,x_m,y_m,z_m,force_N
//   0,press,...          samples on the way in, then `release` on the way back; force along the way in
//   0,force_limit,...    the move is whole: why it turned, where, and its peak force (or `depth`: no limit met)
//   154,out,...          samples of a stroke, then `back`; force along the way out
//   154,target,...       the stroke is whole (or `force_limit`)
//
// `point` is the step (ScanPlan::steps). A step is whole when all its moves are: one press, or the moves of a site.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "host-tools/files/growing_file.h"
#include "host-tools/lab/scan_plan.h"

namespace thimble::host {

struct PointSample {
  bool out = false;  // on the way in, or out along a stroke
  Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();
  double force_N = 0;
};

struct ProbedMove {
  std::vector<PointSample> samples;
  bool force_limit = false;  // met before the target
  Eigen::Vector3d turn_m = Eigen::Vector3d::Zero();
  double peak_force_N = 0;
};

// The moves of a site: two presses, a slow and a fast stroke without load, and three strokes with each load.
inline constexpr std::size_t kSiteLoads = 2;
inline constexpr std::size_t kSitePresses = 2;
inline constexpr std::size_t kFreeSlow = kSitePresses, kFreeFast = kFreeSlow + 1;
enum class Stroke : std::uint8_t { kSlowOut, kSlowBack, kFast };
inline constexpr std::size_t kSiteStrokes = 3;
inline constexpr std::size_t kSiteMoves = kFreeFast + 1 + kSiteLoads * kSiteStrokes;
[[nodiscard]] constexpr std::size_t site_move(std::size_t load, Stroke stroke) {
  return kFreeFast + 1 + load * kSiteStrokes + static_cast<std::size_t>(stroke);
}

struct ProbedStep {
  std::size_t step = 0;
  std::vector<ProbedMove> moves;
};

class ScanLog {
 public:
  // Begins the file, or with `resume` goes on with one that is there: what follows its last whole step is cut off.
  // Error kRefused: it is there and `resume` is not given, or it cannot be written (kPermission); kBadInput: it is no
  // log of this plan.
  ScanLog(std::filesystem::path file, const ScanPlan& plan, bool resume);

  [[nodiscard]] const std::vector<ProbedStep>& steps() const {
    return steps_;
  }                                                              // in order, without gaps among the points
  [[nodiscard]] const ProbedStep* find(std::size_t step) const;  // null: not probed
  void append(const ProbedStep& measured);                       // on disk when it returns

 private:
  void read(const std::string& text, const ScanPlan& plan);

  std::filesystem::path file_;
  std::size_t sites_from_;
  std::vector<ProbedStep> steps_;
  std::uintmax_t whole_bytes_ = 0;
  GrowingFile out_;
};

}  // namespace thimble::host
