// A hand's path: points in time, straight lines between them. Used by `thimble simulate` and by the simulated
// arm's hand.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace thimble::board {

struct PathPoint {
  double time_s = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // in the world
  int arm = 0;
};

class HandPath {
 public:
  struct Sample {
    Eigen::Vector3d position_m;
    Eigen::Vector3d velocity_m_s;
  };

  // points: of one arm, at least one, times strictly rising. Throws std::invalid_argument otherwise.
  explicit HandPath(std::vector<PathPoint> points);

  // Before the first point and after the last the hand rests there. At a point the velocity is that of the
  // line that begins there, at the last point that of the line that ends there.
  [[nodiscard]] Sample at(double time_s) const noexcept;

  [[nodiscard]] double start_s() const noexcept { return points_.front().time_s; }
  [[nodiscard]] double end_s() const noexcept { return points_.back().time_s; }

 private:
  std::vector<PathPoint> points_;
};

}  // namespace thimble::board
