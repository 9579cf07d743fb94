// An object that the simulated arm can scan: a compliant surface of known shape, stiffness, damping and friction. It pushes on the tip
// along the normal of the nearest point of its surface with F = K(u, v) g(depth) - B speed, never pulls, and has no inertia.
//
//   shape      heights on a grid over a plane, with C1 cubic interpolation (Catmull-Rom); outside the grid the border's values apply
//   layers     g(depth) is the depth in the upper layer; below the depth of a layer its slope is the layer's ratio
//   friction   a spring of stiffness K holds the tip to the point of the surface where it sticks. Beyond mu_s times the normal force the
//              tip slides, and the force along the surface is mu_d times the normal force until the tip stops or turns
//
// Used by the simulated arm (Plant::set_specimen) and as the reference in tests of the scan. The only loop has kFootSteps steps.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace thimble::board {

struct SpecimenLayer {
  double depth_m = 0;          // where it begins, along the normal
  double stiffness_ratio = 1;  // its stiffness over that of the upper layer
};

struct SpecimenMap {
  // Position of the first grid point; u and v are perpendicular unit vectors, u x v points out of the
  // surface.
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d u = Eigen::Vector3d::UnitX();
  Eigen::Vector3d v = Eigen::Vector3d::UnitY();
  double cell_m = 0;
  std::size_t columns = 0, rows = 0;  // number of points, each at least 2
  std::vector<double> stiffness_N_m;  // of the upper layer; u fastest; bilinear between the points
  std::vector<double> height_m;       // along u x v; empty: flat
  double damping_N_s_m = 0;
  double static_friction = 0, dynamic_friction = 0;  // dynamic at most static
  std::vector<SpecimenLayer> layers;                 // below the upper one, in order of depth
};

// Where the tip sticks to the specimen. The caller keeps it, one for each tip.
struct SpecimenGrip {
  bool touching = false;
  bool sliding = false;
  Eigen::Vector3d anchor_m = Eigen::Vector3d::Zero();  // the point of the surface that holds the tip
};

class Specimen {
 public:
  // Throws std::invalid_argument with a sentence if the map is not valid.
  explicit Specimen(SpecimenMap map);

  // The force on the tip. grip: as the last update() left it.
  [[nodiscard]] Eigen::Vector3d force_N(const Eigen::Vector3d& tip_m, const Eigen::Vector3d& velocity_m_s,
                                        const SpecimenGrip& grip = {}) const noexcept;
  // Whether the tip sticks or slides; called after each step of time.
  void update(const Eigen::Vector3d& tip_m, const Eigen::Vector3d& velocity_m_s,
              SpecimenGrip& grip) const noexcept;

  // Values at the grid position below the point.
  [[nodiscard]] double stiffness_N_m(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] double height_m(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] Eigen::Vector3d normal_at(const Eigen::Vector3d& point_m) const noexcept;  // of the surface
  [[nodiscard]] const Eigen::Vector3d& normal() const noexcept { return normal_; }         // u x v
  // Force of the springs at this depth over the stiffness of the upper layer.
  [[nodiscard]] double layered_depth_m(double depth_m) const noexcept;
  [[nodiscard]] const SpecimenMap& map() const noexcept { return map_; }
  [[nodiscard]] bool has_friction() const noexcept { return map_.static_friction > 0; }

 private:
  struct Cell {
    std::size_t column, row;  // of the corner with the lowest u and v
    double fu, fv;            // 0 to 1 within the cell
    bool inside_u, inside_v;
  };
  struct Height {
    double value_m, du, dv;  // and its slopes
  };
  struct Contact {
    Eigen::Vector3d foot_m;  // the nearest point of the surface
    Eigen::Vector3d normal;
    double depth_m;  // not above 0: no contact
  };
  [[nodiscard]] Cell cell_at(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] Height height_at(const Eigen::Vector3d& point_m) const noexcept;
  [[nodiscard]] Contact contact_at(const Eigen::Vector3d& tip_m) const noexcept;
  [[nodiscard]] double normal_force_N(const Contact& contact,
                                      const Eigen::Vector3d& velocity_m_s) const noexcept;

  SpecimenMap map_;
  Eigen::Vector3d normal_;
  double highest_m_ = 0;  // nothing of the specimen is above it
};

}  // namespace thimble::board
