#include "host-tools/compiler/shape_mass.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "control/scene/mesh_triangle.h"

namespace thimble::host {
namespace {

using Corners = std::array<Eigen::Vector3d, 3>;

Eigen::Vector3d position(const scene::Vertex& vertex) {
  const scene::Vec3& p = vertex.position_m();
  return Eigen::Vector3f(p.x(), p.y(), p.z()).cast<double>();
}

Eigen::AlignedBox3d box_of(const CompiledMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const scene::Vertex& vertex : mesh.vertices) box.extend(position(vertex));
  return box;
}

// Sums over simplexes that each triangle is a face of. With `weight` the volume or area of a simplex with n corners, one of which may be
// the origin, and s the sum of the corners: the first moment is weight s / n, the second weight (sum of c c^T + s s^T) / (n (n + 1))
// (Tonon 2004).
struct Sums {
  double weight = 0.0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
};

template <typename Weight>
Sums sum(const CompiledMesh& mesh, const Eigen::Vector3d& origin_m, double n, Weight&& weight_of) {
  Sums sums;
  for (const scene::Triangle& triangle : mesh.triangles) {
    Corners c;
    for (std::uint32_t i = 0; i < 3; ++i)
      c.at(i) = position(mesh.vertices[control::vertex_of(triangle, i)]) - origin_m;
    const double weight = weight_of(c);
    const Eigen::Vector3d s = c[0] + c[1] + c[2];
    sums.weight += weight;
    sums.first += weight / n * s;
    sums.second += weight / (n * (n + 1.0)) * (s * s.transpose());
    for (const Eigen::Vector3d& corner : c)
      sums.second += weight / (n * (n + 1.0)) * (corner * corner.transpose());
  }
  return sums;
}

Eigen::Matrix3d inertia_of_point(const Eigen::Vector3d& at_m) {
  return at_m.squaredNorm() * Eigen::Matrix3d::Identity() - at_m * at_m.transpose();
}

ShapeMass mass_of(const Sums& sums, const Eigen::Vector3d& origin_m) {
  const Eigen::Vector3d centre_m = sums.first / sums.weight;
  const Eigen::Matrix3d second = sums.second / sums.weight - centre_m * centre_m.transpose();
  return {origin_m + centre_m, second.trace() * Eigen::Matrix3d::Identity() - second};
}

}  // namespace

std::optional<ShapeMass> volume_mass(const CompiledMesh& mesh) {
  if (mesh.report.open_edges > 0) return std::nullopt;
  const Eigen::AlignedBox3d box = box_of(mesh);
  const Eigen::Vector3d origin_m = box.center();  // near the mesh, so that large numbers do not cancel
  const Sums sums =
      sum(mesh, origin_m, 4.0, [](const Corners& c) { return c[0].dot(c[1].cross(c[2])) / 6.0; });
  constexpr double kThin = 1.0e-6;
  const double size_m = box.diagonal().norm();
  if (!(std::abs(sums.weight) > kThin * size_m * size_m * size_m)) return std::nullopt;
  return mass_of(sums, origin_m);
}

ShapeMass surface_mass(const CompiledMesh& mesh) {
  const Eigen::Vector3d origin_m = box_of(mesh).center();
  return mass_of(sum(mesh, origin_m, 3.0,
                     [](const Corners& c) { return (c[1] - c[0]).cross(c[2] - c[0]).norm() / 2.0; }),
                 origin_m);
}

Eigen::Matrix3d inertia_about(const ShapeMass& mass, const Eigen::Vector3d& point_m) {
  return mass.inertia_m2 + inertia_of_point(point_m - mass.centre_m);
}

PrincipalInertia principal_inertia(const Eigen::Matrix3d& inertia) {
  constexpr double kRounding = 1.0e-6;  // of float vertices
  const Eigen::Vector3d along_axes = inertia.diagonal();
  const Eigen::Vector3d products(inertia(0, 1), inertia(1, 2), inertia(2, 0));
  if (products.cwiseAbs().maxCoeff() <= kRounding * along_axes.maxCoeff()) return {along_axes};
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) *= -1.0;
  return {solver.eigenvalues(), Eigen::Quaterniond(axes).normalized()};
}

}  // namespace thimble::host
