// The parts of a potential problem: its bodies, its grid, and what a cache knows it by.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "host-tools/compiler/potential_solver.h"

namespace thimble::host {

using Eigen::Vector3d;

double Solid::distance_m(const Vector3d& world) const {
  const Vector3d p = rotation.conjugate() * (world - position_m);
  const auto outside_of = [](const auto& over) {  // the distance from how far each bound is overstepped
    return over.cwiseMax(0.0).norm() + std::min(over.maxCoeff(), 0.0);
  };
  switch (kind) {
    case Kind::kSphere:
      return p.norm() - radius_m;
    case Kind::kBox:
      return outside_of(Vector3d(p.cwiseAbs() - half_size_m));
    case Kind::kCylinder:
      return outside_of(Eigen::Vector2d(p.head<2>().norm() - radius_m, std::abs(p.z()) - half_height_m));
    case Kind::kCapsule:
      return (p - std::clamp(p.z(), -half_height_m, half_height_m) * Vector3d::UnitZ()).norm() - radius_m;
  }
  return 0.0;
}

Vector3d Solid::reach_m() const {
  switch (kind) {
    case Kind::kSphere:
      return Vector3d::Constant(radius_m);
    case Kind::kBox:
      return half_size_m;
    case Kind::kCylinder:
      return {radius_m, radius_m, half_height_m};
    case Kind::kCapsule:
      return {radius_m, radius_m, half_height_m + radius_m};
  }
  return Vector3d::Zero();
}

Vector3d Grid::point(std::size_t index) const {
  const std::size_t x = index % count[0];
  const std::size_t y = index / count[0] % count[1];
  const std::size_t z = index / count[0] / count[1];
  return origin_m + step_m * Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
}

std::string potential_key(const PotentialProblem& problem) {
  std::string key = "potential " + std::to_string(kPotentialVersion) + "\n";
  const auto add = [&key](double value) {
    std::array<char, sizeof value> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    key.append(bytes.data(), bytes.size());
  };
  const auto add_solid = [&add](const Solid& solid) {
    add(static_cast<double>(solid.kind));
    add(solid.radius_m);
    add(solid.half_height_m);
    for (const double each : solid.half_size_m) add(each);
    for (const double each : solid.position_m) add(each);
    for (const double each : solid.rotation.coeffs()) add(each);
  };
  add(problem.step_m);
  add(problem.source);
  add_solid(problem.shape);
  add(static_cast<double>(problem.inclusions.size()));
  for (const PotentialProblem::Inclusion& inclusion : problem.inclusions) {
    add_solid(inclusion.solid);
    add(inclusion.potential);
  }
  for (const PotentialProblem::Region& region : problem.regions) {
    add_solid(region.solid);
    add(region.source);
  }
  return key;
}

}  // namespace thimble::host
