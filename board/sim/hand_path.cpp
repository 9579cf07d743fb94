#include "board/sim/hand_path.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace thimble::board {

HandPath::HandPath(std::vector<PathPoint> points) : points_(std::move(points)) {
  if (points_.empty()) throw std::invalid_argument("the path has no points");
  for (std::size_t k = 0; k < points_.size(); ++k) {
    if (!std::isfinite(points_[k].time_s) || !points_[k].position_m.allFinite()) {
      throw std::invalid_argument("a number of the path is not finite");
    }
    if (k > 0 && points_[k].time_s <= points_[k - 1].time_s) {
      throw std::invalid_argument("the times of the path do not increase");
    }
  }
}

void HandPath::extend(const PathPoint& point, double from_s) {
  if (!std::isfinite(point.time_s) || !point.position_m.allFinite())
    throw std::invalid_argument("a number of the path is not finite");
  if (!(point.time_s > std::max(from_s, start_s())))
    throw std::invalid_argument("the times of the path do not increase");
  if (from_s != end_s()) {
    const Eigen::Vector3d position_m = at(from_s).position_m;
    while (points_.size() > 1 && points_.back().time_s >= from_s) points_.pop_back();
    if (from_s > end_s()) points_.push_back({from_s, position_m, point.arm});
  }
  points_.push_back(point);
  constexpr std::size_t kKept =
      4;  // the start, and two segments: a tick may be before their common point by rounding
  while (points_.size() > kKept) points_.erase(points_.begin() + 1);
}

HandPath::Sample HandPath::at(double time_s) const noexcept {
  if (time_s < start_s()) return {points_.front().position_m, Eigen::Vector3d::Zero()};
  if (time_s > end_s() || points_.size() == 1) return {points_.back().position_m, Eigen::Vector3d::Zero()};
  auto after = std::upper_bound(points_.begin() + 1, points_.end() - 1, time_s,
                                [](double t, const PathPoint& p) { return t < p.time_s; });
  const PathPoint& b = *after;
  const PathPoint& a = *(after - 1);
  const double s = (time_s - a.time_s) / (b.time_s - a.time_s);
  return {a.position_m + s * (b.position_m - a.position_m),
          (b.position_m - a.position_m) / (b.time_s - a.time_s)};
}

}  // namespace thimble::board
