// An object that the simulated arm can scan: a compliant surface of known stiffness. It pushes on the tip
// with F = K(u, v) depth - B speed along its normal, never pulls, and has no friction and no inertia.
// Stiffness and height are given on a grid, with bilinear interpolation; outside the grid the values at its
// border apply. Used by the simulated arm (Plant::set_specimen) and as the reference in tests of the scan.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace thimble::board {

struct SpecimenMap {
  // Position of the first grid point; u and v are perpendicular unit vectors, u x v points out of the
  // surface.
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d v = Eigen::Vector3d::UnitY();
  double cell_m = 0;
  std::size_t columns = 0, rows = 0;  // number of points, each at least 2
  std::vector<double> stiffness_N_m;  // u fastest
  std::vector<double> height_m;       // along u x v; empty: flat
  double damping_N_s_m = 0;
};

class Specimen {
 public:
  // Throws std::invalid_argument with a sentence if the map is not valid.
  explicit Specimen(SpecimenMap map);

  [[nodiscard]] Eigen::Vector3d force_N(const Eigen::Vector3d& tip_m,
                                        const Eigen::Vector3d& velocity_m_s) const noexcept;
  // Values at the grid position below the point.
  [[nodiscard]] double stiffness_N_m(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] double height_m(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] const Eigen::Vector3d& normal() const noexcept { return normal_; }
  [[nodiscard]] const SpecimenMap& map() const noexcept { return map_; }

 private:
  struct Cell {
    std::size_t first;  // index of the corner with the lowest u and v
    double fu, fv;      // 0 to 1 within the cell
    bool inside_u, inside_v;
  };
  [[nodiscard]] Cell cell_at(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] double at(const std::vector<double>& values, const Cell& cell) const noexcept;

  SpecimenMap map_;
  Eigen::Vector3d normal_;
};

}  // namespace thimble::board
