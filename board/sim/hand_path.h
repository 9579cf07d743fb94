// The path of a hand: positions at times, with linear interpolation. Used by `thimble simulate` and by the
// hand of the simulated arm.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace thimble::board {

struct PathPoint {
  double time_s = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // world frame
  int arm = 0;
};

class HandPath {
 public:
  struct Sample {
    Eigen::Vector3d position_m;
    Eigen::Vector3d velocity_m_s;
  };

  // points: at least one, all of one arm, times strictly increasing. Throws std::invalid_argument otherwise.
  explicit HandPath(std::vector<PathPoint> points);

  // Before the first and after the last point the hand is at rest. At a point the velocity is that of the
  // following segment, at the last point that of the preceding one.
  [[nodiscard]] Sample at(double time_s) const noexcept;

  // From where the hand is at from_s it goes to this point; what the path had after from_s is dropped. Of the earlier points it keeps the first
  // one, and those that at() needs from the end of the last segment on. std::invalid_argument: not finite, or not later than from_s and the start.
  void extend(const PathPoint& point, double from_s);

  [[nodiscard]] double start_s() const noexcept { return points_.front().time_s; }
  [[nodiscard]] double end_s() const noexcept { return points_.back().time_s; }

 private:
  std::vector<PathPoint> points_;
};

}  // namespace thimble::board
