// The potential in a solid, for potential fields (paper, section 5.1): -laplace u = source with u = 0 on the surface and
// inclusions held at potentials of their own, solved on a grid, and as the tricubic B-spline that the controller evaluates.
//
// Second order at curved boundaries: an arm of the seven-point stencil that crosses a boundary ends there (Shortley and
// Weller 1938). Behind a boundary the samples go on along the grid lines with the polynomial through the boundary's value, so that
// the spline's zero level is the surface and its slope is right there; edges are rounded within about a step. So inside an inclusion
// the potential rises on for a few steps, and then is level.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace thimble::host {

// A body by its signed distance. Sizes as in the scene file.
struct Solid {
  enum class Kind { kSphere, kBox, kCylinder, kCapsule };
  Kind kind = Kind::kSphere;
  Eigen::Vector3d half_size_m = Eigen::Vector3d::Zero();  // box
  double radius_m = 0;                                    // the others
  double half_height_m = 0;                               // cylinder; capsule: to the caps' centres
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();

  [[nodiscard]] double distance_m(const Eigen::Vector3d& p) const;  // below zero inside
  [[nodiscard]] Eigen::Vector3d reach_m() const;  // half extents about its centre, not turned
};

struct PotentialProblem {
  struct Inclusion {
    Solid solid;
    double potential = 0;
    std::string place;  // for messages
  };
  struct Region {
    Solid solid;
    double source = 0;  // more of it inside
  };
  Solid shape;  // at the origin, not turned
  double step_m = 0;
  double source = 0;
  std::vector<Inclusion> inclusions;
  std::vector<Region> regions;
  std::string place;
};

// x fastest, then y, then z.
struct Grid {
  std::array<std::size_t, 3> count{};
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  double step_m = 0;

  [[nodiscard]] std::size_t size() const { return count[0] * count[1] * count[2]; }
  [[nodiscard]] Eigen::Vector3d point(std::size_t index) const;
};

struct Potential {
  Grid grid;
  std::vector<double> samples;        // u at the grid's points, as extended; below or at zero outside
  std::vector<unsigned char> inside;  // 1 where the point is in the solid
  std::vector<double> coefficients;   // of the spline through the samples
};

// The grid that the problem needs.
[[nodiscard]] Grid potential_grid(const PotentialProblem& problem);

// Throws Error (kBadInput): the grid has more points than the controller takes, or too few in the solid or an inclusion; an
// inclusion that reaches out of the solid or meets another one; nothing that raises the potential.
// `progress` is called now and then with the share of the work that is done, below 1.
[[nodiscard]] Potential solve_potential(const PotentialProblem& problem,
                                        const std::function<void(double)>& progress = {});

// Numbers that the coefficients depend on, as bytes, with the version of the method: the key of a cache. A change of the solver that changes
// a coefficient changes kPotentialVersion.
inline constexpr std::uint32_t kPotentialVersion = 2;
[[nodiscard]] std::string potential_key(const PotentialProblem& problem);

}  // namespace thimble::host
