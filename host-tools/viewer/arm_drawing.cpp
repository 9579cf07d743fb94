#include "host-tools/viewer/arm_drawing.h"

#include <cmath>

namespace thimble::host {

Json ArmDrawing::lines(const std::vector<double>& axes, const std::array<double, 3>& tip_m) {
  if (!pose_.move_to(axes)) return {};
  const Eigen::Vector3d shift_m = Eigen::Vector3d(tip_m[0], tip_m[1], tip_m[2]) - pose_.tip_m();
  Json lines = Json::array();
  for (const ArmPose::Line& line : pose_.links()) {
    Json points = Json::array();
    for (const Eigen::Vector3d& point : line) {
      const Eigen::Vector3d at_m = point + shift_m;
      Json numbers = Json::array();
      for (const double number : at_m) numbers.push_back(std::round(number * 1e4) / 1e4);
      points.push_back(std::move(numbers));
    }
    lines.push_back(std::move(points));
  }
  return lines;
}

}  // namespace thimble::host
