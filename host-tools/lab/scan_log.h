// What a scan measured, in a CSV file that grows a point at a time: a scan that breaks off keeps what it has and goes
// on from there.
//
//   # thimble scan of plan <CRC-32 of the plan's text>
//   point,phase,x_m,y_m,z_m,force_N
//   0,press,...          samples on the way in, then `release` on the way back; force along the approach
//   0,force_limit,...    the point is whole: why the move turned, where, and its peak force (or `depth`: no limit met)
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

namespace thimble::host {

struct PointSample {
  bool pressing = false;
  Eigen::Vector3d tip_m = Eigen::Vector3d::Zero();
  double force_N = 0;
};

struct ProbedPoint {
  std::size_t point = 0;
  std::vector<PointSample> samples;
  bool force_limit = false;  // met before the depth
  Eigen::Vector3d turn_m = Eigen::Vector3d::Zero();
  double peak_force_N = 0;
};

class ScanLog {
 public:
  // Begins the file, or with `resume` goes on with one that is there: what follows its last whole point is cut off.
  // Error kRefused: it is there and `resume` is not given, or it cannot be written (kPermission); kBadInput: it is no
  // log of this plan.
  ScanLog(std::filesystem::path file, std::uint32_t plan_crc, std::size_t points, bool resume);

  [[nodiscard]] const std::vector<ProbedPoint>& points() const { return points_; }  // 0, 1, 2 ... in order
  void append(const ProbedPoint& measured);                                         // on disk when it returns

 private:
  void read(const std::string& text, std::uint32_t plan_crc, std::size_t points);

  std::filesystem::path file_;
  std::vector<ProbedPoint> points_;
  std::uintmax_t whole_bytes_ = 0;
  std::ofstream out_;
};

}  // namespace thimble::host
