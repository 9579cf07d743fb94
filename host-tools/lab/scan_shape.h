// The shape that a scan found: heights over the plan's plane, interpolated between the points of contact. A polynomial of second degree
// in u and v follows the curvature as a whole, also at the border; a cubic spline interpolates the rest. Used to aim presses along the
// normal, and to write the height field of the scene.
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "host-tools/lab/scan_plan.h"

namespace thimble::host {

class ScannedShape {
 public:
  // contacts_m: points of the surface, in the plan's order of points. Each is less than half a cell from its place on the grid, seen
  // along u x v.
  ScannedShape(const ScanPlan& plan, std::span<const Eigen::Vector3d> contacts_m);

  // at: in cells from the first point, along u and v. Beyond the grid the shape continues straight, with the polynomial's curvature.
  [[nodiscard]] double height_m(const Eigen::Vector2d& at) const;
  [[nodiscard]] Eigen::Vector3d place_m(const Eigen::Vector2d& at) const;
  [[nodiscard]] Eigen::Vector3d normal(const Eigen::Vector2d& at) const;
  [[nodiscard]] Eigen::Vector2d below(const Eigen::Vector3d& point_m) const;  // seen along u x v
  [[nodiscard]] double above_m(const Eigen::Vector3d& point_m) const;         // along u x v
  [[nodiscard]] double depth_m(
      const Eigen::Vector3d& point_m) const;  // along the normal, as of a tangent plane
  // How far the shape is off the contacts: the rest that the iteration leaves.
  [[nodiscard]] double residual_m() const { return residual_m_; }

 private:
  struct Sample {
    double value_m = 0;
    Eigen::Vector2d slope = Eigen::Vector2d::Zero();  // per metre
  };
  static constexpr std::size_t kTerms = 6;
  [[nodiscard]] std::array<double, kTerms> terms(const Eigen::Vector2d& at) const;
  [[nodiscard]] Sample sample(const Eigen::Vector2d& at) const;

  ScanPlan plan_;
  Eigen::Vector3d up_;
  std::array<double, kTerms> polynomial_{};  // 1, u, v, u v, u^2, v^2, from the middle of the grid, in cells
  std::vector<double> control_;              // of the spline of the rest
  double residual_m_ = 0;
};

}  // namespace thimble::host
